#include "common/clip/monotone_partition.hpp"

#include <algorithm>
#include <cstdlib>
#include <numeric>
#include <set>
#include <tuple>

#include "common/base/id.hpp"
#include "common/base/pacer.hpp"

namespace fracture {
namespace {

class Sweep {
 public:
  Sweep(std::span<const LatticePoint> points, std::span<const std::uint32_t> loop_begin,
        const Execution& execution)
      : points_(points), loop_begin_(loop_begin), pacer_(execution), status_(LeftOf{this}) {
    const std::size_t n = points.size();
    point_.resize(n);
    std::iota(point_.begin(), point_.end(), 0u);
    next_.resize(n);
    prev_.resize(n);
    loop_.resize(n);
    for (std::uint32_t l = 0; l + 1 < loop_begin.size(); ++l)
      for (std::uint32_t k = loop_begin[l]; k < loop_begin[l + 1]; ++k) {
        next_[k] = k + 1 < loop_begin[l + 1] ? k + 1 : loop_begin[l];
        prev_[k] = k > loop_begin[l] ? k - 1 : loop_begin[l + 1] - 1;
        loop_[k] = l;
      }
    ring_next_ = next_;
    ring_prev_ = prev_;
    copies_.resize(n);
    rank_.resize(n);
    std::vector<std::uint32_t>& order = order_;
    order = point_;
    sort_with_polls(execution, order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
      return std::tie(points[a].y, points[a].x, a) < std::tie(points[b].y, points[b].x, b);
    });
    for (std::uint32_t k = 0; k < n; ++k) rank_[order[k]] = k;
    helper_.assign(n, kNoIndex);
    position_.assign(n, status_.end());
    merge_.assign(n, false);
    joined_.resize(loop_begin.size() - 1);
    std::iota(joined_.begin(), joined_.end(), 0u);
  }

  void run() {
    for (const std::uint32_t v : order_) {
      visit(v);
      pacer_.step(8);
    }
  }

  void collect(Partition& out) {
    out = {};
    out.crossings = crossings_;
    out.ring_begin.push_back(0);
    std::vector<bool> done(point_.size(), false);
    for (std::uint32_t c = 0; c < point_.size(); ++c) {
      if (done[c]) continue;
      for (std::uint32_t k = c; !done[k]; k = ring_next_[k]) {
        done[k] = true;
        out.ring_points.push_back(point_[k]);
        pacer_.step();
      }
      out.ring_begin.push_back(static_cast<std::uint32_t>(out.ring_points.size()));
      out.ring_loop.push_back(find(loop_[point_[c]]));
    }
    // A clockwise loop that was joined to no other loop, unless rounding alone may have reversed it. Vertices
    // move by half a step, which changes twice the area by at most about the perimeter.
    std::vector<std::uint32_t> members(joined_.size(), 0);
    for (std::uint32_t l = 0; l < joined_.size(); ++l) ++members[find(l)];
    for (std::uint32_t l = 0; l < joined_.size(); ++l)
      if (members[find(l)] == 1 && twice_area(l) < -perimeter(l)) out.unnested.push_back(l);
  }

 private:
  // An edge of the status goes from corner e down to next_[e]; the interior is to its right.
  struct LeftOf {
    using is_transparent = void;
    const Sweep* sweep;
    bool operator()(std::uint32_t e, std::uint32_t f) const { return sweep->edge_left_of(e, f); }
    struct Query {
      std::uint32_t corner;
    };
    bool operator()(std::uint32_t e, Query q) const { return !sweep->strictly_left_of_edge(q.corner, e); }
    bool operator()(Query q, std::uint32_t e) const { return sweep->strictly_left_of_edge(q.corner, e); }
  };
  using Status = std::set<std::uint32_t, LeftOf>;

  const LatticePoint& at(std::uint32_t k) const { return points_[k]; }
  bool earlier(std::uint32_t a, std::uint32_t b) const { return rank_[a] < rank_[b]; }

