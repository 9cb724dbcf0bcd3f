// A hit: what it is, and the small diagram whose cells it breaks off.
//
// The sites of a hit lie in a ball. Around them is a shell of guards, which are further sites. A point is nearer to a
// guard than to any site of the hit if it is far enough from the centre, so the cells of the hit end there:
//
//          g   g            s  sites of the hit, at most kSitesWithin radii from the centre
//        g   s   g          g  guards, kGuardsAt radii from the centre
//       g  s s s  g
//        g   s   g          The cells of the guards reach to infinity. Together they are the
//          g   g            rest, which is not cut.
//
// Let u be the direction of a point at the distance x from the centre. The cosine of the angle between u and some
// guard is at least kGuardCosine. The point is nearer to this guard than to every site if
// x² + g² - 2 x g kGuardCosine < (x - s)². For x > kReach, this holds.
// Cells are convex, so all of a hit's cells lie within kReach radii (Voronoi 1908). The ball is one in the image under
// the map of the cells. In the solid it is an ellipsoid, whose longest half-axis is the radius.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/execution.hpp"
#include "common/delaunay/tetrahedralization.hpp"
#include "common/pipeline/keep_region.hpp"
#include "common/rough/restraint.hpp"
#include "common/sites/pattern.hpp"

namespace fracture {

/// A place where the solid is hit.
struct LocalImpact {
  Vec3d point;               ///< m
  double radius = 0;         ///< m, > 0
  std::uint32_t sites = 30;  ///< drawn as by ImpactPattern: their density falls as 1 / distance
};

/// The pieces that the hits break.
enum class LocalRest {
  kWhole,      ///< the solid: without hits, each of its parts is one piece
  kFractured,  ///< the pieces that the pattern makes
};

/// All distances are in radii of the hit. kReach follows from the others, with a margin for sites that are rounded.
inline constexpr double kSitesWithin = 0.75, kGuardsAt = 1.1, kReach = 1.19;
/// Maximum angle between any direction and that of a guard: 20.91 degrees, as its cosine.
inline constexpr double kGuardCosine = 0.934;

/// Unit vectors: the corners of an icosahedron whose triangles are divided into four. Any direction is within
/// kGuardCosine of one of them.
std::span<const Vec3d> guard_directions();

/// The diagram of one hit.
struct HitCells {
  Tetrahedralization dual;  ///< of the image
  /// Per site, numbered as in `dual`: cells with equal numbers stay together. 0: the guards.
  std::vector<std::uint32_t> groups;
  /// Flat cuts for cells whose rough cuts might enter the region to keep; empty: none.
  Restraints flat{};
  CellMap map;  ///< identity, or one frame for all parts
  Box image;    ///< contains the solid's image under the map
  Box reach;    ///< contains all cells of the hit, in the frame of the solid
  std::uint32_t sites = 0, asked = 0;
  std::uint32_t duplicates = 0;  ///< sites that were equal to others
  bool empty() const { return sites == 0; }
};

/// Makes the diagram of hits[number]. Its sites depend on the number, so a second hit at the same place breaks more.
/// Sites that do not fit into the solid near the hit are left out, with a remark. If each part has its own grain,
/// the grain of the part that is nearest to the hit applies. `keep`: a region that the cells do not enter (hit_region.hpp). If
/// it takes sites from the hit, there are more sites around it instead. Errors: those of plan_sites() and tetrahedralize().
Expected<HitCells> cells_of_hit(const Solid& solid, const SiteParameters& parameters,
                                std::span<const LocalImpact> hits, std::size_t number,
                                const std::optional<Region>& keep, Remarks& remarks,
                                const Execution& execution);

/// Returns, for each part, whether the hit's ball touches it. Cells reach a little farther (kReach), but other parts stay whole.
/// A part whose box contains the point counts as touched, because the ball may be inside it. `reach`: HitCells::reach. Linear in the
/// triangles. Throws Interrupted.
std::vector<char> parts_in_ball(const Solid& solid, const LocalImpact& hit, const Box& reach,
                                const Execution& execution);

/// Checks that the pattern and all hits together have at most SiteParameters::most_sites sites. `of_pattern`: number of
/// the pattern's sites. Error: kTooComplex.
Expected<void> check_sites_of_hits(const SiteParameters& parameters, std::span<const LocalImpact> hits,
                                   std::uint64_t of_pattern);

}  // namespace fracture
