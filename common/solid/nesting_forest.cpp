#include "common/solid/nesting_forest.hpp"

#include <algorithm>
#include <cmath>

#include "common/base/pacer.hpp"
#include "common/solid/float_predicates.hpp"
#include "common/solid/polled.hpp"

namespace fracture::solid_detail {
namespace {

using Corners = std::array<Vec3f, 3>;

/// Whether the edge pq may meet the triangle abc, including its boundary. False only if they certainly do not
/// meet.
bool may_meet(const Vec3f& p, const Vec3f& q, const Corners& t) {
  if (sign_orient3d(t[0], t[1], t[2], p) * sign_orient3d(t[0], t[1], t[2], q) > 0) return false;
  const int ab = sign_orient3d(p, q, t[0], t[1]), bc = sign_orient3d(p, q, t[1], t[2]),
            ca = sign_orient3d(p, q, t[2], t[0]);
  return !(std::max({ab, bc, ca}) > 0 && std::min({ab, bc, ca}) < 0);
}

/// Whether all corners of b lie strictly on one side of the plane of a.
bool one_side(const Corners& a, const Corners& b) {
  const int first = sign_orient3d(a[0], a[1], a[2], b[0]);
  return first != 0 && sign_orient3d(a[0], a[1], a[2], b[1]) == first &&
         sign_orient3d(a[0], a[1], a[2], b[2]) == first;
}

/// Whether two triangles certainly have no point in common. If they had one, an edge of one would meet the
/// other.
bool are_apart(const Corners& a, const Corners& b) {
  if (one_side(a, b) || one_side(b, a)) return true;
  for (int k = 0; k < 3; ++k)
    if (may_meet(a[k], a[(k + 1) % 3], b) || may_meet(b[k], b[(k + 1) % 3], a)) return false;
  return true;
}

/// A bounding volume hierarchy over the triangles of shells that are not flat, divided at medians.
class TriangleBoxes {
 public:
  TriangleBoxes(const Surface& surface, const Shells& shells, const Execution& execution)
      : surface_(surface), shells_(shells), pacer_(execution) {
    for_each_polled(execution, surface.triangles.size(), [&](std::size_t t) {
      if (shells.list[shells.of_triangle[t]].flat) return;
      make_room(execution, items_);
      items_.push_back(TriangleId{t});
    });
    std::size_t leaves = 1;
    while (leaves * kLeafSize < items_.size()) leaves *= 2;
    first_leaf_ = leaves - 1;
    nodes_ = filled(execution, 2 * leaves - 1, Node{});
    split(0, 0, items_.size());
  }

  /// Whether all triangles of different shells are apart. Also false if too many of their boxes overlap to
  /// test them.
  bool shells_are_apart() {
    struct Pair {
      std::size_t a, b;
    };
    std::uint64_t left = kPairsPerTriangle * (items_.size() + 64);
    std::vector<Pair> stack{{0, 0}};
    while (!stack.empty()) {
      const auto [a, b] = stack.back();
      stack.pop_back();
      pacer_.step();
      if (left-- == 0) return false;
      if (a != b && !nodes_[a].box.intersects(nodes_[b].box)) continue;
      const bool leaf_a = a >= first_leaf_, leaf_b = b >= first_leaf_;
      if (leaf_a && leaf_b) {
        if (!leaves_are_apart(nodes_[a], nodes_[b], left)) return false;
      } else if (a == b) {
        stack.insert(stack.end(), {{2 * a + 1, 2 * a + 1}, {2 * a + 2, 2 * a + 2}, {2 * a + 1, 2 * a + 2}});
      } else if (leaf_b || (!leaf_a && nodes_[a].box.longest_side() > nodes_[b].box.longest_side())) {
        stack.insert(stack.end(), {{2 * a + 1, b}, {2 * a + 2, b}});
      } else {
        stack.insert(stack.end(), {{a, 2 * b + 1}, {a, 2 * b + 2}});
      }
    }
    return true;
  }

