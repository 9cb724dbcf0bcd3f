#include "common/structure/anchors.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "common/base/pacer.hpp"
#include "common/bvh/box_tree.hpp"
#include "common/bvh/ray_crossing.hpp"

namespace fracture {
namespace {

using Triangle = std::array<Vec3d, 3>;

/// One fragment in world space. After several queries, its triangles are put in a tree.
class Shape {
 public:
  Shape(const Fragment& f, Pacer& pacer, const Execution& execution)
      : indices_(f.indices), pacer_(pacer), execution_(execution) {
    points_.reserve(f.positions.size());
    for (const Vec3f& p : f.positions) {
      pacer_.step();
      points_.push_back(to_double(p) + f.pivot);
      box_.add(points_.back());
    }
  }
  const std::vector<Vec3d>& points() const { return points_; }
  const Box& box() const { return box_; }
  Pacer& pacer() const { return pacer_; }

  bool encloses(const Vec3d& q) {
    // Triangles that miss the ray in y or z by more than rounding count nothing (ray_crossing.hpp).
    const double off = 1e-9 * box_.longest_side(), far = HUGE_VAL;
    int winding = 0;
    each_near({{-far, q.y, q.z - off}, {far, q.y, q.z + off}}, [&](const Triangle& p) {
      winding += ray_crossing(p[0] - q, p[1] - q, p[2] - q);
      return true;
    });
    return winding != 0;
  }
  /// Whether meets(triangle) is true for any triangle whose box overlaps the given one.
  template <class Meets>
  bool any_near(const Box& box, const Meets& meets) {
    bool found = false;
    each_near(box, [&](const Triangle& p) { return !(found = found || meets(p)); });
    return found;
  }

 private:
  static constexpr std::size_t kOften = 8;

  Triangle triangle(std::size_t t) const {
    return {points_[indices_[3 * t]], points_[indices_[3 * t + 1]], points_[indices_[3 * t + 2]]};
  }
  /// Calls visit(triangle) for triangles near the box, until it returns false.
  template <class Visit>
  void each_near(const Box& box, const Visit& visit) {
    const std::size_t count = indices_.size() / 3;
    if (!tree_ && ++asked_ > kOften) {
      std::vector<Box> boxes(count);
      for (std::size_t t = 0; t < count; ++t) {
        pacer_.step();
        boxes[t] = box_of(triangle(t));
      }
      tree_.emplace(boxes, execution_);
    }
    bool more = true;
    const auto touch = [&](std::size_t t) {
      pacer_.step(4);
      if (more) more = visit(triangle(t));
    };
    if (tree_)
      tree_->each_overlapping(box, touch);
    else
      for (std::size_t t = 0; t < count && more; ++t) touch(t);
  }

  const std::vector<std::uint32_t>& indices_;
  Pacer& pacer_;
  const Execution& execution_;
  std::vector<Vec3d> points_;
  Box box_;
  std::size_t asked_ = 0;
  std::optional<BoxTree> tree_;
};

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

/// Whether a triangle and a box overlap: no axis separates them (Akenine-Möller 2001, "Fast 3D triangle-box
/// overlap testing").
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

/// The anchors, with trees of the boxes and points.
class AnchorTrees {
 public:
  AnchorTrees(const Anchors& anchors, double tolerance, const Execution& execution)
      : anchors_(anchors),
        tolerance_(tolerance),
        boxes_(wide_boxes(anchors, tolerance), execution),
        points_(boxes_of_points(anchors, tolerance), execution) {}

  bool hold(Shape& shape) const {
    for (const HalfSpace& plane : anchors_.planes) {
      const double l = length(plane.normal);
      shape.pacer().step(shape.points().size() / 8);
      for (const Vec3d& p : shape.points())
        if (dot(plane.normal, p) - plane.offset * l <= tolerance_ * l) return true;
    }
    bool held = false;
    boxes_.each_overlapping(shape.box(), [&](std::uint32_t k) {
      const Box& box = anchors_.boxes[k];
      const Vec3d center = box.center(), half = 0.5 * Box{box.min - margin(), box.max + margin()}.size();
      const Box wide{center - 1.001 * half, center + 1.001 * half};
      held = held || shape.encloses(center) ||
             shape.any_near(wide, [&](const Triangle& t) { return overlap(t, center, half); });
    });
    points_.each_overlapping(shape.box(), [&](std::uint32_t k) {
      const Vec3d& q = anchors_.points[k];
      const Box around{q - 1.001 * margin(), q + 1.001 * margin()};
      held = held || shape.encloses(q) ||
             shape.any_near(around, [&](const Triangle& t) { return is_near(t, q, tolerance_); });
    });
    return held;
  }

 private:
  Vec3d margin() const { return {tolerance_, tolerance_, tolerance_}; }
  static std::vector<Box> wide_boxes(const Anchors& anchors, double tolerance) {
    const Vec3d margin{tolerance, tolerance, tolerance};
    std::vector<Box> boxes;
    for (const Box& box : anchors.boxes) boxes.push_back({box.min - margin, box.max + margin});
    return boxes;
  }
  static std::vector<Box> boxes_of_points(const Anchors& anchors, double tolerance) {
    const Vec3d margin{tolerance, tolerance, tolerance};
    std::vector<Box> boxes;
    for (const Vec3d& q : anchors.points) boxes.push_back({q - margin, q + margin});
    return boxes;
  }

  const Anchors& anchors_;
  const double tolerance_;
  BoxTree boxes_, points_;
};

}  // namespace

AnchoredFragments find_anchored(const FragmentSet& set, const Anchors& anchors, double longest_side,
                                const Execution& execution) {
  Pacer pacer(execution);
  const AnchorTrees trees(anchors, kAnchorTolerance * longest_side, execution);
  AnchoredFragments anchored;
  anchored.held.reserve(set.fragments.size());
  for (const Fragment& f : set.fragments) {
    Shape shape(f, pacer, execution);
    anchored.held.push_back(static_cast<char>(trees.hold(shape)));
    anchored.count += anchored.held.back() ? 1 : 0;
  }
  return anchored;
}

}  // namespace fracture
