// The steps of make_diagram() and fracture(), for those who go part of the way (hits/delta.hpp).
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/base/remarks.hpp"
#include "common/base/scratch.hpp"
#include "common/fragment/pieces.hpp"
#include "common/fragment/unions.hpp"
#include "common/physics/collision_hulls.hpp"
#include "common/pipeline/barycentric.hpp"
#include "common/pipeline/fracture.hpp"
#include "common/rough/roughen.hpp"
#include "common/structure/contact_bonds.hpp"

namespace fracture {

/// Runs a stage: its time is kept, and an interruption becomes the error it stands for.
template <class Body>
auto stage(StageTimings& timings, const Execution& execution, Stage which, const Body& body)
    -> decltype(body()) {
  const StageTimings::Scope scope(timings, which);
  const ScratchTrimmer trimmer;
  const bool tells = execution.progress && !execution.within;  // else the caller knows better what all is
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

/// Cells as fragments: with bonds, certificate and lattice, without what complete() adds.
struct CutCells {
  FragmentSet set;
  CollisionHulls hulls;                 ///< those that are known already
  std::size_t kept = 0;                 ///< cells that FractureParameters::keep keeps together
  bool grouped = false;                 ///< some fragment has several cells
  std::vector<SiteId> lowest{};         ///< per site, where some stay together: the lowest of these
  std::vector<std::uint32_t> pieces{};  ///< per site; those of cells that stay together at the lowest of them
  std::vector<Union> unions{};          ///< what the limits of size unite where no hit has come
  /// What was united after these, because it is too small with its rough cuts, or of what hits broke off.
  std::vector<Union> late{};
  BarycentricResult barycentric;  ///< its figures, with Dual::kBarycenter
  RoughReport rough;
  /// What the net under rough cuts did (rough_cells.hpp): cells with less roughness than asked, or all flat.
  std::uint32_t restrained_cells = 0;
  bool all_flat = false;
  bool touch_across = true;  ///< PieceRecord::touch_across
  /// Where the set is a part of an answer (a delta alone): figures of all its fragments.
  struct Whole {
    std::vector<double> volumes;  ///< m³, ascending
    std::uint64_t triangles = 0;
    HullReport hulls{};
  };
  std::optional<Whole> whole{};
};

/// The limits of size as they hold for all cells, beyond what they unite of the pattern's pieces before hits come: what
/// hits break off comes on top of the fragments that the pattern shall make, and is smaller beside the mean than crumbs
/// are elsewhere. With hits a volume alone, which is the same however many there are. `volume`: of the solid, m³.
/// `pattern_sites`: sites_of_pattern().
SizeLimits limits_in_force(const FractureParameters& parameters, double volume, std::uint32_t pattern_sites);

/// What an answer says of its sites.
struct SiteNotes {
  SiteFigures figures;
  Remarks remarks;
  SplitFigures split{};
  /// Per site which point it is of those given, and of equal ones the first; empty: site k is point k.
  std::vector<std::uint32_t> point_of_site{};
};
SiteNotes notes_of(const Diagram& diagram);

/// `inspect` sees what the clipper found, unless for barycentric cells; `trace`: roughen(). Errors of fracture();
/// throws Interrupted.
Expected<CutCells> cut_cells(const Solid& solid, const Diagram& diagram, const FractureParameters& parameters,
                             const Execution& execution,
                             const std::function<void(const RestrictedDiagram&)>& inspect = {},
                             std::optional<RoughTrace>* trace = nullptr);

/// Checks the fragments, bonds them across parts unless the set is only part of an answer, and makes their companions:
/// hierarchy, anchors, hulls (for fragments that have none) and the report. Every answer leaves the pipeline through here.
/// Error: kUnsound. Throws Interrupted.
Expected<FracturedSolid> complete(const Solid& solid, const SiteNotes& sites,
                                  const FractureParameters& parameters, CutCells cut, const CellSites& cells,
                                  const Execution& execution);

}  // namespace fracture
