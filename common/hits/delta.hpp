// Hits on an answer that is already fractured. Only the fragments that the hits cut are made again. The result equals,
// bit for bit, the answer that fracture() makes with all hits, because both apply the hits in the same way
// (pipeline/broken_solid.hpp). DECISION.md explains what a hit cuts, and why.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/pipeline/broken_solid.hpp"
#include "common/pipeline/fracture.hpp"

namespace fracture {

/// The data of an answer that further hits need; reusable for any number of hits. Copies share the fragments.
struct FracturedBase {
  BrokenSolid broken;
  /// The hulls that the answer states, if they were trimmed because collision filters ran out; otherwise empty. These
  /// depend on all bodies, and hits cut the others.
  std::vector<FragmentHulls> stated_hulls{};
};
/// Bytes, including the object itself. Answers that share fragments each count them.
std::size_t memory_size(const FracturedBase& base);

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
