#include "common/physics/hull_maker.hpp"

#include <algorithm>
#include <cmath>

#include "common/base/pacer.hpp"

namespace fracture {
namespace {

using Triangles = ConvexHullBuilder::Triangles;

/// Returns the hull of a body that is flat on the hull's grid: a cube about the mean of its points, which is always in the
/// body's hull. The cube's side is 1e-4 of the body's extent, but at least a few steps of floats there, because otherwise it
/// would have no volume.
CollisionHull stand_in(std::span<const Vec3f> points) {
  Box box;
  Vec3d middle;
  for (const Vec3f& p : points) {
    box.add(to_double(p));
    middle = middle + to_double(p);
  }
  middle = (1.0 / static_cast<double>(points.size())) * middle;
  const double half = 5e-5 * box.longest_side();
  constexpr double kSteps = 8 * 0x1p-23;
  CollisionHull hull;
  for (int k = 0; k < 8; ++k) {
    Vec3d p = middle;
    for (int a = 0; a < 3; ++a)
      p[a] += (k >> a & 1 ? 1 : -1) * std::fmax(half, kSteps * std::fabs(middle[a]));
    hull.points.push_back({static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)});
  }
  hull.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return hull;
}

/// Shrinks by `wanted`, within the bounds for the inset, or by `for_rounding` (of corners) if that is more.
void shrink(CollisionHull& hull, const Vec3d& center, double wanted, double for_rounding) {
  const double by = std::fmax(std::clamp(wanted, kLeastHullShrink, kMostHullShrink),
                              std::fmin(for_rounding, kMostRoundedShrink));
  for (Vec3f& q : hull.points) {
    const Vec3d p = center + (1 - by) * (to_double(q) - center);
    q = {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
  }
}

}  // namespace

void collect_corners(const Fragment& f, HullMaker& maker, const Execution& execution) {
  Pacer pacer(execution);
  maker.corners.clear();
  maker.corner_of.resize(f.positions.size());
  for (std::uint32_t v = 0; v < f.positions.size(); ++v) {
    pacer.step();
    if (f.topology[v] == v) {
      maker.corner_of[v] = static_cast<std::uint32_t>(maker.corners.size());
      maker.corners.push_back(f.positions[v]);
    } else {
      maker.corner_of[v] = maker.corner_of[f.topology[v]];  // an earlier vertex
    }
  }
}

CollisionHull compact(std::span<const Vec3f> points, const Triangles& triangles,
                      std::vector<std::uint32_t>& index) {
  CollisionHull hull;
  if (triangles.size() + 4 == 2 * points.size()) {  // Euler: all points are used
    hull.points.assign(points.begin(), points.end());
    hull.triangles = triangles;
    return hull;
  }
  index.assign(points.size(), 0);
  hull.points.reserve(triangles.size() / 2 + 2);  // Euler
  for (const auto& t : triangles)
    for (const std::uint32_t v : t) index[v] = 1;
  for (std::size_t k = 0; k < points.size(); ++k)
    if (index[k] == 1) {
      index[k] = static_cast<std::uint32_t>(hull.points.size());
      hull.points.push_back(points[k]);
    }
  hull.triangles.reserve(triangles.size());
  for (const auto& t : triangles) hull.triangles.push_back({index[t[0]], index[t[1]], index[t[2]]});
  return hull;
}

double volume_within(std::span<const Vec3f> points, std::span<const std::array<std::uint32_t, 3>> triangles) {
  if (triangles.empty()) return 0;
  const Vec3d origin = to_double(points[triangles[0][0]]);
  double sum = 0;
  for (const auto& t : triangles)
    sum += dot(to_double(points[t[0]]) - origin,
               cross(to_double(points[t[1]]) - origin, to_double(points[t[2]]) - origin));
  return sum / 6;
}

// Scaling about c by 1 - s moves the face at distance d from c inwards by s d. If c is the centre of
// volume, d is at least a quarter of the least width w. For a convex body, w / 2 >= V / A (equality: a thin slab).
// So s = inset A / V moves every face by at least inset / 2, and those of thin slabs by the inset.
double inset(CollisionHull& hull, double rounding) {
  const Vec3d origin = to_double(hull.points[0]);
  double six_volumes = 0, two_areas = 0;
  Vec3d moment;
  for (const auto& t : hull.triangles) {
    const Vec3d a = to_double(hull.points[t[0]]) - origin, b = to_double(hull.points[t[1]]) - origin,
                c = to_double(hull.points[t[2]]) - origin;
    const double six = dot(a, cross(b, c));
    six_volumes += six;
    moment = moment + six * (a + b + c);
    two_areas += length(cross(b - a, c - a));
  }
  const bool solid = six_volumes > 0;
  shrink(hull, origin + (solid ? 0.25 / six_volumes : 0) * moment,
         solid ? kHullInset * 3 * two_areas / six_volumes : kMostHullShrink,
         solid ? rounding * 3 * two_areas / six_volumes : 0);
  return solid ? six_volumes / 6 : 0;
}

bool bounds_a_body(const CollisionHull& hull) {
  if (hull.triangles.size() < 4 || hull.triangles.size() + 4 != 2 * hull.points.size())
    return false;  // Euler
  Vec3d middle;
  for (const Vec3f& p : hull.points) middle = middle + to_double(p);
  middle = (1.0 / static_cast<double>(hull.points.size())) * middle;
  return std::all_of(hull.triangles.begin(), hull.triangles.end(), [&](const auto& t) {
    const Vec3d a = to_double(hull.points[t[0]]);
    return dot(cross(to_double(hull.points[t[1]]) - a, to_double(hull.points[t[2]]) - a), middle - a) < 0;
  });
}

bool add_convex(std::span<const Vec3f> points, const BodySurface& surface, const ConvexMass& mass,
                double rounding, FragmentHulls& out) {
  if (points.size() > kMaxHullPoints || surface.size() + 4 != 2 * points.size())
    return false;  // Euler: no sphere
  CollisionHull hull;
  hull.triangles.reserve(surface.size());
  for (std::size_t t = 0; t < surface.size(); ++t) hull.triangles.push_back(surface[t]);
  hull.points.assign(points.begin(), points.end());
  shrink(hull, mass.center, kHullInset * mass.area / mass.volume, rounding * mass.area / mass.volume);
  out.hulls.push_back(std::move(hull));
  out.volume += mass.volume;
  return true;
}

void add_hull(std::span<const Vec3f> points, const BodySurface& surface, HullMaker& maker, FragmentHulls& out,
              const Execution& execution) {
  const Triangles& triangles =
      maker.builder.build(points, kMaxHullPoints, execution, surface, kHullTolerance);
  out.simplified += maker.builder.stopped_early();
  if (triangles.empty()) {
    ++out.flat;
    out.hulls.push_back(stand_in(points));
    return;
  }
  out.hulls.push_back(compact(points, triangles, maker.index));
  execution.poll();
  out.volume += inset(out.hulls.back(), maker.rounding);
}

}  // namespace fracture
