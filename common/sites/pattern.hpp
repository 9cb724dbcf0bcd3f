// How a solid is to break: the pattern of the Voronoi sites and its parameters, and what a pattern makes of
// a solid. Every pattern is a pure function of (solid, its parameters, number of sites, seed) and needs no
// more than points, groups of points whose cells stay together, and a linear map under which the cells are
// those of the nearest site. Lengths are metres, places are in the frame of the answer (y up).
//
// Generated points are made with + - * / and sqrt alone (arithmetic.hpp), so that every compiler and C
// library gives the same ones, and snapped to the site lattice.
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

/// The sites themselves, as the caller wants them: never snapped.
struct PointsPattern {
  std::vector<Vec3d> points{};
  /// Per point, or empty: cells with the same group id stay together as one fragment.
  std::vector<std::uint32_t> groups{};
  friend bool operator==(const PointsPattern&, const PointsPattern&) = default;
};

/// Most sites near one or several impacts, the others uniform in the solid. Distances from an impact are
/// drawn by their inverse distribution, so a small radius costs no more than a large one: the density falls
/// as distance^-exponent out to the radius.
struct ImpactPattern {
  std::vector<Vec3d> impacts{};    ///< empty: the middle of the box
  std::optional<double> radius{};  ///< > 0; none: a third of the box's longest side
  double exponent = 2;             ///< 0 (even within the radius) … 2.9 (all but at the impact)
  double share = 0.8;              ///< of the sites that go near an impact, 0 … 1
  friend bool operator==(const ImpactPattern&, const ImpactPattern&) = default;
};

/// Rings and spokes around an axis: a pane of glass that was hit; or around a point: a vessel or a lump. An aligned
/// polar grid, so the cells' bisectors are exactly radial planes (between spokes) and chords across the spokes (between
/// rings); see radial_sites.cpp.
struct RadialPattern {
  enum class Around {
    kAxis,
    kPoint,  ///< spokes in all directions
    /// An axis where one is given or the solid is a plate, else a point. Of several parts each for itself, where neither
    /// axis nor spokes nor rings are given: a plate around an axis, a body around a point, a rod across (sites/shapes.hpp).
    kShape,
  };
  Around around = Around::kAxis;
  std::vector<Vec3d> impacts{};  ///< the first one is the centre; empty: the middle of the box, or of a side
  /// none: through a plate, else along the shortest side of the box; with `crushed`, of what is no plate, from the
  /// centre to its middle
  std::optional<Vec3d> axis{};
  std::optional<std::uint32_t> spokes{}, rings{};  ///< none: as many as give about the asked number of pieces
  double growth = 1.35;  ///< each ring is so many times as wide as the one inside it, >= 1
  double jitter = 0.5;   ///< 0 … 1: how uneven the angles and radii are
  double merge = 0.4;    ///< 0 … 0.9: share of the ring cracks that stay away
  double crushed = 0;    ///< 0 … 0.9: share of the pieces that are crumbs around the centre
  friend bool operator==(const RadialPattern&, const RadialPattern&) = default;
};

/// Boxes in rows: the product of three sets of parallel planes, which jitter as wholes.
struct GridPattern {
  std::optional<Vec3d> cell{};  ///< along x, y and z; none: cubes, as many as asked for
  double jitter = 0;            ///< 0 … 1: planes move by up to this share of half a cell
  friend bool operator==(const GridPattern&, const GridPattern&) = default;
};

