#include "common/pipeline/cell_groups.hpp"

#include <numeric>
#include <optional>
#include <set>
#include <variant>

#include "common/base/id_table.hpp"
#include "common/base/pacer.hpp"
#include "common/pipeline/kept_space.hpp"
#include "common/rough/roughen.hpp"
#include "common/sites/part_shares.hpp"

namespace fracture {
namespace {

/// The region to keep, with a margin that contains the polyhedron by which it was cut out (kept_space.hpp).
Region around(Region region, const Box& box) {
  if (region.shape == Region::Shape::kSphere) {
    region.radius *= kSphereReach;
    return region;
  }
  const double margin = 0x1p-16 * box.longest_side();
  region.box.min = region.box.min - Vec3d{margin, margin, margin};
  region.box.max = region.box.max + Vec3d{margin, margin, margin};
  return region;
}

}  // namespace

std::vector<std::uint32_t> groups_of_sites(const Tetrahedralization& t,
                                           const std::vector<std::uint32_t>& groups_of_input,
                                           const Execution& execution) {
  if (groups_of_input.empty()) return {};
  Pacer pacer(execution);
  std::vector<const std::uint32_t*> given(t.site_count(), nullptr);
  for (std::size_t k = groups_of_input.size(); k-- > 0;) {  // the first of several merged points decides
    pacer.step();
    if (t.site_of_input[k] != kNoSite) given[t.site_of_input[k]] = &groups_of_input[k];
  }
  IdTable first;  // per given group: its lowest site
  std::vector<std::uint32_t> groups(t.site_count());
  for (const SiteId s : ids<SiteId>(t.site_count())) {
    pacer.step(4);
    groups[s] = s;
    if (!given[s]) continue;
    std::uint32_t& lowest = first.slot(*given[s]);
    if (lowest == IdTable::kEmpty) lowest = s;
    groups[s] = lowest;
  }
  return groups;
}

std::vector<double> weights_of_parts(const Solid& solid, const FractureParameters& parameters,
                                     const std::vector<Vec3d>& impacts, const Execution& execution) {
  if (!parameters.size.any() || impacts.empty() || solid.parts.size() < 2) return {};
  SitePattern pattern = parameters.pattern;
  std::visit(
      [&](auto& p) {
        if constexpr (requires { p.impacts; }) p.impacts = impacts;
      },
      pattern);
  const std::optional<PartShares> shares = shares_of_parts(solid, pattern, execution);
  if (!shares) return {};
  std::vector<double> weights;
  for (std::size_t p = 0; p < solid.parts.size(); ++p)
    weights.push_back(shares->share[p] * solid.report.volume / solid.parts[p].volume);
  return weights;
}

std::vector<SiteId> kept_cells(const SeenSolid& seen, const VoronoiDiagram& diagram,
                               const FractureParameters& parameters, const Execution& execution) {
  if (!parameters.keep || parameters.dual != Dual::kCircumcenter) return {};
  const KeptSpace space(*parameters.keep, seen);
  std::vector<SiteId> kept;
  Pacer pacer(execution);
  for (const SiteId s : ids<SiteId>(diagram.dual().site_count())) {
    pacer.step(4);
    if (space.holds(diagram.site(s))) kept.push_back(s);
  }
  return kept;
}

std::vector<SiteId> cells_near_kept(const SeenSolid& seen, const VoronoiDiagram& diagram,
                                    const FractureParameters& parameters, const Execution& execution) {
  if (!parameters.keep) return {};
  std::vector<Movement> movements;
  if (parameters.roughness.amplitude > 0)
    movements = movements_of_cuts(seen.original(), parameters.roughness, diagram.map());
  return cells_meeting(*parameters.keep, diagram, seen.seen().box, execution, movements);
}

void spare_region(const Solid& solid, const FractureParameters& parameters, HitCells& cells,
                  const Execution& execution) {
  if (!parameters.keep) return;
  const SeenSolid seen(solid, cells.map, execution);
  const VoronoiDiagram diagram(cells.dual, cells.image, cells.map, execution);
  for (const SiteId s : cells_meeting(*parameters.keep, diagram, seen.seen().box, execution))
    cells.groups[s] = 0;
  if (!(parameters.roughness.amplitude > 0)) return;
  FractureParameters spares = parameters;
  spares.keep = around(*parameters.keep, solid.box);
  cells.flat.assign(cells.dual.site_count(), Restraint::kNone);
  for (const SiteId s : cells_near_kept(seen, diagram, spares, execution)) cells.flat[s] = Restraint::kFlat;
}

Restraints flat_near_kept(const SeenSolid& seen, const VoronoiDiagram& diagram,
                          const FractureParameters& parameters, const std::vector<SiteId>& kept,
                          const Execution& execution) {
  if (kept.empty() || !(parameters.roughness.amplitude > 0)) return {};
  Restraints flat(diagram.dual().site_count(), Restraint::kNone);
  for (const SiteId s : cells_near_kept(seen, diagram, parameters, execution)) flat[s] = Restraint::kFlat;
  for (const SiteId s : kept) flat[s] = Restraint::kFlat;
  return flat;
}

void keep_together(std::uint32_t sites, const std::vector<SiteId>& kept, std::vector<std::uint32_t>& groups) {
  if (kept.size() < 2) return;
  if (groups.empty()) {
    groups.resize(sites);
    std::iota(groups.begin(), groups.end(), 0u);
  }
  std::set<std::uint32_t> joined;
  for (const SiteId s : kept) joined.insert(groups[s]);
  for (std::uint32_t& g : groups)
    if (joined.contains(g)) g = *joined.begin();
}

}  // namespace fracture
