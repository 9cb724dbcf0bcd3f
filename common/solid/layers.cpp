#include "common/solid/layers.hpp"

#include <algorithm>

#include "common/base/pacer.hpp"
#include "common/solid/polled.hpp"

namespace fracture::solid_detail {
namespace {

/// The boxes that have a layer, in a tree whose shape is determined by the centres of all boxes (k-d tree,
/// Bentley 1975). So it stays balanced regardless of the order in which they are added.
class BoxTree {
 public:
  BoxTree(const std::vector<Part>& parts, const Execution& execution)
      : parts_(parts), pacer_(execution), slots_(parts.size()), leaf_of_(parts.size()) {
    std::size_t leaves = 1;
    while (leaves * kLeafSize < parts.size()) leaves *= 2;
    first_leaf_ = leaves - 1;
    nodes_.resize(2 * leaves - 1);
    for (std::uint32_t i = 0; i < slots_.size(); ++i) slots_[i] = i;
    split(0, 0, slots_.size());
  }

  void add(std::uint32_t part) {
    const Box& box = parts_[part].box;
    std::size_t at = leaf_of_[part];
    slots_[nodes_[at].begin + nodes_[at].count++] = part;
    for (;; at = (at - 1) / 2) {
      nodes_[at].box.add(box);
      nodes_[at].layers = std::max(nodes_[at].layers, parts_[part].layer + 1);
      if (at == 0) return;
    }
  }

  /// Calls visit(j) for every added part that has a layer >= `lowest` and touches the box.
  template <class Visit>
  void for_each_touching(const Box& box, std::uint32_t lowest, Visit&& visit) {
    std::size_t stack[64] = {0}, size = 1;
    while (size > 0) {
      const std::size_t at = stack[--size];
      const Node& node = nodes_[at];
      pacer_.step(1 + node.count);
      if (node.layers <= lowest || !node.box.intersects(box)) continue;
      if (at < first_leaf_) {
        stack[size++] = 2 * at + 2;
        stack[size++] = 2 * at + 1;
        continue;
      }
      for (std::size_t k = node.begin; k < node.begin + node.count; ++k)
        if (const Part& part = parts_[slots_[k]]; part.layer >= lowest && part.box.intersects(box))
          visit(slots_[k]);
    }
  }

 private:
  static constexpr std::size_t kLeafSize = 8;
  struct Node {
    Box box;                   ///< of the parts added so far
    std::uint32_t layers = 0;  ///< 1 + the highest layer of these parts
    std::uint32_t count = 0;   ///< leaves: number of added parts, in slots_ from `begin`
    std::size_t begin = 0;
  };

  /// Assigns the parts slots_[begin, end) to the subtree, and halves them along the axis in which their
  /// centres are spread most.
  void split(std::size_t at, std::size_t begin, std::size_t end) {
    if (at >= first_leaf_) {
      nodes_[at].begin = begin;
      for (std::size_t k = begin; k < end; ++k) leaf_of_[slots_[k]] = at;
      return;
    }
    Box centers;
    for (std::size_t k = begin; k < end; ++k) {
      pacer_.step();
      centers.add(parts_[slots_[k]].box.center());
    }
    int axis = 0;
    for (int a = 1; a < 3; ++a)
      if (centers.size()[a] > centers.size()[axis]) axis = a;
    const std::size_t middle = begin + (end - begin) / 2;
    const auto slot = [this](std::size_t k) { return slots_.begin() + static_cast<std::ptrdiff_t>(k); };
    std::nth_element(slot(begin), slot(middle), slot(end), [&](std::uint32_t a, std::uint32_t b) {
      pacer_.step();
      return parts_[a].box.min[axis] + parts_[a].box.max[axis] <
             parts_[b].box.min[axis] + parts_[b].box.max[axis];
    });
    split(2 * at + 1, begin, middle);
    split(2 * at + 2, middle, end);
  }

  const std::vector<Part>& parts_;
  Pacer pacer_;
  std::size_t first_leaf_ = 0;
  std::vector<Node> nodes_;           ///< complete binary tree: the children of k are 2 k + 1 and 2 k + 2
  std::vector<std::uint32_t> slots_;  ///< the parts of each leaf; added ones come first
  std::vector<std::size_t> leaf_of_;  ///< per part
};

/// One box per layer, with a tree over the layers that finds the lowest layer whose box is not touched. If
/// boxes pile up (bars next to each other, shells within shells), this one box is enough to show that a layer
/// is taken.
class LayerTree {
 public:
  std::uint32_t layers() const { return layers_; }

