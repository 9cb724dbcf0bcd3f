#include "common/pipeline/split_large.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/base/pacer.hpp"
#include "common/base/random.hpp"
#include "common/clip/restricted_diagram.hpp"
#include "common/fragment/pieces.hpp"
#include "common/pipeline/fracture.hpp"
#include "common/pipeline/keep_sites.hpp"
#include "common/sites/sites.hpp"

namespace fracture {

Expected<SplitFigures> split_large(const SeenSolid& solid, Diagram& diagram,
                                   const FractureParameters& parameters, const Execution& execution) {
  const double max_volume = parameters.max_volume;
  const std::size_t most = parameters.most_sites;
  std::optional<KeptSpace> kept;
  if (parameters.keep && parameters.dual == Dual::kCircumcenter) kept.emplace(*parameters.keep, solid);
  SplitFigures figures;
  for (;;) {
    const Tetrahedralization& t = diagram.tetrahedralization;
    const VoronoiDiagram voronoi(t, solid.seen().box, diagram.map, execution);
    const Allowance::Temporary temporary(execution.allowance);  // the pass's data is freed with it
    const RestrictedDiagram restricted = restrict_to_solid(solid, voronoi, execution);
    Pieces pieces =
        gather_pieces(restricted, Ownership::from_groups(t.site_count(), {}, execution), execution);
    std::vector<std::uint32_t> wanted(t.site_count(), 0);
    figures.too_large = 0;
    Pacer pacer(execution);
    for (const Piece& p : pieces.pieces) {
      pacer.step(4 + p.faces.size());
      const double volume = signed_volume(restricted, p.faces.data(), p.faces.size(),
                                          restricted.point(p.faces[0].v[0]), execution);
      if (!(volume > max_volume) || (kept && kept->holds(voronoi.site(SiteId{p.owners[0]})))) continue;
      ++figures.too_large;
      // Every cell is its own owner here, so the owner's number is the site's. There are 30 % more points
      // than the volume requires, because random parts are uneven.
      const double parts = std::ceil(std::min(1e6, 1.3 * volume / max_volume));
      wanted[p.owners[0]] += static_cast<std::uint32_t>(std::max(1.0, parts - 1));
    }
    clear_with_polls(execution, pieces.pieces);
    if (figures.too_large == 0 || figures.passes == kMaxSplitPasses || diagram.sites.size() >= most)
      return figures;

    // Each cell gets uniform points in proportion to its volume: enough for every part, with a reserve.
    ++figures.passes;
    const double share = 4 * solid.original().report.volume / max_volume;
    const auto count = static_cast<std::uint32_t>(std::clamp(share, 64.0, 2.0 * kMaxPatternSites));
    Expected<std::vector<Vec3d>> points =
        uniform_sites(solid.seen(), count, parameters.seed ^ (kGoldenGamma * figures.passes), execution);
    if (!points) return tl::unexpected(points.error());
    SiteId cell{0};
    for (const Vec3d& p : *points) {
      pacer.step(256);  // nearest() is a walk
      if (diagram.sites.size() >= most) break;
      cell = voronoi.nearest(p, cell);
      if (wanted[cell] == 0 || (kept && !may_have_site(*kept, p, diagram.clearance))) continue;
      --wanted[cell];
      diagram.sites.push_back(p);
      ++figures.sites_added;
    }
    Expected<Tetrahedralization> finer = tetrahedralize(diagram.sites, solid.seen().box, execution);
    if (!finer) return tl::unexpected(finer.error());
    diagram.tetrahedralization = std::move(*finer);
  }
}

}  // namespace fracture
