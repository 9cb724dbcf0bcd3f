// The whole pipeline, in the order of the folders: mesh -> solid -> sites -> tetrahedralization -> clip ->
// fragments. It has two steps, so that a server can keep what is reusable: make_diagram() for each mesh and its
// site parameters, and fracture() for each request.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/execution.hpp"
#include "common/base/remarks.hpp"
#include "common/base/timings.hpp"
#include "common/delaunay/tetrahedralization.hpp"
#include "common/physics/collision_hulls.hpp"
#include "common/physics/rest.hpp"
#include "common/pipeline/assigned_parts.hpp"
#include "common/pipeline/fractured_solid.hpp"
#include "common/pipeline/keep_region.hpp"
#include "common/pipeline/local_impact.hpp"
#include "common/pipeline/split_large.hpp"
#include "common/rough/roughness.hpp"
#include "common/sites/pattern.hpp"
#include "common/solid/solid.hpp"
#include "common/structure/anchors.hpp"

namespace fracture {

enum class Dual {
  kCircumcenter,  ///< the Voronoi diagram: fragments partition the solid exactly
  kBarycenter,    ///< the look of the paper: hulls of barycentres, clipped to the solid; not a partition
};

enum class Hulls { kNone, kConvex };

/// How the parts of a solid that overlap or touch become fragments.
enum class Parts {
  kTogether,  ///< pieces of several parts can become one fragment (pipeline/part_contacts.hpp)
  kApart,     ///< each fragment belongs to one part
  /// Each fragment belongs to one part, or to one instance that stays whole. For LocalRest::kWhole before the first hit, not
  /// for requests.
  kInstances,
};

/// How instances of a mesh that need not be cut are treated (solid/instances.hpp).
enum class InstanceUse {
  kKeep,      ///< each is one fragment, and the answer writes their shape once (pipeline/kept_instances.hpp)
  kSeparate,  ///< they are parts like others
  kAll,  ///< each is one fragment, whatever its size; for sets of parts (pipeline/part_sets.hpp), not for requests
};

/// Parameters of the cuts and of the result. They concern only the geometry.
struct FractureParameters : SiteParameters {
  Dual dual = Dual::kCircumcenter;
  double drop_above = 0;       ///< m³; kBarycenter only: larger fragments are left out. 0: no limit
  Hulls hulls = Hulls::kNone;  ///< collision hulls for physics engines (physics/collision_hulls.hpp)
  HullLimits hull_limits{};    ///< number of hulls per fragment
  HullFilters filters = HullFilters::kSystems;  ///< for bodies whose hulls overlap (physics/rest.hpp)
  Pivot pivot = Pivot::kCenterOfMass;
  bool intact = false;    ///< whether to make FracturedSolid::intact
  SizeLimits size;        ///< small fragments are merged with a neighbour
  double max_volume = 0;  ///< m³; 0: no limit. Cells with a larger piece get more sites
  /// Nothing inside this region is cut: its surface is a boundary of cells (pipeline/keep_sites.hpp), and the
  /// cells in it form one group. Not with Dual::kBarycenter.
  std::optional<Region> keep{};
  Roughness roughness{};  ///< of the cuts; uses the sites' seed. Only with Dual::kCircumcenter
  /// The number of clusters in each level of the hierarchy above the fragments, coarsest first; increasing.
  std::vector<std::uint32_t> levels{};
  Anchors anchors;                  ///< fragments that touch these are marked
  std::vector<LocalImpact> hits{};  ///< in order; each one hits the result of those before it
  LocalRest rest = LocalRest::kWhole;
  Parts parts = Parts::kTogether;              ///< needs Solid::contacts
  InstanceUse instances = InstanceUse::kKeep;  ///< needs Solid::instances; not with Parts::kApart
  /// Strength of bonds across parts, as a multiple of the material's; >= 0. 0: no such bonds. They need Solid::contacts.
  double contact_strength = 1;
  /// Parts that break in another way (pipeline/part_sets.hpp). The number of fragments and the size limits hold for the whole.
  std::vector<AssignedParts> assigned{};
};

/// Whether the fragments are hulls of barycentres. With LocalRest::kWhole they are not: hits cut whole parts, by Voronoi cells.
inline bool is_barycentric(const FractureParameters& p) {
  return p.dual == Dual::kBarycenter && (p.hits.empty() || p.rest == LocalRest::kFractured);
}

/// The reusable result for (mesh, site parameters): the pattern's sites and their tetrahedralization. Hits have diagrams of
/// their own (local_impact.hpp).
struct Diagram {
  std::vector<Vec3d> sites;
  std::vector<std::uint32_t> groups{};  ///< per site, or empty: cells with equal ids stay together
  std::vector<std::uint32_t> bricks{};  ///< SitePlan::bricks
  /// Sites and tetrahedralization are those of the solid's image under this map (no map: of the solid itself).
  CellMap map{};
  Remarks remarks{};                      ///< about the sites
  Tetrahedralization tetrahedralization;  ///< canonical
  SplitFigures split{};                   ///< effect of FractureParameters::max_volume
  /// The impacts of the pattern, on the solid (sites/request_places.hpp). Empty: it has none.
  std::vector<Vec3d> impacts{};
  double clearance = 0;  ///< SitePlan::clearance
  std::uint64_t of_pattern =
      0;  ///< number of sites that count towards most_sites together with those of hits
  /// If several sets of parts break in different ways (pipeline/part_sets.hpp): the diagram of each set. This diagram then has
  /// the sites of all of them, but no tetrahedra, and its map only has the frames of parts.
  std::vector<Diagram> sets{};
};

/// Makes the diagram. Errors: those of plan_sites(), tetrahedralize() and check_sites_of_hits(), or an interruption.
Expected<Diagram> make_diagram(const Solid& solid, const FractureParameters& parameters,
                               const Execution& execution, StageTimings& timings);

/// Cuts the solid by the diagram. Errors: kNoFragments, kUnsound, kBadParameter (`dual`: barycentric cells
/// do not support a map), or an interruption.
Expected<FracturedSolid> fracture(const Solid& solid, const Diagram& diagram,
                                  const FractureParameters& parameters, const Execution& execution,
                                  StageTimings& timings);

}  // namespace fracture