  /// Returns the shell, other than `self`, that the ray along +x from p meets first; kNoIndex if there is
  /// none. Returns nullopt if rounding hides which of two is nearer.
  std::optional<std::uint32_t> first_hit(const Vec3f& p, std::uint32_t self) {
    const Vec3d q = to_double(p);
    hits_.clear();
    double nearest = HUGE_VAL;  // the ray has met something at or before this x
    std::vector<std::size_t>& stack = stack_;
    stack.assign(1, 0);
    while (!stack.empty()) {
      const std::size_t at = stack.back();
      stack.pop_back();
      pacer_.step();
      const Box& box = nodes_[at].box;
      if (q.y < box.min.y || q.y > box.max.y || q.z < box.min.z || q.z > box.max.z || q.x > box.max.x ||
          box.min.x > nearest)
        continue;
      if (at < first_leaf_) {  // visit the nearer child first
        const std::size_t left = 2 * at + 1, right = 2 * at + 2;
        const bool left_first = nodes_[left].box.min.x <= nodes_[right].box.min.x;
        stack.push_back(left_first ? right : left);
        stack.push_back(left_first ? left : right);
        continue;
      }
      for (std::size_t i = nodes_[at].begin; i < nodes_[at].end; ++i) {
        pacer_.step();
        const std::uint32_t shell = shells_.of_triangle[items_[i]];
        bool clear = true;
        if (shell == self || ray_crossing(p, corners(items_[i]), clear) == 0) continue;
        const Hit hit = place_of_hit(q, items_[i], shell);
        nearest = std::min(nearest, hit.high);
        if (hit.low <= nearest) hits_.push_back(hit);
      }
    }
    std::uint32_t first = kNoIndex;
    for (const Hit& hit : hits_) {
      if (hit.low > nearest) continue;
      if (first != kNoIndex && first != hit.shell) return std::nullopt;
      first = hit.shell;
    }
    return first;
  }

 private:
  static constexpr std::size_t kLeafSize = 4;
  static constexpr std::uint64_t kPairsPerTriangle = 256;
  struct Node {
    Box box;
    std::size_t begin = 0, end = 0;  ///< items of a leaf
  };
  /// The ray meets the shell somewhere between these x.
  struct Hit {
    double low, high;
    std::uint32_t shell;
  };

  Corners corners(TriangleId t) const {
    const Triangle& v = surface_.triangles[t];
    return {surface_.positions[v[0]], surface_.positions[v[1]], surface_.positions[v[2]]};
  }
  Box box_of(TriangleId t) const {
    Box box;
    for (const Vec3f& p : corners(t)) box.add(to_double(p));
    return box;
  }

