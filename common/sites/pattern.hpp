// How a solid breaks: the pattern of the Voronoi sites and its parameters, and the plan that a pattern makes
// for a solid. Every pattern is a pure function of (solid, parameters, number of sites, seed). Its result is
// points, groups of points whose cells stay together, and a linear map under which cells belong to the
// nearest site. Lengths are metres, and positions are in the frame of the answer (y up).
//
// Points are generated only with + - * / and sqrt (arithmetic.hpp), so every compiler and C library gives the
// same points. They are then snapped to the site lattice.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "common/base/cell_map.hpp"
#include "common/base/error.hpp"
#include "common/base/execution.hpp"
#include "common/base/matrix3.hpp"
#include "common/base/remarks.hpp"
#include "common/base/vec.hpp"
#include "common/solid/image.hpp"

namespace fracture {

/// Uniform in the volume of the solid.
struct UniformPattern {
  friend bool operator==(const UniformPattern&, const UniformPattern&) = default;
};

/// The sites themselves, as given by the caller; never snapped.
struct PointsPattern {
  std::vector<Vec3d> points{};
  /// Per point, or empty: cells with the same group id stay together as one fragment.
  std::vector<std::uint32_t> groups{};
  friend bool operator==(const PointsPattern&, const PointsPattern&) = default;
};

/// Most sites are near one or several impacts, and the rest are uniform in the solid. The density falls as
/// distance^-exponent out to the radius. Distances are drawn by their inverse distribution, so a small radius
/// costs no more than a large one.
struct ImpactPattern {
  std::vector<Vec3d> impacts{};    ///< empty: the middle of the box (see also sites/request_places.hpp)
  std::optional<double> radius{};  ///< > 0; none: a third of the box's longest side
  double exponent = 2;             ///< 0 (even within the radius) … 2.9 (nearly all at the impact)
  double share = 0.8;              ///< share of the sites that are near an impact, 0 … 1
  /// Whether parts near an impact share its sites by their distance (sites/part_shares.hpp). False: every
  /// place within the radius has the same chance, so thick parts get most sites.
  bool by_parts = true;
  friend bool operator==(const ImpactPattern&, const ImpactPattern&) = default;
};

/// Rings and spokes, around an axis for a pane of glass that was hit, or around a point for a vessel or a
/// lump. The grid is polar and aligned. So the cells' bisectors are exactly radial planes (between spokes)
/// and chords across the spokes (between rings); see radial_sites.cpp.
struct RadialPattern {
  enum class Around {
    kAxis,
    kPoint,  ///< spokes in all directions
    /// An axis if one is given or the solid is a plate; otherwise a point. If the solid has several parts,
    /// and neither axis, spokes nor rings are given, each part is treated separately: a plate breaks around
    /// an axis, a body around a point, and a rod crosswise (sites/shapes.hpp).
    kShape,
  };
  Around around = Around::kAxis;
  std::vector<Vec3d> impacts{};  ///< the first is the centre; empty: the middle of the box or of a side
  /// None: perpendicular to the plate, or along the shortest side of the box. With `crushed` and a solid that
  /// is not a plate, the axis runs from the centre to the solid's middle.
  std::optional<Vec3d> axis{};
  std::optional<std::uint32_t> spokes{}, rings{};  ///< none: chosen to give about `sites` pieces
  double growth = 1.35;  ///< each ring is this many times as wide as the one inside it, >= 1
  double jitter = 0.5;   ///< 0 … 1: how uneven the angles and radii are
  double merge = 0.4;    ///< 0 … 0.9: share of the ring cracks that are left out
  double crushed = 0;    ///< 0 … 0.9: share of the pieces that are crumbs around the centre
  friend bool operator==(const RadialPattern&, const RadialPattern&) = default;
};

/// Boxes in rows: the product of three sets of parallel planes. Jitter moves whole planes.
struct GridPattern {
  std::optional<Vec3d> cell{};  ///< along x, y and z; none: cubes, as many as requested
  double jitter = 0;            ///< 0 … 1: planes move by up to this share of half a cell
  friend bool operator==(const GridPattern&, const GridPattern&) = default;
};

/// Masonry. Walls have courses along their own axes (masonry.hpp), each shifted against the one below; other
/// parts become rubble. A brick consists of several cells that stay together, so joints are planes up to the
/// lattice step. Bricks have their real size (0.24 x 0.071 x 0.115 m). They are scaled down if that gives
/// fewer bricks than pieces, and up if it gives more than six times as many. If there are more bricks than
/// pieces, several bricks stay together.
struct BrickPattern {
  enum class Bond { kStack, kHalf, kThird };  ///< shift of each course: none, half a brick, a third
  /// Length, height and depth of a brick with its joint. If given, each brick is a piece, and every part is a
  /// wall.
  std::optional<Vec3d> cell{};
  Bond bond = Bond::kHalf;
  double jitter = 0;             ///< as in GridPattern
  std::vector<Vec3d> impacts{};  ///< bricks near these are crushed or halved
  bool mortar = false;           ///< joints are distinguished from broken bricks: SitePlan::bricks
  friend bool operator==(const BrickPattern&, const BrickPattern&) = default;
};

/// One to three families of parallel planes. Several families are the product grid of their coordinates.
struct SlicePattern {
  std::vector<Vec3d> normals{{0, 1, 0}};  ///< 1 … 3, linearly independent; need not be unit vectors
  std::optional<double> spacing{};        ///< > 0; none: chosen to give about the requested number of pieces
  double jitter = 0.2;                    ///< 0 … 1: planes move by up to this share of half the spacing
  double tilt = 0;                        ///< of each plane's normal, degrees, 0 … 45; for one family only
  friend bool operator==(const SlicePattern&, const SlicePattern&) = default;
};

/// Groups of small pieces between large ones.
struct ClusteredPattern {
  std::optional<std::uint32_t> clusters{};  ///< none: one per about forty sites
  std::optional<double> radius{};           ///< > 0; none: 0.12 of the geometric mean of the box's sides
  double exponent = 1.5;                    ///< as in ImpactPattern
  double share = 0.88;                      ///< share of the sites that are in clusters, 0 … 1
  friend bool operator==(const ClusteredPattern&, const ClusteredPattern&) = default;
};

using SitePattern = std::variant<UniformPattern, PointsPattern, ImpactPattern, RadialPattern, GridPattern,
                                 BrickPattern, SlicePattern, ClusteredPattern>;

/// Facts about each pattern that requests depend on. One line for each alternative, in the same order.
struct PatternTraits {
  const char* name;
  const char* description;
  bool counted;  ///< SiteParameters::sites applies, and levels are possible
  bool relaxed;  ///< sites can be moved individually: SiteParameters::lloyd
};
inline constexpr PatternTraits kPatternTraits[] = {
    {"uniform", "Sites spread uniformly in the solid.", true, true},
    {"points", "The sites given in the request.", false, true},
    {"impact", "Most sites are near the impacts; the density falls with distance.", true, true},
    {"radial", "Rings and spokes, as in a pane or vessel that has been hit.", true, false},
    {"grid", "Boxes in rows.", true, false},
    {"brick",
     "Masonry: lumps of bricks in courses along the axes of a wall. Parts that are not walls become rubble.",
     true, false},
    {"slice", "One to three families of parallel planes.", true, false},
    {"clustered", "Groups of small pieces between large ones.", true, true},
};
static_assert(std::size(kPatternTraits) == std::variant_size_v<SitePattern>);

/// Whether the pattern's sites are generated independently, so that they can be in several frames of a map.
bool is_scattered(const SitePattern& pattern);

/// The unit that has its own grain, along its longest axis of inertia (sites/grain.hpp). Only scattered
/// patterns (uniform, impact, clustered) support several grains.
enum class GrainOf {
  kSolid,     ///< one grain for the whole solid: the longest side of its box
  kPart,      ///< each part
  kNode,      ///< all parts of one node of the source together
  kMaterial,  ///< all parts with the same material on most of their surface
};

/// Cells that are longer in one direction. The pattern is generated in the image of the solid under the
/// inverse stretch, where it is isotropic. Not for slices with several families, which use such an image
/// themselves.
struct Anisotropy {
  double stretch = 1;  ///< length along the grain divided by length across it, > 0; 1: isotropic
  GrainOf grain_of = GrainOf::kSolid;
  std::optional<Vec3d> grain{};     ///< one direction for everything; none: see grain_of
  std::optional<Matrix3> matrix{};  ///< instead of stretch: the linear map of cells; not singular
  friend bool operator==(const Anisotropy&, const Anisotropy&) = default;
};

/// Fragments of several cells, with ragged edges and a distribution of sizes (pipeline/aggregate.hpp). Only
/// scattered patterns (uniform, impact, clustered) support them.
struct Aggregation {
  std::uint32_t cells = 1;  ///< average number per fragment; 1: each cell is a fragment
  /// How uneven the volumes are, from 0 (all equal) to kMostSpread. The share of fragments larger than v is
  /// exp(-(v / scale)^(1 / spread)) (Weibull 1951).
  double spread = 1;
  friend bool operator==(const Aggregation&, const Aggregation&) = default;
};
inline constexpr std::uint32_t kMostCellsPerFragment = 64;
inline constexpr double kMostSpread = 2;

/// Maximum number of sites that a pattern generates.
inline constexpr std::uint32_t kMaxPatternSites = 100'000;

/// The parameters that determine the sites, and no others.
struct SiteParameters {
  std::uint32_t sites = 50;  ///< approximate number of pieces, not of their cells; ignored by PointsPattern
  std::uint64_t seed = 1;
  SitePattern pattern{};
  std::uint32_t lloyd = 0;  ///< passes of relaxation (pipeline/lloyd.hpp), for patterns without groups
  Anisotropy anisotropy{};
  Aggregation aggregation{};
  /// Source of the density of uniform sites (sites/density.hpp): vertex colours or a material. Only for
  /// scattered patterns. Empty: uniform density.
  std::string density_from{};
  /// A pattern that would generate more sites is refused. Does not affect the sites otherwise.
  std::uint32_t most_sites = kMaxPatternSites;
};

/// The plan that a pattern makes for a solid.
struct SitePlan {
  /// In the image under `map`. PointsPattern keeps the caller's order; other patterns order points along a
  /// curve through the image.
  std::vector<Vec3d> points;
  std::vector<std::uint32_t> groups;  ///< per point, or empty: cells with equal ids stay together
  CellMap map;                        ///< has a positive determinant
  Remarks remarks;                    ///< deviations from the request
  /// With BrickPattern::mortar, the brick or stone of each point's cell, or kNoIndex for crumbs and cells
  /// outside every brick. A cut between two different bricks is a joint; any other cut goes through a brick.
  std::vector<std::uint32_t> bricks{};
  /// With a kept region: no further site may be nearer than this to the region, m, in the image
  /// (pipeline/keep_sites.hpp).
  double clearance = 0;
};

/// Returns "the limit is 100,000 (server option --max-sites)".
std::string site_limit(std::uint64_t most);

/// Number of cells per fragment: the number in Aggregation, reduced if kMaxPatternSites requires it. 1 if the
/// pattern does not support aggregates.
std::uint32_t cells_per_fragment(const SiteParameters& parameters);

/// Returns the map under which the cells of these parameters are isotropic. Error: kBadParameter, with the
/// parameter's name, for a meaningless combination. Throws Interrupted.
Expected<CellMap> map_of_cells(const Solid& solid, const SiteParameters& parameters,
                               const Execution& execution);

/// Plans the sites of a solid seen through map_of_cells(). Errors: kBadParameter, kTooComplex (more than
/// most_sites). Near-linear in triangles + sites.
Expected<SitePlan> plan_sites(const SeenSolid& solid, const SiteParameters& parameters,
                              const Execution& execution);
/// The same, but computes the image itself. Has the errors of both functions.
Expected<SitePlan> plan_sites(const Solid& solid, const SiteParameters& parameters,
                              const Execution& execution);

/// Adds a site in the middle of a part to each frame of the plan's map that has no site. Otherwise, that
/// frame would belong to sites of another grain. Adds at most kMostFrames - 1 sites, which do not count
/// towards most_sites.
void fill_frames(const SeenSolid& solid, SitePlan& plan, const Execution& execution);

/// Estimates, within a factor of two, how many sites the parameters give for a solid in this box. Callers use
/// it to estimate the cost of a request before computing it.
double expected_sites(const SiteParameters& parameters, const Box& box);

}  // namespace fracture
