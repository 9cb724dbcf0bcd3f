// Which way the grain of each part of a solid runs: along its longest axis of inertia.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/base/execution.hpp"
#include "common/base/vec.hpp"
#include "common/sites/pattern.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

struct Grains {
  std::vector<Vec3d>
      directions;  ///< of unit length, up to `most`, no two within about ten degrees of each other
  std::vector<std::uint8_t> of_part;  ///< index into directions
};

/// `of`: parts of one node have one direction, that of all of them together; those of one material (that of most of a
/// part's surface) the one that they are long in, each about its own middle. `whole`: for what is not half as long again as it is wide. Where there are more directions than
/// `most`, those of the smallest parts become the nearest others. Throws Interrupted.
Grains grains_of(const Solid& solid, GrainOf of, const Vec3d& whole, std::size_t most,
                 const Execution& execution = {});

}  // namespace fracture
