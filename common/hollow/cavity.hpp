// The hollow of one part, with what is known of its walls.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/base/execution.hpp"
#include "common/bvh/surface_tree.hpp"
#include "common/hollow/inner_surface.hpp"

namespace fracture::hollow_detail {

struct Cavity {
  /// At the middle of a triangle of its surface.
  struct Wall {
    double thickness, area;  ///< m, m²
  };
  std::size_t part = 0;
  InnerSurface surface;
  InnerSurfaceLimits other;                      ///< (inner_surface.hpp)
  std::vector<std::uint32_t> shell_of_triangle;  ///< those that hang together have one number
  std::uint32_t shells = 0;
  double volume = 0;  ///< m³
  double least_thickness = 0;
  std::vector<Wall> walls;
};

/// Without triangles where the part is nowhere thick enough. `outside`: the surface of the part, in that box. Throws
/// Interrupted.
Cavity cavity_of(std::size_t part, const SurfaceTree& outside, const Box& box, double thickness,
                 const InnerSurfaceLimits& limits, const Execution& execution);

}  // namespace fracture::hollow_detail
