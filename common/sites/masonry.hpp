// Which parts of a solid are masonry, and which way their courses lie: what has most of its surface across three
// directions at right angles is a wall (a block, a house), whose bricks lie along them; anything else is none.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/base/execution.hpp"
#include "common/base/matrix3.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

struct Masonry {
  struct Frame {
    Matrix3 axes{};       ///< rows: those of the wall, each the nearest to x, y and z; of determinant 1
    bool is_wall = true;  ///< else rubble: stones that are flat across y
  };
  std::vector<Frame> frames;          ///< 1 … `most`, walls of different directions
  std::vector<std::uint8_t> of_part;  ///< index into frames
};

/// Where the whole is a wall, all of it is one; else each part for itself. What is none becomes rubble; without
/// `rubble` a wall along the axes of the world. Walls that find no frame become rubble, or such walls. Linear in the
/// triangles. Throws Interrupted.
Masonry masonry_of(const Solid& solid, bool rubble, std::size_t most, const Execution& execution = {});

}  // namespace fracture
