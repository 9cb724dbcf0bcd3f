#include "common/pipeline/cell_groups.hpp"

#include <numeric>
#include <set>

#include "common/base/id_table.hpp"
#include "common/base/pacer.hpp"
#include "common/rough/roughen.hpp"

namespace fracture {

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

std::vector<SiteId> kept_cells(const SeenSolid& seen, const VoronoiDiagram& diagram,
                               const FractureParameters& parameters, const Execution& execution) {
  if (!parameters.keep) return {};
  std::vector<Movement> movements;
  if (parameters.roughness.amplitude > 0 && parameters.dual == Dual::kCircumcenter)
    movements = movements_of_cuts(seen.original(), parameters.roughness, diagram.map());
  return cells_meeting(*parameters.keep, diagram, seen.seen().box, execution, movements);
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
