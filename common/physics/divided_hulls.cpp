#include "common/physics/divided_hulls.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "common/base/pacer.hpp"
#include "common/base/scratch.hpp"
#include "common/physics/convex_body.hpp"
#include "common/physics/convex_parts.hpp"

namespace fracture {
namespace {

/// Twice the triangle's area, along its normal.
Vec3d area_vector(std::span<const Vec3f> points, const std::array<std::uint32_t, 3>& t) {
  const Vec3d a = to_double(points[t[0]]);
  return cross(to_double(points[t[1]]) - a, to_double(points[t[2]]) - a);
}

struct DivisionScratch {
  ConvexBody body;
  std::vector<std::array<std::uint32_t, 3>> triangles;

  std::size_t bytes() const { return body.bytes() + bytes_of_vectors(triangles); }
  void release() {
    body.release();
    release_vectors(triangles);
  }
};

/// Twice the area of the shadow that a closed surface casts along a direction, times the direction's length. Larger if some
/// rays cross the surface more than twice.
double shadow(std::span<const Vec3f> points, std::span<const std::array<std::uint32_t, 3>> triangles,
              const Vec3d& along, Pacer& pacer) {
  double sum = 0;
  pacer.each(0, triangles.size(),
             [&](std::size_t t) { sum += std::fabs(dot(along, area_vector(points, triangles[t]))); });
  return 0.5 * sum;
}

/// Cuts hulls back to another hull.
class Cutback {
 public:
  Cutback(const CollisionHull& within, const Execution& execution)
      : within_(within), pacer_(execution), body_(thread_scratch<DivisionScratch>().body) {
    Box box;
    for (const Vec3f& p : within.points) box.add(to_double(p));
    on_plane_ = kOnPlane * box.longest_side();
  }

  void cut(CollisionHull& hull) {
    body_.set(hull.points, hull.triangles);
    for (const auto& t : within_.triangles) {
      const Vec3d a = to_double(within_.points[t[0]]), normal = area_vector(within_.points, t);
      const double l = length(normal);
      pacer_.step(body_.corners().size());
      if (!(l > 0)) continue;
      const Vec3d unit = (1 / l) * normal;
      if (body_.beyond(unit, dot(unit, a)) > on_plane_) body_.cut(unit, dot(unit, a), on_plane_);
    }
    hull = {};
    body_.write(hull.points, hull.triangles);
  }

 private:
  /// Corners this near to a plane count as on it, relative to the extent of `within`. A fraction of the least inset.
  static constexpr double kOnPlane = 4e-6;

  const CollisionHull& within_;
  Pacer pacer_;
  ConvexBody& body_;
  double on_plane_;
};

}  // namespace

bool close_an_opening(std::span<const CollisionHull> hulls, std::span<const Vec3f> points,
                      std::span<const std::array<std::uint32_t, 3>> triangles, double excess, Pacer& pacer) {
  Vec3d along;
  for (const CollisionHull& hull : hulls)
    for (const auto& t : hull.triangles)
      if (const Vec3d n = area_vector(hull.points, t); dot(n, n) > dot(along, along)) along = n;
  double of_hulls = 0;
  for (const CollisionHull& hull : hulls) of_hulls += shadow(hull.points, hull.triangles, along, pacer);
  return of_hulls > excess * shadow(points, triangles, along, pacer);
}

bool may_be_divided(const Fragment& f) {
  return f.open_edges == 0 && f.indices.size() <= 3 * kMostDividedTriangles && f.part_cells.empty();
}

void divide_hulls(const Fragment& f, const HullLimits& limits, HullMaker& maker, FragmentHulls& out,
                  const Execution& execution) {
  if (!may_be_divided(f) || (!f.caps.empty() && f.bodies.size() > 1)) return;
  std::vector<std::array<std::uint32_t, 3>>& triangles = thread_scratch<DivisionScratch>().triangles;
  const BodySurface surface(f.indices, maker.corner_of);
  triangles.clear();
  Pacer pacer(execution);
  pacer.each(0, surface.size(), [&](std::size_t t) { triangles.push_back(surface[t]); });
  const std::span<const CollisionHull> first(out.hulls.data(), 1);
  if (!f.caps.empty() && !close_an_opening(first, maker.corners, triangles, limits.excess, pacer)) return;
  ConvexParts parts = make_convex_parts(maker.corners, triangles, limits, execution);
  if (parts.hulls.empty() || !(parts.volume > 0)) return;  // flat, or a sheet whose sides coincide
  out.excess = out.volume / parts.volume;                  // nothing can fly into a closed cavity
  if (parts.hulls.size() == 1) return;

  const bool is_rough = !f.caps.empty() && !f.bodies.empty();
  FragmentHulls made;
  if (is_rough) {
    Cutback cutback(out.hulls[0], execution);
    for (CollisionHull& hull : parts.hulls) {
      cutback.cut(hull);
      if (hull.triangles.size() < 4) continue;  // all of it is in other cells
      if (hull.points.size() <= kMaxHullPoints && bounds_a_body(hull)) {
        made.volume += volume_within(hull.points, hull.triangles);
        made.hulls.push_back(std::move(hull));
      } else {
        add_hull(hull.points, {}, maker, made, execution);
      }
    }
  } else {
    made.hulls = std::move(parts.hulls);
    for (CollisionHull& hull : made.hulls) {
      execution.poll();
      made.volume += inset(hull, maker.rounding);
    }
  }
  made.simplified = parts.simplified;
  made.excess = made.volume / parts.volume;
  if (!made.hulls.empty() && made.excess < out.excess) out = std::move(made);
}

}  // namespace fracture
