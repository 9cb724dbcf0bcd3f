#include "common/rough/box_tree.hpp"

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
  if (!items_.empty()) build(0, static_cast<std::uint32_t>(items_.size()), pacer);
}

void BoxTree::build(std::uint32_t first, std::uint32_t last, Pacer& pacer) {
  const auto twice_middle = [](const Item& item) { return item.box.min + item.box.max; };
  Box all, middles;
  for (std::uint32_t k = first; k < last; ++k) {
    all.add(items_[k].box);
    middles.add(twice_middle(items_[k]));
  }
  pacer.step(last - first);
  const std::size_t node = nodes_.size();
  nodes_.push_back({all, first, last - first});
  if (last - first <= kLeaf) return;
  const Vec3d size = middles.size();
  int axis = 0;
  for (int a = 1; a < 3; ++a)
    if (size[a] > size[axis]) axis = a;
  const std::uint32_t half = first + (last - first) / 2;
  const auto less = [&](const Item& x, const Item& y) {
    const double a = twice_middle(x)[axis], b = twice_middle(y)[axis];
    return a != b ? a < b : x.index < y.index;
  };
  const auto begin = items_.begin();
  if (last - first < kSoonSelected)
    std::nth_element(begin + first, begin + half, begin + last, less);
  else
    std::nth_element(begin + first, begin + half, begin + last, [&](const Item& x, const Item& y) {
      pacer.step();
      return less(x, y);
    });
  build(first, half, pacer);
  nodes_[node].first = static_cast<std::uint32_t>(nodes_.size());
  nodes_[node].count = 0;
  build(half, last, pacer);
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