  void split(std::size_t at, std::size_t begin, std::size_t end) {
    Node& node = nodes_[at];
    Box centers;
    for (std::size_t i = begin; i < end; ++i) {
      pacer_.step();
      const Box box = box_of(items_[i]);
      node.box.add(box);
      centers.add(box.center());
    }
    if (at >= first_leaf_) {
      node.begin = begin;
      node.end = end;
      return;
    }
    const Vec3d spread = centers.size();
    const int axis = spread.x >= spread.y && spread.x >= spread.z ? 0 : spread.y >= spread.z ? 1 : 2;
    const std::size_t middle = begin + (end - begin) / 2;
    const auto item = [this](std::size_t i) { return items_.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(item(begin), item(middle), item(end), [&](TriangleId s, TriangleId t) {
      pacer_.step();
      return box_of(s).center()[axis] < box_of(t).center()[axis];
    });
    split(2 * at + 1, begin, middle);
    split(2 * at + 2, middle, end);
  }

  bool leaves_are_apart(const Node& a, const Node& b, std::uint64_t& left) {
    for (std::size_t i = a.begin; i < a.end; ++i)
      for (std::size_t k = &a == &b ? i + 1 : b.begin; k < b.end; ++k) {
        pacer_.step();
        if (shells_.of_triangle[items_[i]] == shells_.of_triangle[items_[k]]) continue;
        if (!box_of(items_[i]).intersects(box_of(items_[k]))) continue;
        pacer_.step(8);
        if (left-- == 0 || !are_apart(corners(items_[i]), corners(items_[k]))) return false;
      }
    return true;
  }

  /// The range of x in which the line along x through q meets the plane of the triangle, including rounding
  /// errors.
  Hit place_of_hit(const Vec3d& q, TriangleId t, std::uint32_t shell) const {
    const Box box = box_of(t);
    const Corners c = corners(t);
    const Vec3d a = to_double(c[0]), n = cross(to_double(c[1]) - a, to_double(c[2]) - a);
    // The error of n is less than 8 · 2^-53 · size². If that may exceed a thousandth of n.x, use the box
    // instead.
    const double size = box.longest_side(), error = 1e-15 * size * size;
    Hit hit{std::max(box.min.x, q.x), box.max.x, shell};
    if (std::fabs(n.x) <= 1e3 * error) return hit;
    const double slope = (std::fabs(n.y) + std::fabs(n.z)) / std::fabs(n.x);
    const double x = a.x - (n.y * (q.y - a.y) + n.z * (q.z - a.z)) / n.x;
    const double off = 4 * size * (1 + slope) * error / std::fabs(n.x) + 1e-15 * (std::fabs(a.x) + size);
    hit.low = std::max(hit.low, x - off);
    hit.high = std::min(hit.high, x + off);
    return hit;
  }

  const Surface& surface_;
  const Shells& shells_;
  Pacer pacer_;
  std::vector<TriangleId> items_;
  std::size_t first_leaf_ = 0;
  std::vector<Node> nodes_;  ///< complete binary tree: the children of k are 2 k + 1 and 2 k + 2
  std::vector<Hit> hits_;
  std::vector<std::size_t> stack_;
};

/// Per shell: a vertex with the largest x.
std::vector<VertexId> furthest_vertices(const Surface& surface, const Shells& shells,
                                        const Execution& execution) {
  std::vector<VertexId> furthest = filled(execution, shells.list.size(), kNoVertex);
  for_each_polled(execution, surface.triangles.size(), [&](std::size_t t) {
    VertexId& best = furthest[shells.of_triangle[t]];
    for (const VertexId v : surface.triangles[t])
      if (best == kNoVertex || surface.positions[v].x > surface.positions[best].x) best = v;
  });
  return furthest;
}

}  // namespace

std::optional<NestingForest> find_nesting_forest(const Surface& surface, const Shells& shells,
                                                 WindingNumbers& windings, const Execution& execution) {
  TriangleBoxes boxes(surface, shells, execution);
  if (!boxes.shells_are_apart()) return std::nullopt;
  const std::vector<VertexId> furthest = furthest_vertices(surface, shells, execution);
  std::vector<std::uint32_t> order;
  for (std::uint32_t s = 0; s < shells.list.size(); ++s)
    if (!shells.list[s].flat) order.push_back(s);
  sort_with_polls(execution, order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    const float x = surface.positions[furthest[a]].x, y = surface.positions[furthest[b]].x;
    return x != y ? x > y : a < b;
  });
  NestingForest forest{filled(execution, shells.list.size(), kNoIndex),
                       filled(execution, shells.list.size(), 0)};
  for (const std::uint32_t s : order) {
    const Vec3f& p = surface.positions[furthest[s]];
    const std::optional<std::uint32_t> hit = boxes.first_hit(p, s);
    if (!hit) return std::nullopt;
    if (*hit == kNoIndex) continue;
    const int number = windings.number(*hit, p);
    forest.up[s] = number != 0 ? *hit : forest.up[*hit];
    forest.number[s] = number != 0 ? number : forest.number[*hit];
  }
  return forest;
}

}  // namespace fracture::solid_detail
