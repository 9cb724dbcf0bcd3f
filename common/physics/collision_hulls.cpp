#include "common/physics/collision_hulls.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "common/base/scratch.hpp"
#include "common/physics/convex_hull.hpp"

namespace fracture {
namespace {

using Triangles = ConvexHullBuilder::Triangles;

/// What stands in for a body that is flat on the hull's grid: a box of a hundredth of its extent about its
/// middle.
CollisionHull stand_in(std::span<const Vec3f> points) {
  Box box;
  for (const Vec3f& p : points) box.add(to_double(p));
  const double least = 1e-4 * box.longest_side();
  CollisionHull hull;
  for (int k = 0; k < 8; ++k) {
    Vec3d p = box.center();
    for (int a = 0; a < 3; ++a)
      p[a] += (k >> a & 1 ? 0.005 : -0.005) * std::fmax(box.max[a] - box.min[a], least);
    hull.points.push_back({static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)});
  }
  hull.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return hull;
}

/// What a thread keeps from one hull to the next.
struct Maker {
  ConvexHullBuilder builder;
  std::vector<std::uint32_t> index;
  std::vector<Vec3f> corners;
  std::vector<std::uint32_t> corner_of;  // of the fragment's vertices

  std::size_t bytes() const { return builder.bytes() + bytes_of_vectors(index, corners, corner_of); }
  void release() {
    builder.release();
    release_vectors(index, corners, corner_of);
  }
};

/// Only the points on the hull, in the order they came in.
CollisionHull compact(std::span<const Vec3f> points, const Triangles& triangles,
                      std::vector<std::uint32_t>& index) {
  CollisionHull hull;
  if (triangles.size() + 4 == 2 * points.size()) {  // Euler: all of them
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

// Scaling about c by 1 - s moves the face at distance d from c inwards by s d. For the centre of volume d is
// at least a quarter of the least width w, and w / 2 >= V / A (a convex body; equality for a thin slab), so
// that s = inset A / V moves every face by at least inset / 2, and thin slabs by the inset.
void inset(CollisionHull& hull) {
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
  const double wanted = six_volumes > 0 ? kHullInset * 3 * two_areas / six_volumes : kMostHullShrink;
  const double shrink = std::clamp(wanted, kLeastHullShrink, kMostHullShrink);
  const Vec3d center = origin + (six_volumes > 0 ? 0.25 / six_volumes : 0) * moment;
  for (Vec3f& q : hull.points) {
    const Vec3d p = center + (1 - shrink) * (to_double(q) - center);
    q = {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
  }
}

void add_hull(std::span<const Vec3f> points, const BodySurface& surface, Maker& maker, FragmentHulls& out,
              const Execution& execution) {
  const Triangles& triangles = maker.builder.build(points, kMaxHullPoints, execution, surface);
  out.simplified += maker.builder.stopped_early();
  if (triangles.empty()) {
    ++out.flat;
    out.hulls.push_back(stand_in(points));
    return;
  }
  out.hulls.push_back(compact(points, triangles, maker.index));
  execution.poll();
  inset(out.hulls.back());
}

/// Each position once, though faces that differ there in their attributes have a vertex each.
void collect_corners(const Fragment& f, Maker& maker, const Execution& execution) {
  Pacer pacer(execution);
  maker.corners.clear();
  maker.corner_of.resize(f.positions.size());
  for (std::uint32_t v = 0; v < f.positions.size(); ++v) {
    pacer.step();
    if (f.topology[v] == v) {
      maker.corner_of[v] = static_cast<std::uint32_t>(maker.corners.size());
      maker.corners.push_back(f.positions[v]);
    } else {
      maker.corner_of[v] = maker.corner_of[f.topology[v]];  // an earlier one
    }
  }
}

}  // namespace

HullReport CollisionHulls::report() const {
  HullReport sum;
  for (const FragmentHulls& f : of_fragment) {
    sum.hulls += static_cast<std::uint32_t>(f.hulls.size());
    sum.flat += f.flat;
    sum.simplified += f.simplified;
  }
  return sum;
}

CollisionHulls make_collision_hulls(const FragmentSet& set, CollisionHulls known,
                                    const Execution& execution) {
  CollisionHulls out = std::move(known);
  out.of_fragment.resize(set.fragments.size());
  parallel_for(execution, set.fragments.size(), 8, [&](std::size_t begin, std::size_t end) {
    Maker& maker = thread_scratch<Maker>();
    for (std::size_t k = begin; k < end; ++k) {
      const Fragment& f = set.fragments[k];
      FragmentHulls& hulls = out.of_fragment[k];
      if (!hulls.hulls.empty() || f.positions.empty()) continue;
      if (f.bodies.empty()) {
        collect_corners(f, maker, execution);
        add_hull(maker.corners, {f.indices, maker.corner_of}, maker, hulls, execution);
      }
      for (const std::vector<Vec3f>& body : f.bodies) add_hull(body, {}, maker, hulls, execution);
    }
  });
  return out;
}

}  // namespace fracture
