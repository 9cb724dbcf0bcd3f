// Fractures a fragment again, in its place.
#pragma once

#include <cstdint>

#include "common/pipeline/fracture.hpp"

namespace fracture {

struct Refracture {
  std::uint64_t fragment = 0;  ///< id of a fragment in the answer to `parameters`
  std::uint32_t sites = 10;    ///< number of sites, uniformly distributed in it
  std::uint64_t seed = 1;
};

/// Returns only the parts of this fragment, which is in the answer to `parameters`. They partition the fragment as a
/// file with Pivot::kSource contains it. Size limits apply to that answer; levels, anchors, hulls and roughness apply
/// to the parts. `diagram`: make_diagram() of `parameters`. Errors: kNoSuchFragment, and those of fracture().
Expected<FracturedSolid> refracture(const Solid& solid, const Diagram& diagram,
                                    const FractureParameters& parameters, const Refracture& wanted,
                                    const Execution& execution, StageTimings& timings);

}  // namespace fracture
