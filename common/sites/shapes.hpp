// What each part of a solid is by its shape: a plate, a rod, or a body that is neither. Brittle things break accordingly (RadialPattern).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "common/base/execution.hpp"
#include "common/base/vec.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

struct PartShape {
  /// At least four times as long as it is wide.
  struct Rod {
    Vec3d axis;               ///< of unit length
    double from = 0, to = 0;  ///< where it begins and ends along the axis, from the middle, m
    double width = 0;         ///< the side of a square bar with its moments across, m
  };
  Vec3d middle{};            ///< centre of mass
  std::optional<Rod> rod{};  ///< none of what is no rod
  std::optional<Vec3d>
      thin{};  ///< the way that a plate is thin: at most a fifth as thick as it is wide. A strip has both
};

struct Shapes {
  std::vector<PartShape> of_part;
  /// Of each part, for a map of cells: the largest have one each, all others the last one.
  std::vector<std::uint8_t> frame_of_part;
  std::size_t frames = 0;  ///< 0 … `most`
};

/// None (no part, no frame) of what breaks as one: a single part, or plates that are one together, such as the panes of
/// a window. By second moments, which go with the square of lengths; of equal volumes the earlier part is the larger.
/// Linear in the triangles. Throws Interrupted.
Shapes shapes_of(const Solid& solid, std::size_t most, const Execution& execution = {});

/// The direction in which all of it together is thin, where it is a plate. Throws Interrupted.
std::optional<Vec3d> thin_axis(const Solid& solid, const Execution& execution = {});

}  // namespace fracture
