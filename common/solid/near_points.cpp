#include "common/solid/near_points.hpp"

#include <algorithm>
#include <cmath>

#include "common/base/pacer.hpp"
#include "common/solid/polled.hpp"

namespace fracture::solid_detail {
namespace {

/// A cell's lower corner in units of its side: whole numbers, in double because they may be large.
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
    for (const Cell& cell : cells_)
      for (std::size_t k = cell.begin + 1; k < cell.end; ++k) {
        pacer_.step();
        sets.unite(vertices_[cell.begin], vertices_[k]);
      }
    for (std::uint32_t at = 0; at < cells_.size(); ++at)
      for_each_later_neighbour(at, [&](std::uint32_t other) {
        const VertexId a = vertices_[cells_[at].begin], b = vertices_[cells_[other].begin];
        if (sets.find(a) != sets.find(b) && have_near_pair(cells_[at], cells_[other])) sets.unite(a, b);
      });
  }

 private:
  /// Two points of a cell differ by at most 0.57 √3 = 0.987 tolerances. (Rounding does not matter: where it
  /// would, floats are more than a cell apart.)
  static constexpr double kSide = 0.57;
  static constexpr std::size_t kLeafSize = 8;
  struct Node {
    Vec3f low, high;
  };
  struct Cell {
    CellPlace place;
    std::size_t begin, end;      ///< its points in vertices_
    std::size_t tree = kNoTree;  ///< the root in nodes_, once somebody asked
    std::size_t leaves = 0;      ///< a power of two
  };
  static constexpr std::size_t kNoTree = ~std::size_t{0};

  void sort_into_cells(const std::vector<VertexId>& members) {
    const double inverse = 1 / (kSide * tolerance_);
    const auto place = [inverse](float c) { return std::floor(static_cast<double>(c) * inverse); };
    std::vector<Entry> entries;
    entries.reserve(members.size());
    for_each_polled(execution_, members.size(), [&](std::size_t i) {
      const Vec3f& p = positions_[members[i]];
      entries.push_back({{place(p.x), place(p.y), place(p.z)}, members[i]});
    });
    sort_with_polls(execution_, entries.begin(), entries.end());
    vertices_.reserve(entries.size());
    for_each_polled(execution_, entries.size(), [&](std::size_t i) {
      if (i == 0 || entries[i].cell != entries[i - 1].cell) cells_.push_back({entries[i].cell, i, i});
      cells_.back().end = i + 1;
      vertices_.push_back(entries[i].vertex);
    });
  }

  /// Calls visit for the cells that come later in the order and may have points within the tolerance: two
  /// cells away at most on each axis.
  template <class Visit>
  void for_each_later_neighbour(std::uint32_t at, Visit&& visit) {
    const CellPlace place = cells_[at].place;
    for (int dx = 0; dx <= 2; ++dx)
      for (int dy = dx == 0 ? 0 : -2; dy <= 2; ++dy) {
        const CellPlace low{place[0] + dx, place[1] + dy, place[2] - 2};
        auto i = std::lower_bound(cells_.begin() + at + 1, cells_.end(), low,
                                  [](const Cell& cell, const CellPlace& p) { return cell.place < p; });
        pacer_.step(4);
        for (; i != cells_.end() && i->place[0] == low[0] && i->place[1] == low[1] &&
               i->place[2] <= place[2] + 2;
             ++i)
          visit(static_cast<std::uint32_t>(i - cells_.begin()));
      }
  }

  const Vec3f& point(std::size_t k) const { return positions_[vertices_[k]]; }
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

  bool have_near_pair(Cell& a, Cell& b) {
    if ((a.end - a.begin) * (b.end - b.begin) <= 256) return any_near(a.begin, a.end, b.begin, b.end);
    plant(a);
    plant(b);
    struct Pair {
      std::size_t a, b;  // nodes, numbered from 1 in each tree
    };
    std::vector<Pair> stack{{1, 1}};
    while (!stack.empty()) {
      const auto [i, j] = stack.back();
      stack.pop_back();
      pacer_.step();
      const Node &x = nodes_[a.tree + i], &y = nodes_[b.tree + j];
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

  /// Of any two points of the boxes, at least and at most.
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

  /// Leaf k (from `leaves` on) of the cell's tree begins here: the points are halved and halved again.
  static std::size_t leaf_begin(const Cell& cell, std::size_t k) {
    std::size_t begin = cell.begin, end = cell.end;
    if (k == 2 * cell.leaves) return end;
    for (std::size_t bit = cell.leaves / 2; bit > 0; bit /= 2) {
      const std::size_t middle = begin + (end - begin) / 2;
      (k & bit ? begin : end) = middle;
    }
    return begin;
  }

  void plant(Cell& cell) {
    if (cell.tree != kNoTree) return;
    cell.leaves = 1;
    while (cell.leaves * kLeafSize < cell.end - cell.begin) cell.leaves *= 2;
    cell.tree = nodes_.size();
    nodes_.resize(nodes_.size() + 2 * cell.leaves);
    split(cell, 1, cell.begin, cell.end);
  }
  void split(const Cell& cell, std::size_t at, std::size_t begin, std::size_t end) {
    Node node{point(begin), point(begin)};
    for (std::size_t k = begin; k < end; ++k) {
      pacer_.step();
      const Vec3f& p = point(k);
      node.low = {std::min(node.low.x, p.x), std::min(node.low.y, p.y), std::min(node.low.z, p.z)};
      node.high = {std::max(node.high.x, p.x), std::max(node.high.y, p.y), std::max(node.high.z, p.z)};
    }
    nodes_[cell.tree + at] = node;
    if (at >= cell.leaves) return;
    const Vec3d size = to_double(node.high) - to_double(node.low);
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const std::size_t middle = begin + (end - begin) / 2;
    const auto vertex = [this](std::size_t k) { return vertices_.begin() + static_cast<std::ptrdiff_t>(k); };
    std::nth_element(vertex(begin), vertex(middle), vertex(end), [&](VertexId v, VertexId w) {
      pacer_.step();
      return to_double(positions_[v])[axis] < to_double(positions_[w])[axis];
    });
    split(cell, 2 * at, begin, middle);
    split(cell, 2 * at + 1, middle, end);
  }

  const std::vector<Vec3f>& positions_;
  const double tolerance_;
  const Execution& execution_;
  Pacer pacer_;
  std::vector<Cell> cells_;         ///< ascending by place
  std::vector<VertexId> vertices_;  ///< cell by cell
  std::vector<Node> nodes_;         ///< of each tree: root 1, the children of k are 2 k and 2 k + 1
};

}  // namespace

void unite_near(const std::vector<Vec3f>& positions, const std::vector<VertexId>& members, double tolerance,
                DisjointSets& sets, const Execution& execution) {
  // Different floats are further apart than this.
  if (!(tolerance > 1e-45)) return;
  NearPoints(positions, tolerance, execution).unite(members, sets);
}

}  // namespace fracture::solid_detail
