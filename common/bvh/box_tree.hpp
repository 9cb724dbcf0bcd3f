// A bounding volume hierarchy: boxes in a binary tree of boxes (Kay & Kajiya 1986, "Ray tracing complex
// scenes"). Finds the boxes that overlap a given box, overlap each other or satisfy another condition, and
// the box nearest to a point.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "common/base/pacer.hpp"
#include "common/base/radix_sort.hpp"
#include "common/base/vec.hpp"

namespace fracture {

/// Squared distance from p to the box; 0 inside.
inline double square_distance(const Box& box, const Vec3d& p) {
  const auto beyond = [](double low, double high, double x) {
    return x < low ? low - x : x > high ? x - high : 0;
  };
  const double x = beyond(box.min.x, box.max.x, p.x), y = beyond(box.min.y, box.max.y, p.y),
               z = beyond(box.min.z, box.max.z, p.z);
  return x * x + y * y + z * z;
}

class BoxTree {
 public:
  /// Sorts the boxes along the Morton curve through their middles, and divides them where its cells do
  /// (Lauterbach et al. 2009, "Fast BVH construction on GPUs"). This is repeated for each scale at which
  /// boxes differ. Linear per repetition. Throws Interrupted.
  explicit BoxTree(const std::vector<Box>& boxes, const Execution& execution = {});
  /// Boxes in consecutive groups, where group g begins at group_begin[g] (the last entry is the number of
  /// boxes). Pairs within a group are ignored. If the groups are compact, so is the tree, because whole
  /// groups are leaves of its upper part.
  BoxTree(const std::vector<Box>& boxes, const std::vector<std::uint32_t>& group_begin,
          const Execution& execution = {});
  /// Keeps the tree but replaces the boxes by the same number of new ones. Efficient while the boxes are near
  /// their original positions. Linear. Throws Interrupted.
  void refit(const std::vector<Box>& boxes, const Execution& execution = {});

  /// Calls visit(i) for every overlapping box.
  template <class Visit>
  void each_overlapping(const Box& box, const Visit& visit) const {
    if (!nodes_.empty()) descend(0, box, visit);
  }

  /// Calls visit(i) for every box for which enter() returns true, as it must for all enclosing boxes in the tree.
  /// enter(box) returns whether anything in a box is wanted. If so, leave() is called after its contents.
  template <class Enter, class Leave, class Visit>
  void each_entered(const Enter& enter, const Leave& leave, const Visit& visit) const {
    if (!nodes_.empty()) explore(0, enter, leave, visit);
  }

  /// A part of the search for all pairs. Tasks are independent of each other.
  using Task = std::pair<std::uint32_t, std::uint32_t>;
  /// Returns about `least` tasks or more, or as many as there are.
  std::vector<Task> pair_tasks(std::size_t least) const;
  /// Calls visit(i, j), i < j, once for every two boxes that overlap and, if there are groups, are in
  /// different groups.
  template <class Visit>
  void each_pair(const Task& task, const Visit& visit) const {
    pairs(task.first, task.second, visit);
  }

  /// Returns the minimum of `most` and distance(i) over all boxes. Calls distance(i) only if the box may be
  /// nearer. `slack`: more than the rounding error by which distance(i) may be too small; it makes the result
  /// independent of the tree.
  template <class Distance>
  double nearest(const Vec3d& p, double most, double slack, const Distance& distance) const {
    if (!nodes_.empty() && may_be_nearer(square_distance(nodes_[0].box, p), most, slack))
      approach(0, p, most, slack, distance);
    return most;
  }

 private:
  /// A leaf has the items [first, first + count). An inner node has count 0, and its children are the next
  /// node and `first`. `group`: the only group below it, or kNoGroup.
  struct Node {
    Box box;
    std::uint32_t first, count, group;
  };
  static constexpr std::uint32_t kNoGroup = 0xffffffffu;
  struct Item {
    Box box;
    std::uint32_t index;
  };
  struct Groups {
    const std::vector<Box>& items;
    const std::vector<Box>& boxes;            // boxes of the groups
    const std::vector<std::uint32_t>& begin;  // first item of each group
  };
  void build(const std::vector<Box>& boxes, std::span<Keyed> keys, std::uint32_t group, Pacer& pacer);
  void join_groups(const Groups& groups, std::span<Keyed> keys, Pacer& pacer);
  void have_children(std::size_t n, std::uint32_t second);

