// The whole job, in the order of the folders: mesh -> solid -> sites -> tetrahedralization -> clip ->
// fragments. Two steps, so that a server can keep what is reusable: prepare() once for each mesh, fracture()
// for each request.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/execution.hpp"
#include "common/base/timings.hpp"
#include "common/delaunay/tetrahedralization.hpp"
#include "common/pipeline/fractured_solid.hpp"
#include "common/pipeline/keep_region.hpp"
#include "common/pipeline/local_impact.hpp"
#include "common/pipeline/split_large.hpp"
#include "common/rough/roughness.hpp"
#include "common/sites/pattern.hpp"
#include "common/solid/solid.hpp"
#include "common/structure/anchors.hpp"

namespace fracture {

/// An answer changes only when this does.
///  1  2026-11-21
///  2  2026-11-21  hulls inset by 0.4 mm; united pieces fused on the outside; more parameters in the answer
///  3  2026-11-21  the distribution of volumes in the report
///  4  2026-11-21  tetrahedra in canonical order, so that a hit leaves what it does not touch as it was, to
///                 the bit; several hits, whose sites stay within their radius
///  5  2026-11-21  materials have rough cuts; triangles without area have mirror images in any reading
///  6  2026-11-22  answers that do not prove themselves are refused; crossing caps, united pieces and slabs
///                 are closed where they were open; areas in the certificate
///  7  2026-11-23  volumes, masses and what follows from them of bodies of needles
///  8  2026-11-23  hulls of convex fragments are their own surfaces; rough cuts calm down in fewer steps
///  9  2026-11-23  collars of rough cuts are zipped up before they are flipped, another choice where four
///                 corners are on a circle; areas, places and directions of bonds as floats
/// 10  2026-11-23  sites, and fragments after them, in the order of a curve through the solid
/// 11  2026-11-23  cut faces have the colour of what was cut; pieces of a fragment know their part
/// 12  2026-11-24  closed parts of glass and ceramic become walls; a grain for each part; glass, metal; bricks of
///                 real size along the axes of walls, ice, splinters; stone and concrete in ragged chunks of
///                 several cells; cuts of a triangle by their cells
/// 13  2026-11-24  plates however they stand; unions of patterns with sites outside of the box, and max_volume,
///                 beside hits; clear cuts; hulls of fragments of many cells
/// 14  2026-11-24  metal in large torn plates; crushed ice is white; walls as fine as the outside
/// 15  2026-11-26  cuts of metal are as bright as bare steel, those of ceramic matt, those of ice frosted
/// 16  2026-11-26  little is united for its size after the noise; beside hits one smallest volume; cuts of cast iron
///                 are grey and matt
/// 17  2026-11-26  of several parts of glass each breaks as its shape has it; hulls without corners that hardly
///                 stick out
/// 18  2026-11-27  metal is sheet, ice breaks in blocks, glass in longer shards and thinner walls; what has no material
///                 is made of the one that is asked for
/// 19  2026-11-27  rough cuts of longer edges, flat across thin walls; inner sides of walls have as many triangles as they
///                 bend
/// 20  2026-11-27  hulls leave out more of what hardly sticks out
/// 21  2026-11-28  hulls without corners twice or triangles inside out; what bends inwards a little at many edges is no
///                 hull; bodies without volume have a mass; walls with flat sides have fewer triangles
inline constexpr int kAlgorithmVersion = 21;

enum class Dual {
  kCircumcenter,  ///< the Voronoi diagram: fragments partition the solid exactly
  kBarycenter,    ///< the paper's look: hulls of barycentres clipped to the solid; no partition is promised
};

enum class Hulls { kNone, kConvex };

/// What is cut, and what comes of it: geometry alone.
struct FractureParameters : SiteParameters {
  Dual dual = Dual::kCircumcenter;
  double drop_above = 0;       ///< m³; with kBarycenter alone: larger fragments are left out. 0: none
  Hulls hulls = Hulls::kNone;  ///< collision hulls for physics engines (physics/collision_hulls.hpp)
  /// Of an aggregate, which has one for each cell where it has no more cells (physics/aggregate_hulls.hpp); > 0.
  std::uint32_t most_hulls = 4;
  Pivot pivot = Pivot::kCenterOfMass;
  SizeLimits size;        ///< small fragments are united with a neighbour
  double max_volume = 0;  ///< m³; 0: no limit. Cells with a larger piece get further sites
  /// Nothing within it is cut: the cells that meet it are one group.
  std::optional<Region> keep{};
  Roughness roughness{};  ///< of the cuts; the noise has the seed of the sites. dual: kCircumcenter only
  /// How many clusters each level of the hierarchy above the fragments has, coarsest first, increasing.
  std::vector<std::uint32_t> levels{};
  Anchors anchors;                  ///< fragments that touch these are marked
  std::vector<LocalImpact> hits{};  ///< one after the other, each on what the ones before it left
  LocalRest rest = LocalRest::kWhole;
};

/// The reusable result for (mesh, site parameters): sites and their tetrahedralization.
struct Diagram {
  std::vector<Vec3d> sites;
  std::vector<std::uint32_t> groups{};  ///< per site, or empty: cells with equal ids stay together
  std::vector<std::uint32_t> bricks{};  ///< SitePlan::bricks
  /// Sites and tetrahedralization are those of the solid's image under this map (none: of itself).
  CellMap map{};
  std::vector<std::string> notes{};       ///< about the sites, for people
  Tetrahedralization tetrahedralization;  ///< canonical
  SplitFigures split{};                   ///< what FractureParameters::max_volume did
  std::size_t of_pattern = 0;             ///< so many of `sites`, the first ones, are not of hits
};

/// Errors: those of plan_sites() and tetrahedralize(), an interruption.
Expected<Diagram> make_diagram(const Solid& solid, const FractureParameters& parameters,
                               const Execution& execution, StageTimings& timings);

/// Cuts the solid by the diagram. Errors: kNoFragments, kUnsound, kBadParameter (`dual`: barycentric cells
/// know no map), an interruption.
Expected<FracturedSolid> fracture(const Solid& solid, const Diagram& diagram,
                                  const FractureParameters& parameters, const Execution& execution,
                                  StageTimings& timings);

}  // namespace fracture
