#include "common/structure/anchors.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/fragment/ray_crossing.hpp"

namespace fracture {
namespace {

using Triangle = std::array<Vec3d, 3>;

/// One fragment in world space.
struct Shape {
  std::vector<Vec3d> points;
  const std::vector<std::uint32_t>* indices;
  Box box;

  explicit Shape(const Fragment& f) : indices(&f.indices) {
    points.reserve(f.positions.size());
    for (const Vec3f& p : f.positions) {
      points.push_back(to_double(p) + f.pivot);
      box.add(points.back());
    }
  }
  std::size_t triangles() const { return indices->size() / 3; }
  Triangle triangle(std::size_t t) const {
    return {points[(*indices)[3 * t]], points[(*indices)[3 * t + 1]], points[(*indices)[3 * t + 2]]};
  }
};

bool encloses(const Shape& shape, const Vec3d& q) {
  int winding = 0;
  for (std::size_t t = 0; t < shape.triangles(); ++t) {
    const Triangle p = shape.triangle(t);
    winding += ray_crossing(p[0] - q, p[1] - q, p[2] - q);
  }
  return winding != 0;
}

/// Squared distance from the origin to the segment (a, b).
double segment_distance2(const Vec3d& a, const Vec3d& b) {
  const Vec3d e = b - a;
  const double ee = dot(e, e), t = ee > 0 ? std::clamp(-dot(a, e) / ee, 0.0, 1.0) : 0.0;
  const Vec3d p = a + t * e;
  return dot(p, p);
}

bool is_near(const Triangle& t, const Vec3d& q, double tolerance) {
  const Vec3d a = t[0] - q, b = t[1] - q, c = t[2] - q;
  const double nearest =
      std::min({segment_distance2(a, b), segment_distance2(b, c), segment_distance2(c, a)});
  if (nearest <= tolerance * tolerance) return true;
  const Vec3d n = cross(b - a, c - a);
  const double l = length(n);
  if (!(l > 0) || std::fabs(dot(n, a)) > tolerance * l) return false;
  return dot(n, cross(a, b)) >= 0 && dot(n, cross(b, c)) >= 0 && dot(n, cross(c, a)) >= 0;
}

/// Akenine-Möller 2001, "Fast 3D triangle-box overlap testing": no axis separates them.
bool overlap(const Triangle& t, const Vec3d& center, const Vec3d& half) {
  const Vec3d v[3] = {t[0] - center, t[1] - center, t[2] - center};
  const Vec3d e[3] = {v[1] - v[0], v[2] - v[1], v[0] - v[2]};
  const auto separates = [&](const Vec3d& axis) {
    const double a = dot(axis, v[0]), b = dot(axis, v[1]), c = dot(axis, v[2]);
    const double r = half.x * std::fabs(axis.x) + half.y * std::fabs(axis.y) + half.z * std::fabs(axis.z);
    return std::min({a, b, c}) > r || std::max({a, b, c}) < -r;
  };
  for (int k = 0; k < 3; ++k) {
    Vec3d unit;
    unit[k] = 1;
    if (separates(unit)) return false;
    for (const Vec3d& edge : e)
      if (separates(cross(unit, edge))) return false;
  }
  return !separates(cross(e[0], e[1]));
}

bool is_held(const Shape& shape, const Anchors& anchors, double tolerance) {
  for (const HalfSpace& plane : anchors.planes) {
    const double l = length(plane.normal);
    for (const Vec3d& p : shape.points)
      if (dot(plane.normal, p) - plane.offset * l <= tolerance * l) return true;
  }
  for (const Box& box : anchors.boxes) {
    const Vec3d center = box.center(), margin{tolerance, tolerance, tolerance};
    const Box wide{box.min - margin, box.max + margin};
    if (!wide.intersects(shape.box)) continue;
    if (encloses(shape, center)) return true;
    for (std::size_t t = 0; t < shape.triangles(); ++t)
      if (overlap(shape.triangle(t), center, 0.5 * wide.size())) return true;
  }
  for (const Vec3d& q : anchors.points) {
    const Vec3d margin{tolerance, tolerance, tolerance};
    if (!Box{q - margin, q + margin}.intersects(shape.box)) continue;
    if (encloses(shape, q)) return true;
    for (std::size_t t = 0; t < shape.triangles(); ++t)
      if (is_near(shape.triangle(t), q, tolerance)) return true;
  }
  return false;
}

}  // namespace

std::uint32_t mark_anchored(FragmentSet& set, const Anchors& anchors) {
  Box box;
  for (const Fragment& f : set.fragments)
    for (const Vec3f& p : f.positions) box.add(to_double(p) + f.pivot);
  std::uint32_t held = 0;
  for (Fragment& f : set.fragments) {
    f.anchored = is_held(Shape(f), anchors, kAnchorTolerance * box.longest_side());
    held += f.anchored ? 1 : 0;
  }
  return held;
}

}  // namespace fracture
