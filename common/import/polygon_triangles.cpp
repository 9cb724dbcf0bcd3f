#include "common/import/polygon_triangles.hpp"

#include <cmath>
#include <cstddef>

#include "common/base/execution.hpp"
#include "common/solid/loop_triangulation.hpp"

namespace fracture {
namespace {

/// The corners relative to the first one, so that far coordinates keep their digits. Empty if one does not fit in floats.
std::vector<Vec3f> near_first_corner(std::span<const Vec3d> corners) {
  std::vector<Vec3f> result;
  result.reserve(corners.size());
  for (const Vec3d& corner : corners) {
    const Vec3d p = corner - corners[0];
    const Vec3f q{static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
    if (!std::isfinite(q.x) || !std::isfinite(q.y) || !std::isfinite(q.z)) return {};
    result.push_back(q);
  }
  return result;
}

}  // namespace

bool flat_with_reflex_corner(std::span<const Vec3d> p) {
  const std::size_t n = p.size();
  // Newell's normal: twice the polygon's vector area.
  Vec3d normal, center;
  Box box;
  for (std::size_t k = 0; k < n; ++k) {
    normal = normal + cross(p[k] - p[0], p[(k + 1) % n] - p[0]);
    center = center + (1.0 / static_cast<double>(n)) * p[k];
    box.add(p[k]);
  }
  const double l = length(normal);
  if (!(l > 0)) return false;
  bool reflex = false;
  for (std::size_t k = 0; k < n; ++k) {
    if (std::fabs(dot(p[k] - center, normal)) > kFlat * box.longest_side() * l) return false;
    reflex |= dot(cross(p[(k + 1) % n] - p[k], p[(k + 2) % n] - p[(k + 1) % n]), normal) < 0;
  }
  return reflex;
}

void append_polygon(std::span<const Vec3d> corners, std::uint32_t first,
                    std::vector<std::array<std::uint32_t, 3>>& triangles) {
  if (corners.size() > 3 && flat_with_reflex_corner(corners)) {
    if (const std::vector<Vec3f> loop = near_first_corner(corners); !loop.empty()) {
      for (const auto& t : solid_detail::triangulate_loop(loop, kUninterrupted))
        triangles.push_back({first + t[0], first + t[1], first + t[2]});
      return;
    }
  }
  for (std::uint32_t k = 2; k < corners.size(); ++k) triangles.push_back({first, first + k - 1, first + k});
}

}  // namespace fracture