  /// Whether corner v is strictly to the left of edge e = (upper e, lower next_[e]).
  bool strictly_left_of_edge(std::uint32_t v, std::uint32_t e) const {
    return orient2d(at(next_[e]), at(e), at(v)) > 0;
  }
  bool edge_left_of(std::uint32_t e, std::uint32_t f) const {
    if (e == f) return false;
    const std::uint32_t e_low = next_[e], f_low = next_[f];
    // Compare at the later of the two lower ends; if they touch there, at an upper end.
    if (earlier(f_low, e_low)) {
      if (const std::int64_t o = orient2d(at(f_low), at(f), at(e_low))) return o > 0;
    } else {
      if (const std::int64_t o = orient2d(at(e_low), at(e), at(f_low))) return o < 0;
    }
    if (const std::int64_t o =
            earlier(e, f) ? orient2d(at(f_low), at(f), at(e)) : -orient2d(at(e_low), at(e), at(f)))
      return o > 0;
    return e < f;
  }

  void insert(std::uint32_t edge, std::uint32_t helper) {
    const auto [where, fresh] = status_.insert(edge);
    if (fresh) position_[edge] = where;
    helper_[edge] = helper;
    if (!counts_crossings_) return;
    if (where != status_.begin()) count_crossing(*std::prev(where), edge);
    if (std::next(where) != status_.end()) count_crossing(edge, *std::next(where));
  }
  void erase(std::uint32_t edge) {
    if (position_[edge] == status_.end()) return;
    const auto after = status_.erase(position_[edge]);
    position_[edge] = status_.end();
    if (counts_crossings_ && after != status_.begin() && after != status_.end())
      count_crossing(*std::prev(after), *after);
  }
  /// Counts a crossing if each end is farther from the other edge than rounding explains, which moves
  /// vertices by half a step.
  void count_crossing(std::uint32_t e, std::uint32_t f) {
    const auto divides = [&](std::uint32_t by, std::uint32_t other) {
      const LatticePoint &p = at(by), &q = at(next_[by]);
      const std::int64_t least = 4 * (std::abs(q.x - p.x) + std::abs(q.y - p.y));
      const std::int64_t a = orient2d(p, q, at(other)), b = orient2d(p, q, at(next_[other]));
      return (a > least && b < -least) || (a < -least && b > least);
    };
    crossings_ += divides(e, f) && divides(f, e);
  }
  std::uint32_t edge_left_of_point(std::uint32_t v) const {
    auto it = status_.upper_bound(LeftOf::Query{v});
    while (it != status_.begin()) {
      --it;
      // Skip edges that end in v itself.
      if (*it != v && next_[*it] != v) return *it;
    }
    return kNoIndex;
  }

  void close_helper(std::uint32_t v, std::uint32_t edge) {
    const std::uint32_t h = helper_[edge];
    if (h != kNoIndex && merge_[h]) add_diagonal(v, h);
  }

  //   start     split     regular     regular     end       merge
  //   \   /    ##\ /##    (left)      (right)     /#\      ##/ \##
  //    \#/     ###v###      \##        ##/       / # \     #/ v \#   v is the vertex, # the interior
  //     v                    v###    ###v          v
  //                         /##        ##\                            the sweep goes upwards
  void visit(std::uint32_t v) {
    const std::uint32_t p = prev_[v], n = next_[v];
    if (p == n) return;  // a loop of two points
    const bool p_later = earlier(v, p), n_later = earlier(v, n);
    const bool convex = orient2d(at(p), at(v), at(n)) > 0;
    if (p_later && n_later) {
      if (!convex) {
        const std::uint32_t left = edge_left_of_point(v);
        if (left != kNoIndex) {
          add_diagonal(v, helper_[left]);
          helper_[left] = v;
        }
      }
      insert(p, v);
    } else if (!p_later && !n_later) {
      close_helper(v, v);
      erase(v);
      if (!convex) {
        merge_[v] = true;
        const std::uint32_t left = edge_left_of_point(v);
        if (left != kNoIndex) {
          close_helper(v, left);
          helper_[left] = v;
        }
      }
    } else if (p_later) {  // going down: left boundary
      close_helper(v, v);
      erase(v);
      insert(p, v);
    } else {  // going up: right boundary
      const std::uint32_t left = edge_left_of_point(v);
      if (left != kNoIndex) {
        close_helper(v, left);
        helper_[left] = v;
      }
    }
  }

