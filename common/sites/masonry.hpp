// Finds which parts of a solid are masonry, and the direction of their courses. A part is a wall (a block, a
// house) if most of its surface is perpendicular to three orthogonal directions; its bricks are laid along
// these.
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
    Matrix3 axes{};       ///< rows: the axes of the wall nearest to x, y and z; determinant 1
    bool is_wall = true;  ///< otherwise rubble: stones that are flat across y
  };
  std::vector<Frame>
      frames;  ///< 1 to `most` (masonry_of()): one for each direction of walls, and one for other parts
  std::vector<std::uint8_t> of_part;  ///< index into frames
};

/// If the solid as a whole is a wall, all of it is one wall; otherwise each part is tested separately. Parts
/// that are not walls become rubble or, without `rubble`, a wall along the world axes. So do walls that
/// exceed the number of frames. Linear in the triangles. Throws Interrupted.
Masonry masonry_of(const Solid& solid, bool rubble, std::size_t most, const Execution& execution = {});

}  // namespace fracture
