// A hit on what is fractured already: further sites are inserted into the tetrahedralization that was kept,
// only the cells that they change are cut again, and what comes out is spliced into what was kept. The answer
// equals, to the bit, what fracture() makes of all sites from nothing.
//
// What a new site changes: its own cell and those of its Delaunay neighbours, no other (Watson 1981). A
// tetrahedron without a new site was there before. So
//   - only triangles that met a changed cell are divided again (clip/surface_cuts.hpp),
//   - winding numbers start from the Voronoi vertices that are still there (clip/winding.hpp),
//   - only facets of changed cells are chained and triangulated, only their pieces assembled, measured and
//     given hulls.
// What is linear in the whole mesh is a few passes over arrays of numbers. DECISION.md has the figures.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "common/clip/surface_cuts.hpp"
#include "common/clip/winding.hpp"
#include "common/pipeline/fracture.hpp"

namespace fracture {

/// An answer as far as further hits need it: reusable for any number of them.
struct FracturedBase {
  Diagram diagram;
  SurfaceLabels surface;
  std::vector<InnerVertex> inner_vertices;
  struct Known {
    Fragment fragment;
    FragmentHulls hulls;  ///< none where none were asked for
    double volume_file;   ///< m³, as the certificate sums it
  };
  /// In the order of the answer; shared with the answers before and after it.
  std::vector<std::shared_ptr<const Known>> fragments;
  std::vector<std::uint32_t> first_of;  ///< per site + 1: range of `fragments`; empty where not `local`
  std::vector<Bond> bonds;
  /// Hits can be local: every fragment is a piece of one cell, nothing was united, dropped, kept, split or
  /// roughened. Where not, the whole is fractured again.
  bool local = false;
};

struct KeptAnswer {
  FracturedSolid fractured;
  FracturedBase base;  ///< for hits on this answer
};

/// Which of the hits of some parameters are new, and how much of the answer is wanted.
struct NewHits {
  std::uint32_t count =
      1;  ///< the last so many, which the answer before has not; at most as many as there are
  bool only_changed = false;  ///< what they left as it was is not in the answer; without levels and anchors
};

/// fracture(), keeping what further hits need. Errors of fracture().
Expected<KeptAnswer> fracture_and_keep(const Solid& solid, Diagram diagram,
                                       const FractureParameters& parameters, const Execution& execution,
                                       StageTimings& timings);
/// make_diagram() before it, with its errors too.
Expected<KeptAnswer> fracture_and_keep(const Solid& solid, const FractureParameters& parameters,
                                       const Execution& execution, StageTimings& timings);

/// The parameters without their last hits.
FractureParameters before_hits(FractureParameters parameters, std::uint32_t new_hits);

/// The answer to `parameters`, where `base` is the answer to before_hits() of them; with FracturedSolid::delta.
/// Errors of make_diagram() and fracture().
Expected<KeptAnswer> fracture_delta(const Solid& solid, const FracturedBase& base,
                                    const FractureParameters& parameters, const NewHits& new_hits,
                                    const Execution& execution, StageTimings& timings);

}  // namespace fracture
