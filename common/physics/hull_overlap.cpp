#include "common/physics/hull_overlap.hpp"

#include <algorithm>
#include <cmath>

namespace fracture {

void HullOverlap::round(std::span<const Vec3d> a, std::span<const Vec3d> b) {
  constexpr double kLast = 0x1p19 - 1;
  Box box;
  for (const std::span<const Vec3d> points : {a, b})
    for (const Vec3d& p : points) box.add(p);
  const double side = box.longest_side(), scale = side > 0 ? kLast / side : 0;
  const auto rounded = [&](std::span<const Vec3d> points, std::vector<Point>& out) {
    out.clear();
    for (const Vec3d& p : points) {
      const Vec3d q = scale * (p - box.min);
      out.push_back(
          {static_cast<std::int64_t>(q.x), static_cast<std::int64_t>(q.y), static_cast<std::int64_t>(q.z)});
    }
  };
  rounded(a, a_);
  rounded(b, b_);
}

/// Whether the difference extends beyond the origin in this direction. If not, the hulls are apart in this direction.
bool HullOverlap::reaches_beyond(const Point& direction, Point& farthest) {
  direction_ = direction;
  const auto extreme = [&](const std::vector<Point>& points, std::int64_t sign) {
    std::size_t at = 0;
    std::int64_t highest = INT64_MIN;
    for (std::size_t k = 0; k < points.size(); ++k) {
      const std::int64_t height = sign * dot(direction, points[k]);
      if (height <= highest) continue;
      highest = height;
      at = k;
    }
    return points[at];
  };
  farthest = minus(extreme(a_, 1), extreme(b_, -1));
  return dot(direction, farthest) > 0;
}

/// Finds the first wanted corner among the farthest ones in these directions. Returns false if a direction shows that the
/// hulls are apart. One of them does if no corner is wanted: the difference then has no width along this direction.
template <class IsWanted>
bool HullOverlap::find_corner(std::span<const Point> directions, const IsWanted& is_wanted, Point& corner) {
  for (const Point& direction : directions) {
    if (!reaches_beyond(direction, corner)) return false;
    if (is_wanted(corner)) return true;
  }
  return false;
}

/// Returns false if the hulls are apart.
bool HullOverlap::begin_with_a_tetrahedron() {
  faces_.clear();
  const auto middle = [](const std::vector<Point>& points) {
    Point sum{};
    for (const Point& p : points) sum = {sum.x + p.x, sum.y + p.y, sum.z + p.z};
    const auto n = static_cast<std::int64_t>(points.size());
    return Point{sum.x / n, sum.y / n, sum.z / n};
  };
  const Point to_b = minus(middle(b_), middle(a_));
  Point p, q, r, s;
  if (!reaches_beyond(to_b == Point{} ? Point{1, 0, 0} : to_b, p)) return false;
  const std::array<Point, 7> axes{opposite(direction_), {1, 0, 0}, {-1, 0, 0}, {0, 1, 0},
                                  {0, -1, 0},           {0, 0, 1}, {0, 0, -1}};
  if (!find_corner(
          axes, [&](const Point& corner) { return corner != p; }, q))
    return false;
  const Point u = minus(q, p);
  const std::int64_t x = std::abs(u.x), y = std::abs(u.y), z = std::abs(u.z);
  const Point v = cross(u, x <= y && x <= z ? Point{1, 0, 0}
                           : y <= z         ? Point{0, 1, 0}
                                            : Point{0, 0, 1}),
              w = cross(u, v);
  const std::array<Point, 4> around{v, opposite(v), w, opposite(w)};
  const auto off_the_line = [&](const Point& corner) { return cross(u, minus(corner, p)) != Point{}; };
  if (!find_corner(around, off_the_line, r)) return false;
  const Point n = cross(u, minus(r, p));
  const std::array<Point, 2> sides{n, opposite(n)};
  if (!find_corner(
          sides, [&](const Point& corner) { return dot(n, minus(corner, p)) != 0; }, s))
    return false;
  if (dot(n, minus(s, p)) > 0) std::swap(q, r);
  add_face(p, q, r);
  add_face(p, s, q);
  add_face(q, s, r);
  add_face(r, s, p);
  return true;
}

void HullOverlap::add_face(const Point& a, const Point& b, const Point& c) {
  const Point n = cross(minus(b, a), minus(c, a));
  const Vec3d normal{static_cast<double>(n.x), static_cast<double>(n.y), static_cast<double>(n.z)};
  faces_.push_back({{a, b, c}, n, static_cast<double>(dot(n, a)) / length(normal)});
}

/// Replaces the faces whose planes the corner is on or above by faces between the corner and their rim.
void HullOverlap::add_corner(const Point& corner) {
  rim_.clear();
  std::erase_if(faces_, [&](const Face& face) {
    if (dot(face.normal, minus(corner, face.corners[0])) < 0) return false;
    for (std::size_t k = 0; k < 3; ++k) {
      const Point &from = face.corners[k], &to = face.corners[(k + 1) % 3];
      const auto back =
          std::find_if(rim_.begin(), rim_.end(), [&](const Edge& e) { return e.from == to && e.to == from; });
      if (back == rim_.end()) {
        rim_.push_back({from, to});
      } else {
        *back = rim_.back();
        rim_.pop_back();
      }
    }
    return true;
  });
  for (const Edge& edge : rim_) add_face(edge.from, edge.to, corner);
}

HullDepth HullOverlap::measure(std::span<const Vec3d> a, std::span<const Vec3d> b, Pacer& pacer) {
  round(a, b);
  pacer.step(a.size() + b.size());
  if (begin_with_a_tetrahedron()) {
    for (;;) {
      pacer.step(a.size() + b.size() + faces_.size());
      const Face& least = *std::min_element(faces_.begin(), faces_.end(),
                                            [](const Face& x, const Face& y) { return x.depth < y.depth; });
      const std::int64_t height = dot(least.normal, least.corners[0]);
      Point corner;
      if (!reaches_beyond(least.normal, corner) || dot(direction_, corner) == height) break;
      add_corner(corner);
    }
  }
  const Vec3d direction{static_cast<double>(direction_.x), static_cast<double>(direction_.y),
                        static_cast<double>(direction_.z)};
  HullDepth result;
  result.normal = (1 / length(direction)) * direction;
  double last_of_a = -HUGE_VAL, first_of_b = HUGE_VAL;
  for (const Vec3d& p : a) last_of_a = std::fmax(last_of_a, fracture::dot(result.normal, p));
  for (const Vec3d& p : b) first_of_b = std::fmin(first_of_b, fracture::dot(result.normal, p));
  result.depth = last_of_a - first_of_b;
  return result;
}

}  // namespace fracture
