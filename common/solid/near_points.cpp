#include "common/solid/near_points.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "common/base/pacer.hpp"
#include "common/solid/polled.hpp"

namespace fracture::solid_detail {
namespace {

/// A cell's lower corner in units of its side. The values are integers, stored as double because they may be
/// large.
using CellPlace = std::array<double, 3>;

struct Entry {
  CellPlace cell;
  VertexId vertex;
  friend bool operator<(const Entry& a, const Entry& b) {
    return a.cell != b.cell ? a.cell < b.cell : a.vertex < b.vertex;
  }
};

class NearPoints {
 public:
  NearPoints(const std::vector<Vec3f>& positions, double tolerance, const Execution& execution)
      : positions_(positions), tolerance_(tolerance), execution_(execution), pacer_(execution) {}

  void unite(const std::vector<VertexId>& members, DisjointSets& sets) {
    sort_into_cells(members);
    for (std::uint32_t at = 0; at < cell_count(); ++at)
      for (std::size_t k = begin_[at] + 1; k < begin_[at + 1]; ++k) {
        pacer_.step();
        sets.unite(entries_[begin_[at]].vertex, entries_[k].vertex);
      }
    for (std::uint32_t at = 0; at < cell_count(); ++at)
      for_each_later_neighbour(at, [&](std::uint32_t other) {
        const VertexId a = entries_[begin_[at]].vertex, b = entries_[begin_[other]].vertex;
        if (sets.find(a) != sets.find(b) && have_near_pair(at, other)) sets.unite(a, b);
      });
  }

 private:
  /// Two points in a cell are at most 0.57 √3 = 0.987 tolerances apart. (Rounding does not matter: where
  /// coordinates are so large that it would, neighbouring floats are more than a cell apart.)
  static constexpr double kSide = 0.57;
  static constexpr std::size_t kLeafSize = 8;
  struct Node {
    Vec3f low, high;
  };
  /// A tree over the points of a crowded cell.
  struct Tree {
    std::size_t begin, end;  ///< its points in entries_
    std::size_t root;        ///< its nodes are nodes_[root + 1…]
    std::size_t leaves;      ///< a power of two
  };

  std::size_t cell_count() const { return begin_.size() - 1; }
  const CellPlace& place(std::size_t cell) const { return entries_[begin_[cell]].cell; }

  void sort_into_cells(const std::vector<VertexId>& members) {
    const double inverse = 1 / (kSide * tolerance_);
    const auto along = [inverse](float c) { return std::floor(static_cast<double>(c) * inverse); };
    entries_.reserve(members.size());
    for_each_polled(execution_, members.size(), [&](std::size_t i) {
      const Vec3f& p = positions_[members[i]];
      entries_.push_back({{along(p.x), along(p.y), along(p.z)}, members[i]});
    });
    sort_with_polls(execution_, entries_.begin(), entries_.end());
    for_each_polled(execution_, entries_.size(), [&](std::size_t i) {
      if (i > 0 && entries_[i].cell == entries_[i - 1].cell) return;
      make_room(execution_, begin_);
      begin_.push_back(static_cast<std::uint32_t>(i));
    });
    begin_.push_back(static_cast<std::uint32_t>(entries_.size()));
  }

  /// Calls visit for the cells that come later in the order and may have points within the tolerance: at most
  /// two cells away on each axis.
  template <class Visit>
  void for_each_later_neighbour(std::uint32_t at, Visit&& visit) {
    const CellPlace here = place(at);
    for (int dx = 0; dx <= 2; ++dx)
      for (int dy = dx == 0 ? 0 : -2; dy <= 2; ++dy) {
        const CellPlace low{here[0] + dx, here[1] + dy, here[2] - 2};
        pacer_.step(4);
        const auto first =
            std::partition_point(begin_.begin() + at + 1, begin_.end() - 1,
                                 [&](std::uint32_t begin) { return entries_[begin].cell < low; });
        for (auto i = static_cast<std::uint32_t>(first - begin_.begin());
             i < cell_count() && place(i)[0] == low[0] && place(i)[1] == low[1] && place(i)[2] <= here[2] + 2;
             ++i)
          visit(i);
      }
  }

  const Vec3f& point(std::size_t k) const { return positions_[entries_[k].vertex]; }
  bool near(std::size_t a, std::size_t b) const {
    return length(to_double(point(a)) - to_double(point(b))) <= tolerance_;
  }
  bool any_near(std::size_t a, std::size_t a_end, std::size_t b, std::size_t b_end) {
    pacer_.step((a_end - a) * (b_end - b));
    for (; a < a_end; ++a)
      for (std::size_t k = b; k < b_end; ++k)
        if (near(a, k)) return true;
    return false;
  }

