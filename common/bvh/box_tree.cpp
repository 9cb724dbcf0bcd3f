#include "common/bvh/box_tree.hpp"

#include <algorithm>

namespace fracture {
namespace {

constexpr std::uint32_t kLeaf = 4;  // boxes, at most
/// Their median takes less than a few milliseconds: no comparison has to count.
constexpr std::uint32_t kSoonSelected = 1 << 16;

}  // namespace

BoxTree::BoxTree(const std::vector<Box>& boxes, const Execution& execution) {
  Pacer pacer(execution);
  items_.reserve(boxes.size());
  for (std::uint32_t k = 0; k < boxes.size(); ++k) items_.push_back({boxes[k], k});
  nodes_.reserve(boxes.size());
  if (!items_.empty()) build(0, static_cast<std::uint32_t>(items_.size()), kNoGroup, pacer);
}

BoxTree::BoxTree(const std::vector<Box>& boxes, const std::vector<std::uint32_t>& group_begin,
                 const Execution& execution) {
  Pacer pacer(execution);
  items_.reserve(boxes.size());
  nodes_.reserve(boxes.size() + group_begin.size());
  std::vector<Item> groups;
  for (std::uint32_t g = 0; g + 1 < group_begin.size(); ++g) {
    Box box;
    for (std::uint32_t k = group_begin[g]; k < group_begin[g + 1]; ++k) {
      items_.push_back({boxes[k], k});
      box.add(boxes[k]);
      pacer.step();
    }
    if (!box.empty()) groups.push_back({box, g});
  }
  if (!groups.empty()) join_groups(groups, 0, static_cast<std::uint32_t>(groups.size()), group_begin, pacer);
}

/// Items [first, last) with those that lie lower along the longest side of where their middles are before the
/// middle one; returns its number.
std::uint32_t BoxTree::halve(std::vector<Item>& items, std::uint32_t first, std::uint32_t last, Box& all,
                             Pacer& pacer) {
  pacer.step(last - first);
  for (std::uint32_t k = first; k < last; ++k) all.add(items[k].box);
  const std::uint32_t half = first + (last - first) / 2;
  if (last - first <= kLeaf) return half;
  const auto twice_middle = [](const Item& item) { return item.box.min + item.box.max; };
  Box middles;
  for (std::uint32_t k = first; k < last; ++k) middles.add(twice_middle(items[k]));
  const Vec3d size = middles.size();
  int axis = 0;
  for (int a = 1; a < 3; ++a)
    if (size[a] > size[axis]) axis = a;
  const auto less = [&](const Item& x, const Item& y) {
    const double a = twice_middle(x)[axis], b = twice_middle(y)[axis];
    return a != b ? a < b : x.index < y.index;
  };
  const auto begin = items.begin();
  if (last - first < kSoonSelected)
    std::nth_element(begin + first, begin + half, begin + last, less);
  else
    std::nth_element(begin + first, begin + half, begin + last, [&](const Item& x, const Item& y) {
      pacer.step();
      return less(x, y);
    });
  return half;
}

void BoxTree::build(std::uint32_t first, std::uint32_t last, std::uint32_t group, Pacer& pacer) {
  Box all;
  const std::uint32_t half = halve(items_, first, last, all, pacer);
  const std::size_t node = nodes_.size();
  nodes_.push_back({all, first, last - first, group});
  if (last - first <= kLeaf) return;
  build(first, half, group, pacer);
  nodes_[node].first = static_cast<std::uint32_t>(nodes_.size());
  nodes_[node].count = 0;
  build(half, last, group, pacer);
}

void BoxTree::join_groups(std::vector<Item>& groups, std::uint32_t first, std::uint32_t last,
                          const std::vector<std::uint32_t>& group_begin, Pacer& pacer) {
  if (last - first == 1) {
    const std::uint32_t g = groups[first].index;
    return build(group_begin[g], group_begin[g + 1], g, pacer);
  }
  Box all;
  std::uint32_t half = halve(groups, first, last, all, pacer);
  const std::size_t node = nodes_.size();
  nodes_.push_back({all, 0, 0, kNoGroup});
  join_groups(groups, first, half, group_begin, pacer);
  nodes_[node].first = static_cast<std::uint32_t>(nodes_.size());
  join_groups(groups, half, last, group_begin, pacer);
}

void BoxTree::refit(const std::vector<Box>& boxes, const Execution& execution) {
  Pacer pacer(execution);
  for (Item& item : items_) {
    item.box = boxes[item.index];
    pacer.step();
  }
  for (std::size_t n = nodes_.size(); n-- > 0;) {  // children stand behind their parents
    Node& node = nodes_[n];
    pacer.step();
    node.box = {};
    for (std::uint32_t k = node.first; k < node.first + node.count; ++k) node.box.add(items_[k].box);
    if (node.count > 0) continue;
    node.box.add(nodes_[n + 1].box);
    node.box.add(nodes_[node.first].box);
  }
}

std::vector<BoxTree::Task> BoxTree::pair_tasks(std::size_t least) const {
  std::vector<Task> tasks;
  if (!nodes_.empty()) tasks.push_back({0, 0});
  for (bool divided = true; divided && tasks.size() < least;) {
    divided = false;
    std::vector<Task> finer;
    for (const auto& [m, n] : tasks) {
      const Node &a = nodes_[m], &b = nodes_[n];
      if (a.group != kNoGroup && a.group == b.group) continue;
      if (m != n && !a.box.intersects(b.box)) continue;
      if (m == n ? a.count > 0 : a.count > 0 || b.count > 0) {
        finer.push_back({m, n});
        continue;
      }
      divided = true;
      if (m == n)
        finer.insert(finer.end(), {{m + 1, m + 1}, {a.first, a.first}, {m + 1, a.first}});
      else
        finer.insert(finer.end(), {{m + 1, n + 1}, {m + 1, b.first}, {a.first, n + 1}, {a.first, b.first}});
    }
    tasks = std::move(finer);
  }
  return tasks;
}

}  // namespace fracture
