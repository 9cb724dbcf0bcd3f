#include "common/bvh/surface_tree.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/bvh/triangle_crossing.hpp"
#include "common/bvh/triangle_distance.hpp"

namespace fracture {
namespace {

/// Exceeds the rounding error of a sum of lengths.
constexpr double kBeyondRounding = 1 + 1e-9;
/// Exceeds the rounding error of a distance, relative to the largest coordinate.
constexpr double kRoundingOfDistances = 1e-12;

std::vector<Box> boxes_of(const std::vector<std::array<Vec3d, 3>>& triangles, const Execution& execution) {
  Pacer pacer(execution);
  std::vector<Box> boxes;
  boxes.reserve(triangles.size());
  for (const auto& t : triangles) {
    pacer.step();
    boxes.push_back(box_of(t));
  }
  return boxes;
}

}  // namespace

Vec3d nearest_on_triangle(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const Vec3d ab = b - a, ac = c - a, ap = p - a;
  const double d1 = dot(ab, ap), d2 = dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return a;
  const Vec3d bp = p - b;
  const double d3 = dot(ab, bp), d4 = dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0 && d1 - d3 > 0) return a + (d1 / (d1 - d3)) * ab;
  const Vec3d cp = p - c;
  const double d5 = dot(ab, cp), d6 = dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0 && d2 - d6 > 0) return a + (d2 / (d2 - d6)) * ac;
  const double va = d3 * d6 - d5 * d4;
  const double on_bc = d4 - d3, beyond = d5 - d6;
  if (va <= 0 && on_bc >= 0 && beyond >= 0 && on_bc + beyond > 0)
    return b + (on_bc / (on_bc + beyond)) * (c - b);
  const double sum = va + vb + vc;
  if (sum > 0) return a + (vb / sum) * ab + (vc / sum) * ac;
  const double to_a = length(p - a), to_b = length(p - b), to_c = length(p - c);  // a flat triangle
  return to_a <= to_b && to_a <= to_c ? a : to_b <= to_c ? b : c;
}

double distance_to_triangle(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  return length(p - nearest_on_triangle(p, a, b, c));
}

SurfaceTree::SurfaceTree(std::vector<std::array<Vec3d, 3>> triangles, const Execution& execution)
    : corners_(std::move(triangles)), tree_(boxes_of(corners_, execution), execution) {
  Pacer pacer(execution);
  for (const auto& t : corners_) {
    pacer.step();
    for (const Vec3d& p : t) slack_ = std::max({slack_, std::fabs(p.x), std::fabs(p.y), std::fabs(p.z)});
  }
  slack_ *= kRoundingOfDistances;
}

double SurfaceTree::nearer(const Vec3d& p, std::uint32_t triangle, double most, Pacer& pacer) const {
  pacer.step();
  const auto& [a, b, c] = corners_[triangle];
  // The distance to the plane is cheaper to compute, and may already be too large.
  const Vec3d n = cross(b - a, c - a);
  const double height = dot(n, p - a);
  if (height * height > (most + slack_) * (most + slack_) * dot(n, n)) return most;
  return std::min(most, distance_to_triangle(p, a, b, c));
}

double SurfaceTree::distance(const Vec3d& p, double most, Pacer& pacer) const {
  double least = most;
  return tree_.nearest(p, most, slack_,
                       [&](std::uint32_t triangle) { return least = nearer(p, triangle, least, pacer); });
}

bool SurfaceTree::within(const Vec3d& p, double distance, Pacer& pacer) const {
  return tree_.nearest(p, distance, slack_, [&](std::uint32_t triangle) {
    // No result can be nearer, so the search ends.
    return nearer(p, triangle, distance, pacer) < distance ? -slack_ : distance;
  }) < distance;
}

/// Calls visit(k) for each triangle of the surface that may be within reach() of the triangle. reach() may
/// decrease meanwhile; if it is negative, no triangle is visited.
template <class Reach, class Visit>
void SurfaceTree::each_within(const std::array<Vec3d, 3>& triangle, const Reach& reach, Pacer& pacer,
                              const Visit& visit) const {
  const Box around = box_of(triangle);
  const PlaneTriangle plane(triangle);
  const Vec3d along{std::fabs(plane.normal.x), std::fabs(plane.normal.y), std::fabs(plane.normal.z)};
  tree_.each_entered(
      [&](const Box& box) {
        pacer.step();
        const double near = reach();
        const Vec3d wide{near, near, near};
        return near >= 0 && box.intersects({around.min - wide, around.max + wide}) &&
               std::fabs(dot(plane.normal, box.center() - triangle[0])) <=
                   near + dot(along, 0.5 * box.size());
      },
      [] {}, visit);
}

std::optional<bool> SurfaceTree::near_triangle(const std::array<Vec3d, 3>& triangle, double distance,
                                               Pacer& pacer) const {
  const double near = kBeyondRounding * distance + 4 * slack_;
  std::array<std::uint32_t, kMostAsked> asked;
  std::size_t count = 0;
  each_within(
      triangle, [&] { return count <= kMostAsked ? near : -1; }, pacer,
      [&](std::uint32_t k) {
        if (count < kMostAsked) asked[count] = k;
        ++count;
      });
  if (count > kMostAsked) return std::nullopt;
  pacer.step(4 * count);
  return std::any_of(asked.begin(), asked.begin() + count,
                     [&](std::uint32_t k) { return are_within(triangle, corners_[k], near); });
}

double SurfaceTree::distance_of(const std::array<Vec3d, 3>& triangle, double most, Pacer& pacer) const {
  double least = most;
  each_within(
      triangle, [&] { return kBeyondRounding * least + 4 * slack_; }, pacer,
      [&](std::uint32_t k) {
        pacer.step(4);
        least = distance_of_triangles(triangle, corners_[k], least);
      });
  return least;
}

void SurfaceTree::distances(std::span<const Vec3d> points, double most, std::span<double> out,
                            Pacer& pacer) const {
  // The distance of a point to the surface is at most the distance of its neighbour plus the distance between
  // the two.
  for (std::size_t k = 0; k < points.size(); ++k) {
    const double least =
        k == 0 ? most
               : std::min(most,
                          kBeyondRounding * (out[k - 1] + length(points[k] - points[k - 1])) + 1e-12 * most);
    out[k] = distance(points[k], least, pacer);
  }
}

}  // namespace fracture
