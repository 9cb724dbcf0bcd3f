#include "common/bvh/triangle_crossing.hpp"

namespace fracture {
namespace {

using Corners = std::array<Vec3d, 3>;

double height(const PlaneTriangle& t, const Vec3d& p) { return dot(t.normal, p - t.corners[0]); }

/// Whether x, in the plane, is inside all sides by more than the tolerance.
bool contains(const PlaneTriangle& t, const Vec3d& x, double tolerance) {
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3d side = t.corners[(k + 1) % 3] - t.corners[k];
    if (!(dot(t.normal, cross(side, x - t.corners[k])) > tolerance * length(side))) return false;
  }
  return true;
}

bool edges_pierce(const PlaneTriangle& s, const PlaneTriangle& t, double tolerance) {
  std::array<double, 3> h{};
  for (std::size_t k = 0; k < 3; ++k) h[k] = height(t, s.corners[k]);
  for (std::size_t k = 0; k < 3; ++k) {
    const double p = h[k], q = h[(k + 1) % 3];
    if (!((p > tolerance && q < -tolerance) || (p < -tolerance && q > tolerance))) continue;
    const Vec3d& from = s.corners[k];
    if (contains(t, from + (p / (p - q)) * (s.corners[(k + 1) % 3] - from), tolerance)) return true;
  }
  return false;
}

}  // namespace

bool is_parted(const PlaneTriangle& t, const Corners& corners, double tolerance) {
  const double a = height(t, corners[0]), b = height(t, corners[1]), c = height(t, corners[2]);
  return (a > tolerance || b > tolerance || c > tolerance) &&
         (a < -tolerance || b < -tolerance || c < -tolerance);
}

PlaneTriangle::PlaneTriangle(const Corners& t) : corners(t), normal(cross(t[1] - t[0], t[2] - t[0])) {
  const double l = length(normal);
  normal = l > 0 ? (1 / l) * normal : Vec3d{};
}

bool cross_each_other(const PlaneTriangle& s, const PlaneTriangle& t, double tolerance) {
  // If one triangle is on one side of the other's plane, no edge pierces.
  if (!is_parted(t, s.corners, tolerance) || !is_parted(s, t.corners, tolerance)) return false;
  return edges_pierce(s, t, tolerance) || edges_pierce(t, s, tolerance);
}

}  // namespace fracture