  bool have_near_pair(std::uint32_t cell_a, std::uint32_t cell_b) {
    const std::size_t size_a = begin_[cell_a + 1] - begin_[cell_a],
                      size_b = begin_[cell_b + 1] - begin_[cell_b];
    if (size_a * size_b <= 256)
      return any_near(begin_[cell_a], begin_[cell_a + 1], begin_[cell_b], begin_[cell_b + 1]);
    const Tree a = tree_of(cell_a), b = tree_of(cell_b);
    struct Pair {
      std::size_t a, b;  // nodes, numbered from 1 in each tree
    };
    std::vector<Pair> stack{{1, 1}};
    while (!stack.empty()) {
      const auto [i, j] = stack.back();
      stack.pop_back();
      pacer_.step();
      const Node &x = nodes_[a.root + i], &y = nodes_[b.root + j];
      const auto [least, most] = distances(x, y);
      if (least > tolerance_ * (1 + 1e-12)) continue;
      if (most < tolerance_ * (1 - 1e-12)) return true;
      const bool leaf_a = i >= a.leaves, leaf_b = j >= b.leaves;
      if (leaf_a && leaf_b) {
        if (any_near(leaf_begin(a, i), leaf_begin(a, i + 1), leaf_begin(b, j), leaf_begin(b, j + 1)))
          return true;
      } else if (leaf_b || (!leaf_a && extent(x) > extent(y))) {
        stack.push_back({2 * i, j});
        stack.push_back({2 * i + 1, j});
      } else {
        stack.push_back({i, 2 * j});
        stack.push_back({i, 2 * j + 1});
      }
    }
    return false;
  }

  /// Lower and upper bounds of the distance between points of the two boxes.
  static std::pair<double, double> distances(const Node& x, const Node& y) {
    Vec3d least, most;
    const auto axis = [](double x0, double x1, double y0, double y1, double& near, double& far) {
      near = std::fmax(0, std::fmax(y0 - x1, x0 - y1));
      far = std::fmax(y1 - x0, x1 - y0);
    };
    axis(x.low.x, x.high.x, y.low.x, y.high.x, least.x, most.x);
    axis(x.low.y, x.high.y, y.low.y, y.high.y, least.y, most.y);
    axis(x.low.z, x.high.z, y.low.z, y.high.z, least.z, most.z);
    return {length(least), length(most)};
  }
  static double extent(const Node& node) {
    const Vec3d size = to_double(node.high) - to_double(node.low);
    return std::fmax(size.x, std::fmax(size.y, size.z));
  }

  /// First point of leaf k (k >= `leaves`) of the tree: the points are halved recursively.
  static std::size_t leaf_begin(const Tree& tree, std::size_t k) {
    std::size_t begin = tree.begin, end = tree.end;
    if (k == 2 * tree.leaves) return end;
    for (std::size_t bit = tree.leaves / 2; bit > 0; bit /= 2) {
      const std::size_t middle = begin + (end - begin) / 2;
      (k & bit ? begin : end) = middle;
    }
    return begin;
  }

  const Tree& tree_of(std::uint32_t cell) {
    const auto [at, fresh] = trees_.try_emplace(cell);
    Tree& tree = at->second;
    if (!fresh) return tree;
    tree = {begin_[cell], begin_[cell + 1], nodes_.size(), 1};
    while (tree.leaves * kLeafSize < tree.end - tree.begin) tree.leaves *= 2;
    make_room(execution_, nodes_, 2 * tree.leaves);
    nodes_.resize(nodes_.size() + 2 * tree.leaves);
    split(tree, 1, tree.begin, tree.end);
    return tree;
  }
  void split(const Tree& tree, std::size_t at, std::size_t begin, std::size_t end) {
    Node node{point(begin), point(begin)};
    for (std::size_t k = begin; k < end; ++k) {
      pacer_.step();
      const Vec3f& p = point(k);
      node.low = {std::min(node.low.x, p.x), std::min(node.low.y, p.y), std::min(node.low.z, p.z)};
      node.high = {std::max(node.high.x, p.x), std::max(node.high.y, p.y), std::max(node.high.z, p.z)};
    }
    nodes_[tree.root + at] = node;
    if (at >= tree.leaves) return;
    const Vec3d size = to_double(node.high) - to_double(node.low);
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const std::size_t middle = begin + (end - begin) / 2;
    const auto entry = [this](std::size_t k) { return entries_.begin() + static_cast<std::ptrdiff_t>(k); };
    std::nth_element(entry(begin), entry(middle), entry(end), [&](const Entry& v, const Entry& w) {
      pacer_.step();
      return to_double(positions_[v.vertex])[axis] < to_double(positions_[w.vertex])[axis];
    });
    split(tree, 2 * at, begin, middle);
    split(tree, 2 * at + 1, middle, end);
  }

  const std::vector<Vec3f>& positions_;
  const double tolerance_;
  const Execution& execution_;
  Pacer pacer_;
  std::vector<Entry> entries_;           ///< ascending by cell
  std::vector<std::uint32_t> begin_;     ///< per cell: its first entry; one more at the end
  std::map<std::uint32_t, Tree> trees_;  ///< only for cells that needed one
  std::vector<Node> nodes_;  ///< in each tree, the root is 1, the children of k are 2 k and 2 k + 1
};

}  // namespace

void unite_near(const std::vector<Vec3f>& positions, const std::vector<VertexId>& members, double tolerance,
                DisjointSets& sets, const Execution& execution) {
  // Different floats are farther apart than this.
  if (!(tolerance > 1e-45)) return;
  NearPoints(positions, tolerance, execution).unite(members, sets);
}

}  // namespace fracture::solid_detail
