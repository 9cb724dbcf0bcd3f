// Hits on an answer that is already fractured. Further sites are inserted into the stored data of the answer,
// and only the cells that they change are made again. The result equals, bit for bit, what fracture() makes
// of all sites from scratch. (local_hit.hpp explains how, and DECISION.md why.)
#pragma once

#include <cstdint>

#include "common/hits/kept_answer.hpp"
#include "common/pipeline/fracture.hpp"

namespace fracture {

struct KeptAnswer {
  FracturedSolid fractured;
  FracturedBase base;  ///< for hits on this answer
  bool local = false;  ///< made from stored data and changes, not from scratch
};

/// Which of the hits in some parameters are new, and how much of the answer is wanted.
struct NewHits {
  std::uint32_t count =
      1;  ///< number of last hits that are not in the previous answer; at most the number of hits
  bool only_changed = false;  ///< leaves out unchanged fragments; not with levels
};

/// Runs fracture(), and stores the data that further hits need. Errors of fracture().
Expected<KeptAnswer> fracture_and_keep(const Solid& solid, const Diagram& diagram,
                                       const FractureParameters& parameters, const Execution& execution,
                                       StageTimings& timings);
/// Runs make_diagram() first, and has its errors too.
Expected<KeptAnswer> fracture_and_keep(const Solid& solid, const FractureParameters& parameters,
                                       const Execution& execution, StageTimings& timings);

/// Returns the parameters without their last hits.
FractureParameters before_hits(FractureParameters parameters, std::uint32_t new_hits);

/// Returns the answer to `parameters`, with FracturedSolid::delta. `base` must be the answer to before_hits()
/// of the parameters. Errors of make_diagram() and fracture().
Expected<KeptAnswer> fracture_delta(const Solid& solid, const FracturedBase& base,
                                    const FractureParameters& parameters, const NewHits& new_hits,
                                    const Execution& execution, StageTimings& timings);

}  // namespace fracture
