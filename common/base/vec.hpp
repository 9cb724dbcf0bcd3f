// Small fixed vectors, as plain data. Every operation is written out, so that each compiler evaluates the
// same expression in the same order (a condition for identical bytes on all systems).
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

namespace fracture {

struct Vec2d {
  double x = 0, y = 0;
  friend bool operator==(const Vec2d&, const Vec2d&) = default;
};
struct Vec2f {
  float x = 0, y = 0;
  friend bool operator==(const Vec2f&, const Vec2f&) = default;
};
struct Vec3f {
  float x = 0, y = 0, z = 0;
  friend bool operator==(const Vec3f&, const Vec3f&) = default;
};
struct Vec4f {
  float x = 0, y = 0, z = 0, w = 0;
  friend bool operator==(const Vec4f&, const Vec4f&) = default;
};
struct Vec3d {
  double x = 0, y = 0, z = 0;
  double operator[](int axis) const { return axis == 0 ? x : axis == 1 ? y : z; }
  double& operator[](int axis) { return axis == 0 ? x : axis == 1 ? y : z; }
  friend bool operator==(const Vec3d&, const Vec3d&) = default;
};

inline Vec3d operator+(const Vec3d& a, const Vec3d& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3d operator-(const Vec3d& a, const Vec3d& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3d operator*(double s, const Vec3d& a) { return {s * a.x, s * a.y, s * a.z}; }
inline double dot(const Vec3d& a, const Vec3d& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3d cross(const Vec3d& a, const Vec3d& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double length(const Vec3d& a) { return std::sqrt(dot(a, a)); }  // sqrt is exactly rounded (IEEE 754)
inline Vec3d to_double(const Vec3f& a) { return {a.x, a.y, a.z}; }

/// Lexicographic order by x, then y, then z: the order of the sites' infinitesimal weights (exact/in_sphere.hpp).
inline bool lexicographic_less(const Vec3d& a, const Vec3d& b) {
  if (a.x != b.x) return a.x < b.x;
  if (a.y != b.y) return a.y < b.y;
  return a.z < b.z;
}

/// Axis-aligned box; empty until something is added.
struct Box {
  Vec3d min{HUGE_VAL, HUGE_VAL, HUGE_VAL}, max{-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};

  bool empty() const { return !(min.x <= max.x); }
  void add(const Vec3d& p) { add(p, p); }
  void add(const Box& b) { add(b.min, b.max); }  // an empty box changes nothing
  Vec3d size() const { return empty() ? Vec3d{} : max - min; }
  Vec3d center() const { return 0.5 * (min + max); }
  double longest_side() const {
    const Vec3d s = size();
    return std::fmax(s.x, std::fmax(s.y, s.z));
  }
  /// Written without branches, because it is unpredictable which side separates two boxes.
  bool intersects(const Box& b) const {
    return (b.max.x >= min.x) & (b.min.x <= max.x) & (b.max.y >= min.y) & (b.min.y <= max.y) &
           (b.max.z >= min.z) & (b.min.z <= max.z);
  }

 private:
  void add(const Vec3d& low, const Vec3d& high) {
    min = {low.x < min.x ? low.x : min.x, low.y < min.y ? low.y : min.y, low.z < min.z ? low.z : min.z};
    max = {high.x > max.x ? high.x : max.x, high.y > max.y ? high.y : max.y, high.z > max.z ? high.z : max.z};
  }
};

/// The intersection of two boxes. If they are disjoint, its minimum exceeds its maximum on some axis.
inline Box common_of(const Box& a, const Box& b) {
  Box common;
  for (int axis = 0; axis < 3; ++axis) {
    common.min[axis] = a.min[axis] < b.min[axis] ? b.min[axis] : a.min[axis];
    common.max[axis] = b.max[axis] < a.max[axis] ? b.max[axis] : a.max[axis];
  }
  return common;
}

}  // namespace fracture