  template <class Visit>
  void descend(std::uint32_t n, const Box& box, const Visit& visit) const {
    const Node& node = nodes_[n];
    if (!node.box.intersects(box)) return;
    for (std::uint32_t k = node.first; k < node.first + node.count; ++k)
      if (items_[k].box.intersects(box)) visit(items_[k].index);
    if (node.count > 0) return;
    descend(n + 1, box, visit);
    descend(node.first, box, visit);
  }

  template <class Enter, class Leave, class Visit>
  void explore(std::uint32_t n, const Enter& enter, const Leave& leave, const Visit& visit) const {
    const Node& node = nodes_[n];
    if (!enter(node.box)) return;
    for (std::uint32_t k = node.first; k < node.first + node.count; ++k)
      if (enter(items_[k].box)) {
        visit(items_[k].index);
        leave();
      }
    if (node.count == 0) {
      explore(n + 1, enter, leave, visit);
      explore(node.first, enter, leave, visit);
    }
    leave();
  }

  template <class Visit>
  void visit_pair(const Item& a, const Item& b, const Visit& visit) const {
    if (a.box.intersects(b.box))
      visit(a.index < b.index ? a.index : b.index, a.index < b.index ? b.index : a.index);
  }
  template <class Visit>
  void pairs(std::uint32_t m, std::uint32_t n, const Visit& visit) const {
    const Node &a = nodes_[m], &b = nodes_[n];
    if (a.group != kNoGroup && a.group == b.group) return;
    if (m == n) {
      for (std::uint32_t i = a.first; i < a.first + a.count; ++i)
        for (std::uint32_t j = i + 1; j < a.first + a.count; ++j) visit_pair(items_[i], items_[j], visit);
      if (a.count > 0) return;
      pairs(m + 1, m + 1, visit);
      pairs(a.first, a.first, visit);
      pairs(m + 1, a.first, visit);
      return;
    }
    if (!a.box.intersects(b.box)) return;
    if (a.count > 0 && b.count > 0) {
      for (std::uint32_t i = a.first; i < a.first + a.count; ++i) {
        if (!items_[i].box.intersects(b.box)) continue;
        for (std::uint32_t j = b.first; j < b.first + b.count; ++j) visit_pair(items_[i], items_[j], visit);
      }
    } else if (a.count == 0) {
      pairs(m + 1, n, visit);
      pairs(a.first, n, visit);
    } else {
      pairs(m, n + 1, visit);
      pairs(m, b.first, visit);
    }
  }

  static bool may_be_nearer(double square, double most, double slack) {
    return square < (most + slack) * (most + slack);
  }
  template <class Distance>
  void approach(std::uint32_t n, const Vec3d& p, double& most, double slack, const Distance& distance) const {
    const Node& node = nodes_[n];
    for (std::uint32_t k = node.first; k < node.first + node.count; ++k)
      if (may_be_nearer(square_distance(items_[k].box, p), most, slack))
        most = std::fmin(most, distance(items_[k].index));
    if (node.count > 0) return;
    std::uint32_t near = n + 1, far = node.first;
    double near_square = square_distance(nodes_[near].box, p),
           far_square = square_distance(nodes_[far].box, p);
    if (far_square < near_square) {
      std::swap(near, far);
      std::swap(near_square, far_square);
    }
    if (may_be_nearer(near_square, most, slack)) approach(near, p, most, slack, distance);
    if (may_be_nearer(far_square, most, slack)) approach(far, p, most, slack, distance);
  }

  std::vector<Node> nodes_;
  std::vector<Item> items_;
};

inline Box box_of(const std::array<Vec3d, 3>& triangle) {
  Box box;
  for (const Vec3d& p : triangle) box.add(p);
  return box;
}

}  // namespace fracture