  /// Returns the lowest layer >= `from` whose box does not touch this box, or layers().
  std::uint32_t first_untouched(const Box& box, std::uint32_t from) const {
    std::size_t at = from + width_;
    if (from >= layers_) return layers_;
    while (touches_all(nodes_[at], box)) {  // all boxes below `at` are touched: continue to the right
      while (at % 2 == 1) at /= 2;
      if (at == 0) return layers_;
      ++at;
    }
    while (at < width_) {
      at *= 2;
      if (touches_all(nodes_[at], box)) ++at;
    }
    return std::min(layers_, static_cast<std::uint32_t>(at - width_));
  }

  /// Adds a box to a layer. Boxes are added in the order of their lower x. Among the boxes that later ones can
  /// still touch, the layer keeps the widest across x.
  void offer(std::uint32_t layer, const Box& box) {
    if (layer == layers_) {
      ++layers_;
      if (layers_ > width_) widen();
    } else {
      const Box& kept = nodes_[layer + width_].core;
      if (kept.max.x >= box.min.x && width_across_x(kept) > width_across_x(box)) return;
    }
    std::size_t at = layer + width_;
    nodes_[at] = {box, true};
    while ((at /= 2) > 0) nodes_[at] = both(nodes_[2 * at], nodes_[2 * at + 1]);
  }

 private:
  /// core.min: largest lower bounds of the boxes below; core.max: their smallest upper bounds. A box touches
  /// all of them if on every axis its upper bound reaches core.min and its lower bound reaches core.max.
  struct Node {
    Box core;
    bool complete = false;  ///< every layer below has a box
  };
  static bool touches_all(const Node& node, const Box& box) {
    if (!node.complete) return false;
    for (int a = 0; a < 3; ++a)
      if (box.max[a] < node.core.min[a] || box.min[a] > node.core.max[a]) return false;
    return true;
  }
  static Node both(const Node& x, const Node& y) {
    Node node{x.core, x.complete && y.complete};
    for (int a = 0; a < 3; ++a) {
      node.core.min[a] = std::max(x.core.min[a], y.core.min[a]);
      node.core.max[a] = std::min(x.core.max[a], y.core.max[a]);
    }
    return node;
  }
  static double width_across_x(const Box& box) { return box.max.y - box.min.y + (box.max.z - box.min.z); }
  void widen() {
    std::vector<Node> wider(4 * width_);
    std::copy_n(nodes_.begin() + static_cast<std::ptrdiff_t>(width_), width_,
                wider.begin() + static_cast<std::ptrdiff_t>(2 * width_));
    width_ *= 2;
    nodes_ = std::move(wider);
    for (std::size_t at = width_; --at > 0;) nodes_[at] = both(nodes_[2 * at], nodes_[2 * at + 1]);
  }

  std::uint32_t layers_ = 0;
  std::size_t width_ = 1;                    ///< power of two, >= layers_
  std::vector<Node> nodes_{std::size_t{2}};  ///< the root is 1, and the leaf of layer k is k + width_
};

}  // namespace

std::uint32_t assign_layers(std::vector<Part>& parts, const Execution& execution) {
  if (parts.size() == 1) parts[0].layer = 0;
  if (parts.size() <= 1) return static_cast<std::uint32_t>(parts.size());
  std::vector<std::uint32_t> order(parts.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
  sort_with_polls(execution, order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return parts[a].box.min.x != parts[b].box.min.x ? parts[a].box.min.x < parts[b].box.min.x : a < b;
  });
  BoxTree placed(parts, execution);
  LayerTree layers;
  std::vector<std::uint32_t> taken_by;  // per layer: 1 + the last part that found it taken
  Pacer pacer(execution);
  for (const std::uint32_t i : order) {
    const Box& box = parts[i].box;
    std::uint32_t layer = layers.first_untouched(box, 0);
    if (layer < layers.layers()) {
      placed.for_each_touching(box, layer, [&](std::uint32_t j) { taken_by[parts[j].layer] = i + 1; });
      while (layer < layers.layers() && taken_by[layer] == i + 1) {
        pacer.step();
        layer = layers.first_untouched(box, layer + 1);
      }
    }
    parts[i].layer = layer;
    placed.add(i);
    layers.offer(layer, box);
    taken_by.resize(layers.layers(), 0);
    pacer.step(16);
  }
  return layers.layers();
}

}  // namespace fracture::solid_detail
