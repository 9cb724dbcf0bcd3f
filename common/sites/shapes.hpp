// The shape of each part of a solid: a plate, a rod, or a body that is neither. The shape decides how brittle
// parts break (RadialPattern).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/base/execution.hpp"
#include "common/base/vec.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

struct PartShape {
  /// A part at least four times as long as it is wide.
  struct Rod {
    Vec3d axis;               ///< unit vector
    double from = 0, to = 0;  ///< ends along the axis, measured from the middle, m
    double width = 0;         ///< side of the square bar with the same moments across, m
  };
  Vec3d middle{};            ///< centre of mass
  std::optional<Rod> rod{};  ///< none if the part is not a rod
  /// For a plate (thickness <= width / 5): the direction in which it is thin. A strip is both
  std::optional<Vec3d> thin{};
};

struct Shapes {
  std::vector<PartShape> of_part;
  /// Frame of each part, for a map of cells: the largest parts have their own frames, and all others share
  /// the last one.
  std::vector<std::uint8_t> frame_of_part;
  std::size_t frames = 0;  ///< 0 … `most`
};

/// Returns no parts and no frames if the solid breaks as one: if it has one part, or if its plates form one
/// plate together, such as the panes of a window. Uses second moments, which are proportional to squared
/// lengths. If two volumes are equal, the earlier part counts as larger. `sizes`: per part, instead of the
/// volumes; empty: the volumes. Linear in the triangles. Throws Interrupted.
Shapes shapes_of(const Solid& solid, std::size_t most, const Execution& execution = {},
                 std::span<const double> sizes = {});

/// The direction in which the whole solid is thin, if it is a plate. Throws Interrupted.
std::optional<Vec3d> thin_axis(const Solid& solid, const Execution& execution = {});

}  // namespace fracture
