// The steps of make_diagram() and fracture(), for callers that need only some of them (broken_solid.hpp, hits/delta.hpp).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/base/remarks.hpp"
#include "common/base/scratch.hpp"
#include "common/fragment/pieces.hpp"
#include "common/fragment/unions.hpp"
#include "common/physics/collision_hulls.hpp"
#include "common/physics/rest.hpp"
#include "common/pipeline/barycentric.hpp"
#include "common/pipeline/fracture.hpp"
#include "common/pipeline/kept_fragment.hpp"
#include "common/rough/roughen.hpp"
#include "common/structure/contact_bonds.hpp"

namespace fracture {

/// Runs a stage, records its time, and converts an interruption to the corresponding error.
template <class Body>
auto stage(StageTimings& timings, const Execution& execution, Stage which, const Body& body)
    -> decltype(body()) {
  const StageTimings::Scope scope(timings, which);
  const ScratchTrimmer trimmer;
  const bool tells = execution.progress && !execution.within;  // otherwise the caller reports progress
  if (tells) execution.progress(which, 0);
  try {
    auto result = body();
    if (tells) execution.progress(which, 1);
    return result;
  } catch (const Interrupted& interrupted) {
    if (interrupted.error) return tl::unexpected<Error>(*interrupted.error);
    return fail(interrupted.code,
                interrupted.code == ErrorCode::kCancelled
                    ? "The work was cancelled during the stage " + std::string(name_of(which)) + "."
                    : "The deadline passed during the stage " + std::string(name_of(which)) + ".");
  }
}

/// Cells as fragments, with bonds, certificate and lattice, but without the additions of complete().
struct CutCells {
  FragmentSet set;
  CollisionHulls hulls;           ///< hulls that are known already
  std::size_t kept = 0;           ///< cells that FractureParameters::keep keeps together
  double kept_share = 0;          ///< share of the solid's volume that their fragments have
  bool grouped = false;           ///< whether some fragment has several cells
  BarycentricResult barycentric;  ///< its statistics, with Dual::kBarycenter
  RoughReport rough;
  /// Effects of the fallback for rough cuts (rough_cells.hpp): number of cells with less roughness than
  /// requested, and whether all cuts were made flat.
  std::uint32_t restrained_cells = 0;
  bool all_flat = false;
  bool touch_across = true;  ///< false if no two fragments touch across parts
  /// Whether make_collision_hulls() has made `hulls`. It would divide some of them again.
  bool hulls_are_final = false;
  /// The whole instances among the fragments (instanced_bodies.hpp), if they were looked for already.
  std::optional<InstancedBodies> instances{};
  /// If the set is only part of a result (only a delta): statistics of all fragments.
  struct Whole {
    std::vector<double> volumes;  ///< m³, ascending
    std::uint64_t triangles = 0;
    std::vector<std::uint32_t> nodes{};  ///< Fragment::node of each
    HullReport hulls{};
    std::optional<InstanceFigures> instances{};
    std::optional<Rest> rest{};  ///< its filters are those of the fragments of the set
  };
  std::optional<Whole> whole{};
};

/// Information about the sites that a result contains.
struct SiteNotes {
  SiteFigures figures;
  Remarks remarks;
  SplitFigures split{};
  /// Per site: number of its input point, the first one if several are equal. If empty, site k is point k.
  std::vector<std::uint32_t> point_of_site{};
};
SiteNotes notes_of(const Diagram& diagram);

/// Cuts the solid into cells. The parameters must have no hits. `kept`, if not null, receives what kept_with_pivot()
/// gives, per fragment, except for the fragments themselves and their hulls, which are in the result. Errors: those of
/// fracture(). Throws Interrupted.
Expected<CutCells> cut_cells(const Solid& solid, const Diagram& diagram, const FractureParameters& parameters,
                             const Execution& execution, std::vector<KeptFragment>* kept = nullptr);

/// Which cells of an answer may overlap. `islands`: Certificate::islands, with none no cell has two pieces.
inline CellsOfBodies cells_of_bodies(const FractureParameters& parameters, const CellMap& map,
                                     std::uint32_t islands) {
  return {map, !is_barycentric(parameters), islands > 0};
}

/// Checks the fragments, bonds them across parts (unless the set is only part of a result), and makes their
/// companions: hierarchy, anchors, hulls (for fragments that have none) and the report. Every result leaves
/// the pipeline through this function. Error: kUnsound. Throws Interrupted.
Expected<FracturedSolid> complete(const Solid& solid, const SiteNotes& sites,
                                  const FractureParameters& parameters, CutCells cut, const CellSites& cells,
                                  const Execution& execution);

}  // namespace fracture
