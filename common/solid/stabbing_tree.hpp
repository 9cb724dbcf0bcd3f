// Finds which of many bounded items can contain a point: a tree of bounding slabs.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "common/base/pacer.hpp"

namespace fracture::solid_detail {

/// Extent of an item along each of K directions: low, high.
template <int K>
using Slabs = std::array<std::array<double, 2>, K>;

/// A bounding volume hierarchy whose volumes are intersections of slabs in K fixed directions (discrete
/// oriented polytopes: Klosowski et al. 1998). Each node is divided at the median along the direction in
/// which the middles are spread most.
template <int K>
class StabbingTree {
 public:
  /// `slabs_of(item)` returns Slabs<K>.
  template <class SlabsOf>
  StabbingTree(std::vector<std::uint32_t> items, const SlabsOf& slabs_of, Pacer& pacer)
      : pacer_(pacer), items_(std::move(items)) {
    std::size_t leaves = 1;
    while (leaves * kLeafSize < items_.size()) leaves *= 2;
    first_leaf_ = leaves - 1;
    nodes_.resize(2 * leaves - 1);
    std::vector<Key> keys(items_.size());
    split(0, 0, items_.size(), slabs_of, keys);
  }

  /// Calls visit(item) for every item whose slabs contain the point, and possibly for others.
  template <class Visit>
  void for_each_near(const std::array<double, K>& point, Visit&& visit) const {
    std::size_t stack[64] = {0}, size = 1;
    while (size > 0) {
      const std::size_t at = stack[--size];
      const Node& node = nodes_[at];
      pacer_.step();
      bool contains = true;
      for (int k = 0; k < K; ++k) contains &= node.slabs[k][0] <= point[k] && point[k] <= node.slabs[k][1];
      if (!contains) continue;
      if (at < first_leaf_) {
        stack[size++] = 2 * at + 2;
        stack[size++] = 2 * at + 1;
        continue;
      }
      for (std::size_t i = node.begin; i < node.end; ++i) visit(items_[i]);
    }
  }

 private:
  static constexpr std::size_t kLeafSize = 8;
  struct Node {
    Slabs<K> slabs;
    std::size_t begin = 0, end = 0;  ///< items of a leaf
  };
  struct Key {
    double middle;
    std::uint32_t item;
  };

  template <class SlabsOf>
  void split(std::size_t at, std::size_t begin, std::size_t end, const SlabsOf& slabs_of,
             std::vector<Key>& keys) {
    Node& node = nodes_[at];
    if (at >= first_leaf_) {
      node.begin = begin;
      node.end = end;
      node.slabs.fill({HUGE_VAL, -HUGE_VAL});
      for (std::size_t i = begin; i < end; ++i) widen(node.slabs, slabs_of(items_[i]));
      pacer_.step(end - begin);
      return;
    }
    const int axis = widest(begin, end, slabs_of);
    for (std::size_t i = begin; i < end; ++i) {
      pacer_.step();
      const std::array<double, 2> slab = slabs_of(items_[i])[axis];
      keys[i] = {slab[0] + slab[1], items_[i]};
    }
    const std::size_t middle = begin + (end - begin) / 2;
    const auto key = [&keys](std::size_t i) { return keys.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(key(begin), key(middle), key(end), [this](const Key& a, const Key& b) {
      pacer_.step();
      return a.middle < b.middle;
    });
    for (std::size_t i = begin; i < end; ++i) items_[i] = keys[i].item;
    split(2 * at + 1, begin, middle, slabs_of, keys);
    split(2 * at + 2, middle, end, slabs_of, keys);
    node.slabs = nodes_[2 * at + 1].slabs;
    widen(node.slabs, nodes_[2 * at + 2].slabs);
  }

  /// The direction in which the middles of a sample of the items are spread most.
  template <class SlabsOf>
  int widest(std::size_t begin, std::size_t end, const SlabsOf& slabs_of) const {
    Slabs<K> middles;
    middles.fill({HUGE_VAL, -HUGE_VAL});
    const std::size_t step = std::max<std::size_t>(1, (end - begin) / 64);
    for (std::size_t i = begin; i < end; i += step) {
      Slabs<K> slabs = slabs_of(items_[i]);
      for (auto& [low, high] : slabs) low = high = low + high;
      widen(middles, slabs);
    }
    int axis = 0;
    for (int k = 1; k < K; ++k)
      if (middles[k][1] - middles[k][0] > middles[axis][1] - middles[axis][0]) axis = k;
    return axis;
  }
  static void widen(Slabs<K>& slabs, const Slabs<K>& by) {
    for (int k = 0; k < K; ++k) {
      slabs[k][0] = std::min(slabs[k][0], by[k][0]);
      slabs[k][1] = std::max(slabs[k][1], by[k][1]);
    }
  }

  Pacer& pacer_;
  std::vector<std::uint32_t> items_;
  std::size_t first_leaf_ = 0;
  std::vector<Node> nodes_;  ///< complete binary tree: the children of k are 2 k + 1 and 2 k + 2
};

}  // namespace fracture::solid_detail
