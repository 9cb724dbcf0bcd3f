#include "common/physics/hull_grid.hpp"

#include <cstdlib>

#include "common/mesh/mesh.hpp"

namespace fracture {
namespace {

/// Steps of the grid: a body this thin may be flat except for rounding.
constexpr double kFlat = 4;

}  // namespace

void HullGrid::round(std::span<const Vec3f> points, Pacer& pacer) {
  Box box;
  for (const Vec3f& p : points) box.add(to_double(p));
  // Each axis may have its own scale, because affine maps preserve hulls.
  Vec3d scale;
  for (int a = 0; a < 3; ++a) scale[a] = box.max[a] > box.min[a] ? kSide / (box.max[a] - box.min[a]) : 0;
  // The numbers are not negative, so truncation is the floor.
  const auto whole = [](double x) { return static_cast<double>(static_cast<std::int32_t>(x)); };
  points_.resize(points.size());
  pacer.each(0, points.size(), [&](std::size_t k) {
    const Vec3d q = to_double(points[k]) - box.min;
    points_[k] = {whole(q.x * scale.x + 0.5), whole(q.y * scale.y + 0.5), whole(q.z * scale.z + 0.5)};
  });
}

std::optional<std::array<std::uint32_t, 4>> HullGrid::first_tetrahedron(Pacer& pacer) const {
  const std::uint32_t count = size();
  std::uint32_t a = 0, b = 0;
  for (std::uint32_t p = 1; p < count; ++p) {
    pacer.step();
    if (less(p, a)) a = p;
    if (less(b, p)) b = p;
  }
  if (count == 0 || !less(a, b)) return std::nullopt;
  // The point farthest from the line. Rounding can only decide between points at the same distance, and it decides
  // equally on every machine.
  std::uint32_t c = kNoIndex;
  double farthest = 0;
  const Vec3d ab = points_[b] - points_[a];
  for (std::uint32_t p = 0; p < count; ++p) {
    pacer.step();
    const Vec3d n = cross(ab, points_[p] - points_[a]);
    const double d = dot(n, n);
    if (d > farthest || (d > 0 && d == farthest && less(c, p))) {
      farthest = d;
      c = p;
    }
  }
  if (c == kNoIndex) return std::nullopt;
  const Vec3d normal = plane(a, b, c).normal;
  std::uint32_t d = kNoIndex;
  std::int64_t highest = 0;
  for (std::uint32_t p = 0; p < count; ++p) {
    pacer.step();
    const std::int64_t h = std::abs(exact_height(normal, a, p));
    if (h > highest || (h > 0 && h == highest && less(d, p))) {
      highest = h;
      d = p;
    }
  }
  if (d == kNoIndex || static_cast<double>(highest) <= kFlat * length(normal)) return std::nullopt;
  if (exact_height(normal, a, d) > 0) std::swap(b, c);
  return std::array{a, b, c, d};
}

}  // namespace fracture
