// The cavity of one part, and measurements of its walls.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/base/execution.hpp"
#include "common/bvh/surface_tree.hpp"
#include "common/hollow/inner_surface.hpp"

namespace fracture::hollow_detail {

struct Cavity {
  /// The wall at the middle of one triangle of the inner surface.
  struct Wall {
    double thickness, area;  ///< m, m²
  };
  std::size_t part = 0;
  InnerSurface surface;
  InnerSurfaceLimits other;                      ///< see inner_surface()
  std::vector<std::uint32_t> shell_of_triangle;  ///< connected triangles have the same number
  std::uint32_t shells = 0;
  double volume = 0;  ///< m³
  double least_thickness = 0;
  std::vector<Wall> walls;
};

/// Computes the cavity of a part. It has no triangles if the part is nowhere thick enough. `outside`: the
/// surface of the part, which is in `box`. Throws Interrupted.
Cavity cavity_of(std::size_t part, const SurfaceTree& outside, const Box& box, double thickness,
                 const InnerSurfaceLimits& limits, const Execution& execution);

}  // namespace fracture::hollow_detail
