// A k-d tree of points (Bentley 1975; with tight boxes at its nodes) that finds the points in a ball. Used if
// a walk along the diagram would visit too many points: for cells with many neighbours, and for points far
// from the start of the walk.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/vec.hpp"

namespace fracture {

class SiteTree {
 public:
  /// Points are identified by their index in this list. n log n.
  explicit SiteTree(std::span<const Vec3d> points);

  /// Calls visit(index, squared distance from q) for points in a ball about q, usually nearer ones first.
  /// `visit` returns the new squared radius of the ball. No point within that computed distance is left out
  /// (relative error below 2^-48).
  template <class Visit>
  void visit_near(const Vec3d& q, double radius2, const Visit& visit) const {
    if (nodes_.empty()) return;
    std::array<Step, kMaxDepth> stack;
    std::size_t top = 0;
    stack[top++] = {0, 0, static_cast<std::uint32_t>(points_.size()), distance2(nodes_[0], q)};
    while (top > 0) {
      const Step s = stack[--top];
      if (s.distance2 > radius2) continue;
      if (s.end - s.begin <= kLeaf) {
        for (std::uint32_t k = s.begin; k < s.end; ++k) {
          const Vec3d d = points_[k].at - q;
          const double d2 = dot(d, d);
          if (d2 <= radius2) radius2 = visit(points_[k].number, d2);
        }
        continue;
      }
      const std::uint32_t middle = s.begin + (s.end - s.begin) / 2;
      Step low{2 * s.node + 1, s.begin, middle, 0}, high{2 * s.node + 2, middle, s.end, 0};
      low.distance2 = distance2(nodes_[low.node], q);
      high.distance2 = distance2(nodes_[high.node], q);
      if (low.distance2 < high.distance2) std::swap(low, high);
      if (low.distance2 <= radius2) stack[top++] = low;
      if (high.distance2 <= radius2) stack[top++] = high;  // the nearer one comes next
    }
  }

 private:
  static constexpr std::uint32_t kLeaf = 8;
  static constexpr std::size_t kMaxDepth = 64;  ///< of the stack: one entry per level; 2^32 points have 32
  struct Point {
    Vec3d at;
    std::uint32_t number;
  };
  struct Step {
    std::uint32_t node, begin, end;  // range in points_
    double distance2;                // to its box
  };
  static double distance2(const Box& box, const Vec3d& q) {
    double sum = 0;
    for (int a = 0; a < 3; ++a) {
      const double below = box.min[a] - q[a], above = q[a] - box.max[a];
      const double d = below > 0 ? below : above > 0 ? above : 0;
      sum += d * d;
    }
    return sum;
  }
  void build(std::uint32_t node, std::uint32_t begin, std::uint32_t end);

  std::vector<Point> points_;  // the two halves of a node's range belong to its children
  std::vector<Box> nodes_;     // children of k: 2k + 1, 2k + 2
};

}  // namespace fracture
