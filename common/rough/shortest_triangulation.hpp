// Triangles between the corners of a polygon without width.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/pacer.hpp"
#include "common/base/vec.hpp"

namespace fracture {

inline double square_distance(const Vec2d& p, const Vec2d& q) {
  const double x = q.x - p.x, y = q.y - p.y;
  return x * x + y * y;
}

/// Triangulates a facet without width (four sites on a circle). Its sides coincide, so only triangles between
/// neighbours stay in place when it moves. Minimizes the sum of squared edges by dynamic programming (Gilbert
/// 1979, Klincsek 1980, for lengths). Keeps its buffers between polygons.
class ShortestTriangulation {
 public:
  /// Returns indices into `polygon`, which has at least one corner; no triangles if it has fewer than three.
  /// Time is cubic in the number of corners. Valid until the next call. Throws Interrupted.
  const std::vector<std::array<std::uint32_t, 3>>& build(std::span<const Vec2d> polygon, Pacer& pacer);

 private:
  std::vector<double> least_;
  std::vector<std::uint32_t> middle_;
  std::vector<std::array<std::uint32_t, 3>> triangles_;
};

}  // namespace fracture
