#include "common/pipeline/lloyd.hpp"

#include "common/base/pacer.hpp"
#include "common/clip/restricted_diagram.hpp"
#include "common/delaunay/tetrahedralization.hpp"
#include "common/pipeline/cell_shares.hpp"
#include "common/sites/sites.hpp"

namespace fracture {

Expected<void> relax(const SeenSolid& solid, SitePlan& plan, std::uint32_t passes,
                     const Execution& execution) {
  const SiteLattice lattice = site_lattice(solid.seen().box);
  // A sliver's centre of mass is mostly rounding error.
  const double least_volume = 1e-9 * solid.original().report.volume /
                              static_cast<double>(std::max<std::size_t>(1, plan.points.size()));
  Pacer pacer(execution);
  for (std::uint32_t pass = 0; pass < passes; ++pass) {
    const StageProgress::Part part(execution.within, (pass + 1.0) / passes);
    const Allowance::Temporary temporary(execution.allowance);  // the pass's data is freed with it
    const Expected<Tetrahedralization> t = tetrahedralize(plan.points, solid.seen().box, execution);
    if (!t) return tl::unexpected(t.error());
    const VoronoiDiagram diagram(*t, solid.seen().box, plan.map, execution);
    const CellShares shares(restrict_to_solid(solid, diagram, execution), execution);
    for (std::size_t k = 0; k < plan.points.size(); ++k) {
      pacer.step(4);
      const SiteId site = t->site_of_input[k];
      if (site == kNoSite) continue;
      const std::optional<Vec3d> center = shares.center(site, least_volume);
      if (center)
        plan.points[k] = lattice.snap(plan.map ? plan.map.at(plan.points[k]).image(*center) : *center);
    }
  }
  return {};
}

}  // namespace fracture
