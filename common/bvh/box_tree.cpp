#include "common/bvh/box_tree.hpp"

#include <algorithm>
#include <bit>
#include <span>

namespace fracture {
namespace {

constexpr std::uint32_t kLeaf = 4;  // maximum number of boxes
constexpr int kAxisBits = 21;       // in a Morton code

/// The lowest 21 bits of v, with two zeros before each.
std::uint64_t spread(std::uint64_t v) {
  v = (v | v << 32) & 0x001f00000000ffffu;
  v = (v | v << 16) & 0x001f0000ff0000ffu;
  v = (v | v << 8) & 0x100f00f00f00f00fu;
  v = (v | v << 4) & 0x10c30c30c30c30c3u;
  return (v | v << 2) & 0x1249249249249249u;
}

/// Computes the Morton code of the middle of a box, in cells of a cube around the middles of the boxes in
/// `keys`. All axes have the same scale, so long groups are divided along their length first.
class MortonCode {
 public:
  MortonCode(const std::vector<Box>& boxes, std::span<const Keyed> keys, Pacer& pacer) {
    Box middles;
    for (const Keyed& k : keys) {
      pacer.step();
      if (!boxes[k.index].empty()) middles.add(twice_middle(boxes[k.index]));
    }
    low_ = middles.min;
    const double side = middles.empty() ? 0 : middles.longest_side();
    scale_ = side > 0 && std::isfinite(kCells / side) ? kCells / side : 0;
  }
  std::uint64_t of(const Box& box) const {
    const Vec3d at = scale_ * (twice_middle(box) - low_);
    return spread(cell(at.x)) | spread(cell(at.y)) << 1 | spread(cell(at.z)) << 2;
  }

 private:
  static constexpr double kCells = (1 << kAxisBits) - 1;
  static Vec3d twice_middle(const Box& box) { return box.min + box.max; }
  static std::uint64_t cell(double v) { return v > 0 ? static_cast<std::uint64_t>(std::fmin(v, kCells)) : 0; }

  Vec3d low_;
  double scale_;
};

/// Sorts by code, then by index. The input must be in the order of the indices.
void sort_by_code(const std::vector<Box>& boxes, std::span<Keyed> keys, Pacer& pacer) {
  const MortonCode code(boxes, keys, pacer);
  for (Keyed& k : keys) {
    pacer.step();
    k.key = code.of(boxes[k.index]);
  }
  constexpr std::size_t kFew = 256;
  if (keys.size() > kFew) return radix_sort(keys, 0, 3 * kAxisBits, pacer);
  std::sort(keys.begin(), keys.end(), [](const Keyed& a, const Keyed& b) {
    return a.key != b.key ? a.key < b.key : a.index < b.index;
  });
}

/// Number of keys before the point where the codes differ in their highest differing bit. If all keys are in
/// one cell, they first get codes in their own cube, so groups that are small compared with the whole are
/// divided in the same way. If all middles are equal, half of the keys.
std::uint32_t parting(const std::vector<Box>& boxes, std::span<Keyed> keys, Pacer& pacer) {
  if (keys.front().key == keys.back().key) sort_by_code(boxes, keys, pacer);
  const std::uint64_t low = keys.front().key, high = keys.back().key;
  if (low == high) return static_cast<std::uint32_t>(keys.size() / 2);
  const std::uint64_t bound = high & ~(std::bit_floor(low ^ high) - 1);
  const auto first_above =
      std::partition_point(keys.begin(), keys.end(), [bound](const Keyed& k) { return k.key < bound; });
  return static_cast<std::uint32_t>(first_above - keys.begin());
}

std::vector<Keyed> keys_of(std::uint32_t begin, std::uint32_t end, Pacer& pacer) {
  std::vector<Keyed> keys;
  keys.reserve(end - begin);
  for (std::uint32_t k = begin; k < end; ++k) {
    pacer.step();
    keys.push_back({0, k});
  }
  return keys;
}

}  // namespace

BoxTree::BoxTree(const std::vector<Box>& boxes, const Execution& execution) {
  Pacer pacer(execution);
  items_.reserve(boxes.size());
  nodes_.reserve(boxes.size());
  std::vector<Keyed> keys = keys_of(0, static_cast<std::uint32_t>(boxes.size()), pacer);
  if (!keys.empty()) build(boxes, keys, kNoGroup, pacer);
}

BoxTree::BoxTree(const std::vector<Box>& boxes, const std::vector<std::uint32_t>& group_begin,
                 const Execution& execution) {
  Pacer pacer(execution);
  items_.reserve(boxes.size());
  nodes_.reserve(boxes.size() + group_begin.size());
  std::vector<Box> of_group(group_begin.size());
  std::vector<Keyed> groups;
  for (std::uint32_t g = 0; g + 1 < group_begin.size(); ++g) {
    for (std::uint32_t k = group_begin[g]; k < group_begin[g + 1]; ++k) {
      of_group[g].add(boxes[k]);
      pacer.step();
    }
    if (group_begin[g] < group_begin[g + 1]) groups.push_back({0, g});
  }
  if (!groups.empty()) join_groups({boxes, of_group, group_begin}, groups, pacer);
}

/// The keys must be sorted by code or all be the same.
void BoxTree::build(const std::vector<Box>& boxes, std::span<Keyed> keys, std::uint32_t group, Pacer& pacer) {
  const std::size_t n = nodes_.size();
  pacer.step();
  nodes_.push_back(
      {{}, static_cast<std::uint32_t>(items_.size()), static_cast<std::uint32_t>(keys.size()), group});
  if (keys.size() <= kLeaf) {
    for (const Keyed& k : keys) {
      items_.push_back({boxes[k.index], k.index});
      nodes_[n].box.add(boxes[k.index]);
    }
    return;
  }
  const std::uint32_t before = parting(boxes, keys, pacer);
  build(boxes, keys.first(before), group, pacer);
  const auto second = static_cast<std::uint32_t>(nodes_.size());
  build(boxes, keys.subspan(before), group, pacer);
  have_children(n, second);
}

/// Builds the upper part of the tree, above the trees of the groups in the keys.
void BoxTree::join_groups(const Groups& groups, std::span<Keyed> keys, Pacer& pacer) {
  if (keys.size() == 1) {
    const std::uint32_t g = keys[0].index;
    std::vector<Keyed> items = keys_of(groups.begin[g], groups.begin[g + 1], pacer);
    return build(groups.items, items, g, pacer);
  }
  const std::size_t n = nodes_.size();
  pacer.step();
  nodes_.push_back({{}, 0, 0, kNoGroup});
  const std::uint32_t before = parting(groups.boxes, keys, pacer);
  join_groups(groups, keys.first(before), pacer);
  const auto second = static_cast<std::uint32_t>(nodes_.size());
  join_groups(groups, keys.subspan(before), pacer);
  have_children(n, second);
}

/// The first child is the next node.
void BoxTree::have_children(std::size_t n, std::uint32_t second) {
  Node& node = nodes_[n];
  node.first = second;
  node.count = 0;
  node.box = nodes_[n + 1].box;
  node.box.add(nodes_[second].box);
}

void BoxTree::refit(const std::vector<Box>& boxes, const Execution& execution) {
  Pacer pacer(execution);
  for (Item& item : items_) {
    item.box = boxes[item.index];
    pacer.step();
  }
  for (std::size_t n = nodes_.size(); n-- > 0;) {  // children come after their parents
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