/// Masonry: on walls courses along their own axes (masonry.hpp), each shifted against the one below; on what is no wall
/// rubble. A brick is several cells that stay together, so the joints are planes to the lattice step. Bricks have their
/// real size (0.24 x 0.071 x 0.115 m), in proportion smaller where there are fewer than pieces asked for, larger where
/// there are six times as many; of those that are more than pieces several stay together.
struct BrickPattern {
  enum class Bond { kStack, kHalf, kThird };  ///< shift of a course: none, half a brick, a third
  /// Length, height and depth of a brick with its joint: each is a piece, and all is a wall; none: as above.
  std::optional<Vec3d> cell{};
  Bond bond = Bond::kHalf;
  double jitter = 0;             ///< as in GridPattern
  std::vector<Vec3d> impacts{};  ///< bricks near these are crushed, or break in halves
  bool mortar = false;           ///< joints are told from broken bricks: SitePlan::bricks
  friend bool operator==(const BrickPattern&, const BrickPattern&) = default;
};

/// One to three families of parallel planes. Several families are the product grid of their coordinates.
struct SlicePattern {
  std::vector<Vec3d> normals{{0, 1, 0}};  ///< 1 … 3, linearly independent; not necessarily of unit length
  std::optional<double> spacing{};        ///< > 0; none: as gives about the asked number of pieces
  double jitter = 0.2;                    ///< 0 … 1: planes move by up to this share of half the spacing
  double tilt = 0;                        ///< degrees, 0 … 45, of each plane's normal; for one family only
  friend bool operator==(const SlicePattern&, const SlicePattern&) = default;
};

/// Groups of small pieces between large ones.
struct ClusteredPattern {
  std::optional<std::uint32_t> clusters{};  ///< none: one for about forty sites
  std::optional<double> radius{};           ///< > 0; none: 0.12 of the mean of the box's sides
  double exponent = 1.5;                    ///< as in ImpactPattern
  double share = 0.88;                      ///< of the sites that go into clusters, 0 … 1
  friend bool operator==(const ClusteredPattern&, const ClusteredPattern&) = default;
};

using SitePattern = std::variant<UniformPattern, PointsPattern, ImpactPattern, RadialPattern, GridPattern,
                                 BrickPattern, SlicePattern, ClusteredPattern>;

/// What requests may say of a pattern and with it. One line for each alternative, in their order.
struct PatternTraits {
  const char* name;
  const char* description;
  bool counted;  ///< SiteParameters::sites means something, and there may be levels
  bool relaxed;  ///< its sites may be moved one by one: SiteParameters::lloyd
};
inline constexpr PatternTraits kPatternTraits[] = {
    {"uniform", "Sites spread uniformly in the solid.", true, true},
    {"points", "The sites given in the request.", false, true},
    {"impact", "Most sites are near the impacts; the density falls with distance.", true, true},
    {"radial", "Rings and spokes, as in a pane or vessel that has been hit.", true, false},
    {"grid", "Boxes in rows.", true, false},
    {"brick",
     "Masonry: lumps of bricks in courses along the axes of a wall; parts that are not walls become rubble.",
     true, false},
    {"slice", "One to three families of parallel planes.", true, false},
    {"clustered", "Groups of small pieces between large ones.", true, true},
};
static_assert(std::size(kPatternTraits) == std::variant_size_v<SitePattern>);

/// Whether the pattern's sites are made independently, so that they may be in several frames of a map.
bool is_scattered(const SitePattern& pattern);

/// What has a grain of its own, along its longest axis of inertia (sites/grain.hpp). Only sites that are scattered
/// (uniform, impact, clustered) know several grains.
enum class GrainOf {
  kSolid,     ///< all of it the same: the longest side of its box
  kPart,      ///< each part
  kNode,      ///< all parts of a node of the source together
  kMaterial,  ///< all parts with the same material on most of their surface together
};

/// Cells that are longer in one direction: the pattern is made in the image of the solid under the inverse
/// stretch, where it is isotropic. Not for slices of several families, which are such images themselves.
struct Anisotropy {
  double stretch = 1;  ///< how many times as long along the grain as across it, > 0; 1: not
  GrainOf grain_of = GrainOf::kSolid;
  std::optional<Vec3d> grain{};     ///< direction, the same for all; none: as grain_of says
  std::optional<Matrix3> matrix{};  ///< instead: what a cell goes through, not singular
  friend bool operator==(const Anisotropy&, const Anisotropy&) = default;
};

