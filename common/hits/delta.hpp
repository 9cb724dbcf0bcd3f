// A hit on what is fractured already: further sites are inserted into what was kept of the answer, only the cells
// that they change are made again, and the answer equals, to the bit, what fracture() makes of all sites from
// nothing (local_hit.hpp says how, DECISION.md why).
#pragma once

#include <cstdint>

#include "common/hits/kept_answer.hpp"
#include "common/pipeline/fracture.hpp"

namespace fracture {

struct KeptAnswer {
  FracturedSolid fractured;
  FracturedBase base;  ///< for hits on this answer
  bool local = false;  ///< made from what was kept and what changed, not from nothing
};

/// Which of the hits of some parameters are new, and how much of the answer is wanted.
struct NewHits {
  std::uint32_t count =
      1;  ///< the last so many, which the answer before has not; at most as many as there are
  bool only_changed = false;  ///< what they left as it was is not in the answer; without levels
};

/// fracture(), keeping what further hits need. Errors of fracture().
Expected<KeptAnswer> fracture_and_keep(const Solid& solid, const Diagram& diagram,
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