  /// The copy of corner v whose wedge contains the direction to q. Most corners have only one copy.
  std::uint32_t copy_towards(std::uint32_t v, std::uint32_t q) const {
    if (copies_[v].empty() || wedge_contains(v, q)) return v;
    for (const std::uint32_t c : copies_[v])
      if (wedge_contains(c, q)) return c;
    return v;
  }
  bool wedge_contains(std::uint32_t c, std::uint32_t q) const {
    const LatticePoint &p = at(point_[ring_prev_[c]]), &v = at(point_[c]), &n = at(point_[ring_next_[c]]),
                       &t = at(q);
    const bool left_of_out = orient2d(v, n, t) > 0, left_of_in = orient2d(p, v, t) > 0;
    return orient2d(p, v, n) > 0 ? left_of_out && left_of_in : left_of_out || left_of_in;
  }

  void add_diagonal(std::uint32_t v, std::uint32_t h) {
    if (h == kNoIndex || v == h) return;
    const std::uint32_t a = copy_towards(v, h), b = copy_towards(h, v);
    if (ring_next_[a] == b || ring_next_[b] == a) return;  // already an edge
    joined_[find(loop_[v])] = find(loop_[h]);
    const auto a2 = static_cast<std::uint32_t>(point_.size()), b2 = a2 + 1;
    point_.insert(point_.end(), {point_[a], point_[b]});
    ring_next_.resize(b2 + 1);
    ring_prev_.resize(b2 + 1);
    const std::uint32_t a_next = ring_next_[a], b_prev = ring_prev_[b];
    const auto link = [&](std::uint32_t from, std::uint32_t to) {
      ring_next_[from] = to;
      ring_prev_[to] = from;
    };
    link(a, b);
    link(b2, a2);
    link(a2, a_next);
    link(b_prev, b2);
    copies_[v].push_back(a2);
    copies_[h].push_back(b2);
  }

  std::uint32_t find(std::uint32_t l) {
    while (joined_[l] != l) l = joined_[l] = joined_[joined_[l]];
    return l;
  }
  __int128 twice_area(std::uint32_t l) const {
    __int128 sum = 0;
    const LatticePoint& o = at(loop_begin_[l]);
    for (std::uint32_t k = loop_begin_[l] + 1; k + 1 < loop_begin_[l + 1]; ++k)
      sum += orient2d(o, at(k), at(k + 1));
    return sum;
  }
  /// Perimeter in the 1-norm, an upper bound.
  __int128 perimeter(std::uint32_t l) const {
    __int128 sum = 0;
    for (std::uint32_t k = loop_begin_[l]; k < loop_begin_[l + 1]; ++k)
      sum += std::abs(at(next_[k]).x - at(k).x) + std::abs(at(next_[k]).y - at(k).y);
    return sum;
  }

  std::span<const LatticePoint> points_;
  std::span<const std::uint32_t> loop_begin_;
  Pacer pacer_;
  const bool counts_crossings_ = points_.size() >= Partition::kManyPoints;
  std::uint32_t crossings_ = 0;
  std::vector<std::uint32_t> next_, prev_;  // the input loops
  std::vector<std::uint32_t> loop_;
  std::vector<std::uint32_t> order_, rank_;  // sweep order
  // Corners: first the input's, then the copies that diagonals create. A corner is a position in a ring.
  std::vector<std::uint32_t> point_, ring_next_, ring_prev_;
  std::vector<std::vector<std::uint32_t>> copies_;
  std::vector<std::uint32_t> helper_;  // for each edge in the status
  std::vector<bool> merge_;
  std::vector<std::uint32_t> joined_;
  Status status_;
  std::vector<Status::iterator> position_;
};

}  // namespace

void partition_monotone(std::span<const LatticePoint> points, std::span<const std::uint32_t> loop_begin,
                        Partition& out, const Execution& execution) {
  Sweep sweep(points, loop_begin, execution);
  sweep.run();
  sweep.collect(out);
}

}  // namespace fracture