/// Fragments of several cells, ragged by them and of the sizes of a distribution (pipeline/aggregate.hpp). Only sites
/// that are scattered (uniform, impact, clustered) know them.
struct Aggregation {
  std::uint32_t cells = 1;  ///< for each fragment, on average; 1: each cell is one
  /// How uneven the volumes are, 0 (all alike) … kMostSpread. The share of fragments larger than v is
  /// exp(-(v / scale)^(1 / spread)), as Weibull (1951) has it.
  double spread = 1;
  friend bool operator==(const Aggregation&, const Aggregation&) = default;
};
inline constexpr std::uint32_t kMostCellsPerFragment = 64;
inline constexpr double kMostSpread = 2;

/// Patterns make at most this many sites.
inline constexpr std::uint32_t kMaxPatternSites = 100'000;

/// Exactly what decides the sites.
struct SiteParameters {
  std::uint32_t sites = 50;  ///< about how many pieces; of aggregates, not their cells. Not for PointsPattern
  std::uint64_t seed = 1;
  SitePattern pattern{};
  std::uint32_t lloyd = 0;  ///< passes of relaxation (pipeline/lloyd.hpp), for patterns without groups
  Anisotropy anisotropy{};
  Aggregation aggregation{};
  /// What says how close sites lie that are even without (sites/density.hpp): vertex colours, or a material; of patterns
  /// of scattered sites. Empty: nothing.
  std::string density_from{};
  /// A pattern that would make more sites is refused. Decides no sites, only whether there are any.
  std::uint32_t most_sites = kMaxPatternSites;
};

/// What a pattern makes of a solid.
struct SitePlan {
  /// In the image under `map`; those of PointsPattern as they were given, others along a curve through it.
  std::vector<Vec3d> points;
  std::vector<std::uint32_t> groups;  ///< per point, or empty: cells with equal ids stay together
  CellMap map;                        ///< of positive determinant
  Remarks remarks;                    ///< what was not done as asked
  /// Of the last points, which hits made: cells with equal ids stay together (pipeline/local_impact.hpp). Empty: none do.
  std::vector<std::uint32_t> groups_of_hits{};
  /// With BrickPattern::mortar, per point (or of the first ones, where hits made the others): the brick or stone that its
  /// cell is of, kNoIndex of crumbs and of what belongs to none. A cut between two of them is a joint, others go through
  /// bricks.
  std::vector<std::uint32_t> bricks{};
};

/// How many cells are made for each fragment: what Aggregation asks for, unless kMaxPatternSites are fewer; 1 where the
/// pattern knows no aggregates.
std::uint32_t cells_per_fragment(const SiteParameters& parameters);

/// The map under which the cells of these parameters are isotropic. Error: kBadParameter with the parameter's name (a
/// combination that has no meaning). Throws Interrupted.
Expected<CellMap> map_of_cells(const Solid& solid, const SiteParameters& parameters,
                               const Execution& execution);

/// `solid` is seen through map_of_cells(). Errors: kBadParameter, kTooComplex (more than most_sites).
/// Near-linear in triangles + sites.
Expected<SitePlan> plan_sites(const SeenSolid& solid, const SiteParameters& parameters,
                              const Execution& execution);
/// The same, with an image of its own. Errors of both.
Expected<SitePlan> plan_sites(const Solid& solid, const SiteParameters& parameters,
                              const Execution& execution);

/// Gives each frame of the plan's map that has no site one in the middle of a part: without, what lies in it would
/// belong to sites of another grain. At most kMostFrames - 1 sites, which most_sites does not count.
void fill_frames(const SeenSolid& solid, SitePlan& plan, const Execution& execution);

/// About how many sites that makes, within a factor of two, of a solid in this box. For those who have to
/// know what a request costs before it is computed.
double expected_sites(const SiteParameters& parameters, const Box& box);

}  // namespace fracture
