// A fragment that is fractured again in its place.
#pragma once

#include <cstdint>

#include "common/pipeline/fracture.hpp"

namespace fracture {

struct Refracture {
  std::uint64_t fragment = 0;  ///< id of a fragment of the answer to the parameters beside it
  std::uint32_t sites = 10;    ///< uniform in it
  std::uint64_t seed = 1;
};

/// The parts of this fragment of the answer to `parameters`, alone: a partition of it as it stands in the
/// file with Pivot::kSource. Limits of size apply to that answer; levels, anchors, hulls and roughness to the
/// parts. `diagram` is make_diagram() of these parameters. Errors: kNoSuchFragment, those of fracture().
Expected<FracturedSolid> refracture(const Solid& solid, const Diagram& diagram,
                                    const FractureParameters& parameters, const Refracture& wanted,
                                    const Execution& execution, StageTimings& timings);

}  // namespace fracture
