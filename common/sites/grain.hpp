// Which way the grain of each part of a solid runs: along its longest axis of inertia.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/base/execution.hpp"
#include "common/base/vec.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

struct Grains {
  std::vector<Vec3d>
      directions;  ///< of unit length, up to `most`, no two within about ten degrees of each other
  std::vector<std::uint8_t> of_part;  ///< index into directions
};

/// `whole`: for parts that are not half as long again as they are wide. `by_node`: parts of one node of the source
/// have one direction, that of all of them together. Where there are more directions than `most`, those of the
/// smallest parts become the nearest others. Throws Interrupted.
Grains grains_of(const Solid& solid, bool by_node, const Vec3d& whole, std::size_t most,
                 const Execution& execution = {});

}  // namespace fracture
