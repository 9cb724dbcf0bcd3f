#include "common/pipeline/before_hits.hpp"

#include <algorithm>
#include <numeric>
#include <set>
#include <utility>

#include "common/base/id_table.hpp"
#include "common/base/pacer.hpp"
#include "common/fragment/unite.hpp"
#include "common/pipeline/aggregate.hpp"
#include "common/pipeline/kept_space.hpp"
#include "common/pipeline/part_contacts.hpp"
#include "common/pipeline/split_large.hpp"
#include "common/rough/roughen.hpp"
#include "common/sites/part_shares.hpp"
#include "common/sites/request_places.hpp"
#include "common/solid/image.hpp"

namespace fracture {

namespace {

/// Rough cuts take less than half of nearly every piece that is as small as the limit. So with this factor
/// little is united after the noise, and hits stay local. Of 252 results (seven assets, nine rough
/// materials), 31 united something then without this factor, and none with it.
constexpr double kTakenByNoise = 2;
/// The factor applies only up to this limit: larger limits are requests for larger fragments.
constexpr double kCrumbs = 0.05;

/// Returns the pattern's diagram, including the further sites of max_volume.
Expected<Diagram> without_hits(const SeenSolid& seen, const FractureParameters& parameters, SitePlan& plan,
                               const Execution& execution) {
  Expected<Tetrahedralization> t = tetrahedralize(plan.points, seen.seen().box, execution);
  if (!t) return tl::unexpected(t.error());
  Diagram before{.sites = std::move(plan.points),
                 .map = plan.map,
                 .tetrahedralization = std::move(*t),
                 .clearance = plan.clearance};
  if (parameters.max_volume > 0) {
    Expected<SplitFigures> split = split_large(seen, before, parameters, execution);
    if (!split) return tl::unexpected(split.error());
    before.split = *split;
  }
  return before;
}

/// Returns, per owner of the pattern alone, the lowest of its cells, numbered as in the whole diagram. The
/// whole has fewer of the pattern's sites, because some are farther from the solid's box than the sites of
/// a hit. kNoSite: a cell that was within the solid no longer exists.
std::vector<SiteId> lowest_in_the_whole(const RestrictedDiagram& restricted, const Tetrahedralization& alone,
                                        const Ownership& ownership, const Tetrahedralization& whole,
                                        const Execution& execution) {
  Pacer pacer(execution);
  std::vector<SiteId> now(alone.site_count(), kNoSite);
  pacer.each(0, alone.site_of_input.size(), [&](std::size_t k) {
    if (const SiteId s = alone.site_of_input[k]; s != kNoSite && now[s] == kNoSite)
      now[s] = whole.site_of_input[k];
  });
  // A cell's share of the solid is bounded by caps, or is all of a part.
  std::vector<char> is_inside(alone.site_count(), 0);
  for (const CapRegion& cap : restricted.caps.regions) {
    pacer.step();
    is_inside[cap.lo] = is_inside[cap.hi] = 1;
  }
  pacer.each(0, restricted.cuts.label.size(),
             [&](std::size_t v) { is_inside[restricted.cuts.label[v]] = 1; });
  std::vector<SiteId> lowest;
  for (const std::vector<SiteId>& cells : ownership.sites_of_owner) {
    pacer.step(1 + cells.size());
    SiteId least = kNoSite;
    bool is_whole = true;
    for (const SiteId s : cells) {
      least = std::min(least, now[s]);
      is_whole = is_whole && (now[s] != kNoSite || !is_inside[s]);
    }
    lowest.push_back(is_whole ? least : kNoSite);
  }
  return lowest;
}

}  // namespace

Expected<SplitFigures> split_before_hits(const SeenSolid& seen, const FractureParameters& parameters,
                                         SitePlan& plan, const Execution& execution) {
  const Allowance::Temporary temporary(execution.allowance);
  Expected<Diagram> before = without_hits(seen, parameters, plan, execution);
  if (!before) return tl::unexpected(before.error());
  plan.points = std::move(before->sites);
  return before->split;
}

Expected<SplitFigures> aggregate_before_hits(const SeenSolid& seen, const FractureParameters& parameters,
                                             SitePlan& plan, const Execution& execution) {
  const Allowance::Temporary temporary(execution.allowance);
  Expected<Diagram> made = without_hits(seen, parameters, plan, execution);
  if (!made) return tl::unexpected(made.error());
  Diagram& before = *made;
  canonicalize(before.tetrahedralization, execution);
  const Tetrahedralization& all = before.tetrahedralization;
  const VoronoiDiagram voronoi(all, seen.seen().box, before.map, execution);
  const std::vector<std::uint32_t> groups =
      aggregate(restrict_to_solid(seen, voronoi, execution), parameters, impacts_of(parameters.pattern),
                kept_cells(seen, voronoi, parameters, execution), execution);
  std::uint32_t next = all.site_count();  // larger than every group number
  for (const SiteId s : all.site_of_input) plan.groups.push_back(s == kNoSite ? next++ : groups[s]);
  plan.points = std::move(before.sites);
  return before.split;
}

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

Restraints flat_near_kept(const SeenSolid& seen, const VoronoiDiagram& diagram,
                          const FractureParameters& parameters, const std::vector<SiteId>& kept,
                          const Execution& execution) {
  if (kept.empty() || !(parameters.roughness.amplitude > 0)) return {};
  Restraints flat(diagram.dual().site_count(), Restraint::kNone);
  const std::vector<Movement> movements =
      movements_of_cuts(seen.original(), parameters.roughness, diagram.map());
  for (const SiteId s : cells_meeting(*parameters.keep, diagram, seen.seen().box, execution, movements))
    flat[s] = Restraint::kFlat;
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

std::uint32_t sites_of_pattern(const Diagram& diagram) {
  std::uint32_t count = 0;
  for (std::size_t k = 0; k < diagram.of_pattern; ++k)
    if (const SiteId s = diagram.tetrahedralization.site_of_input[k]; s != kNoSite)
      count = std::max(count, s + 1u);
  return count;
}

SizeLimits limits_of_flat_pieces(const FractureParameters& parameters) {
  SizeLimits limits = parameters.size;
  limits.max_triangles = 0;
  if (parameters.roughness.amplitude > 0)
    limits.min_of_mean = std::max(limits.min_of_mean, std::min(kTakenByNoise * limits.min_of_mean, kCrumbs));
  return limits;
}

Expected<std::vector<Union>> unions_before_hits(const SeenSolid& seen, const Diagram& diagram,
                                                const FractureParameters& parameters,
                                                const Execution& execution) {
  SizeLimits limits = limits_of_flat_pieces(parameters);
  limits.weights = weights_of_parts(seen.original(), parameters, diagram.impacts, execution);
  if (!limits.any() && !joins_parts(seen.original(), parameters)) return std::vector<Union>();
  const Allowance::Temporary temporary(execution.allowance);
  const auto first = [&](const auto& all) {
    const std::size_t count = std::min(diagram.of_pattern, all.size());
    return std::decay_t<decltype(all)>(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(count));
  };
  Expected<Tetrahedralization> t = tetrahedralize(first(diagram.sites), seen.seen().box, execution);
  if (!t) return tl::unexpected(t.error());
  canonicalize(*t, execution);
  const VoronoiDiagram voronoi(*t, seen.seen().box, diagram.map, execution);
  const RestrictedDiagram restricted = restrict_to_solid(seen, voronoi, execution);
  std::vector<std::uint32_t> of_sites = groups_of_sites(*t, first(diagram.groups), execution);
  const std::vector<SiteId> kept = kept_cells(seen, voronoi, parameters, execution);
  keep_together(t->site_count(), kept, of_sites);
  const Ownership ownership = Ownership::from_groups(t->site_count(), of_sites, execution);
  if (!kept.empty()) limits.kept_owner = ownership.owner_of_site[kept[0]];
  const Pieces pieces = gather_pieces(restricted, ownership, execution);
  PieceGroups groups(pieces.pieces.size());
  const std::optional<PartContacts> across =
      find_part_contacts(restricted, ownership, pieces, parameters, execution);
  unite_by_size(restricted, pieces, limits, across ? &*across : nullptr, groups, execution);
  return name_unions(restricted, pieces, groups,
                     lowest_in_the_whole(restricted, *t, ownership, diagram.tetrahedralization, execution),
                     execution);
}

std::vector<Union> unions_beside_hits(const std::vector<Union>& unions, const Diagram& diagram,
                                      const Ownership& ownership, const Execution& execution) {
  const std::uint32_t of_pattern = sites_of_pattern(diagram);
  return active_unions(unions, lowest_cells(ownership),
                       touched_owners(
                           diagram.tetrahedralization, diagram.map, ownership,
                           [&](SiteId s) { return s >= of_pattern; }, execution),
                       execution);
}

}  // namespace fracture
