#include "common/clip/ear_clipping.hpp"

#include <algorithm>
#include <cstdlib>

#include "common/base/id.hpp"
#include "common/base/pacer.hpp"
#include "common/base/scratch.hpp"

namespace fracture {
namespace {

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

/// Minimum number of points at which a ring uses a grid to find points that block an ear.
constexpr std::size_t kLargeRing = 128;

// Halves the ring recursively, which gives triangles of similar size rather than a fan of slivers.
template <class Emit>
void split_evenly(std::size_t first, std::size_t last, const Emit& emit) {
  if (last - first < 2) return;
  const std::size_t middle = first + (last - first) / 2;
  emit(first, middle, last);
  split_evenly(first, middle, emit);
  split_evenly(middle, last, emit);
}

bool in_triangle(const LatticePoint& p, const LatticePoint& a, const LatticePoint& b, const LatticePoint& c) {
  return orient2d(a, b, p) >= 0 && orient2d(b, c, p) >= 0 && orient2d(c, a, p) >= 0;
}

/// Triangulates one ring; keeps its memory between rings, because they are many and small.
class EarClipper {
 public:
  bool run(std::span<const LatticePoint> points, std::span<const std::uint32_t> ring, Triangles& triangles,
           const Execution& execution, std::size_t& patience) {
    Pacer pacer(execution);
    points_ = points;
    ring_ = ring;
    triangles_ = &triangles;
    link();
    std::uint32_t k = 0;
    std::size_t since_cut = 0;
    std::size_t steps = 0;
    const bool large = ring.size() > kLargeRing;
    while (left_ > 3) {
      if (steps > patience) {
        patience = 0;
        split_rest(k, pacer);
        return false;
      }
      const std::size_t before = steps++;
      const bool ear = area(k) > 0 && is_ear(k, steps);
      if (large) pacer.step(steps - before);
      if (ear) {
        cut(k);
        since_cut = 0;
        k = next_[next_[k]];  // skipping one corner spreads the ears around the ring
        continue;
      }
      k = next_[k];
      if (++since_cut < left_) continue;
      // No proper ear: cut the one with the smallest area, which may be flat.
      std::uint32_t best = k;
      steps += left_;
      pacer.step(left_);
      for (std::size_t m = 0; m < left_; ++m, k = next_[k])
        if (std::llabs(area(k)) < std::llabs(area(best))) best = k;
      cut(best);
      since_cut = 0;
      k = next_[best];
    }
    emit(k);
    if (!large) pacer.step(steps);
    patience -= std::min(steps, patience);
    return true;
  }

  std::size_t bytes() const { return bytes_of_vectors(next_, prev_, begin_, end_, content_, rest_); }
  void release() { release_vectors(next_, prev_, begin_, end_, content_, rest_); }

 private:
  void link() {
    const std::size_t n = ring_.size();
    left_ = n;
    next_.resize(n);
    prev_.resize(n);
    for (std::uint32_t k = 0; k < n; ++k) {
      next_[k] = k + 1;
      prev_[k] = k - 1;
    }
    next_[n - 1] = 0;
    prev_[0] = static_cast<std::uint32_t>(n - 1);
    in_grid_ = 0;
    if (n > kLargeRing) fill_grid(0);
  }

  const LatticePoint& at(std::uint32_t k) const { return points_[ring_[k]]; }
  std::int64_t area(std::uint32_t k) const { return orient2d(at(prev_[k]), at(k), at(next_[k])); }

  /// Whether vertex m blocks the ear (a, b, c).
  bool blocks(std::uint32_t m, const LatticePoint& a, const LatticePoint& b, const LatticePoint& c) const {
    const LatticePoint& p = at(m);
    if (p == a || p == b || p == c) return false;  // a point at a corner only touches the ear
    return area(m) <= 0 && in_triangle(p, a, b, c);
  }
  bool is_ear(std::uint32_t k, std::size_t& steps) const {
    const LatticePoint &a = at(prev_[k]), &b = at(k), &c = at(next_[k]);
    if (in_grid_ > 0) return is_ear_by_grid(k, steps);
    for (std::uint32_t m = next_[next_[k]]; m != prev_[k]; m = next_[m]) {
      ++steps;
      if (blocks(m, a, b, c)) return false;
    }
    return true;
  }

  // A ring that crosses itself may pass a point twice. An ear between the two visits uses one edge in both
  // directions, which cancel, so it emits nothing.
  void emit(std::uint32_t k) { emit({ring_[prev_[k]], ring_[k], ring_[next_[k]]}); }
  void emit(const std::array<std::uint32_t, 3>& t) {
    if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) triangles_->push_back(t);
  }
  void cut(std::uint32_t k) {
    emit(k);
    next_[prev_[k]] = next_[k];
    prev_[next_[k]] = prev_[k];
    prev_[k] = kNoIndex;  // marks it as cut
    --left_;
    if (in_grid_ > 0 && 2 * left_ < in_grid_) fill_grid(next_[k]);
  }

  void split_rest(std::uint32_t start, Pacer& pacer) {
    rest_.clear();
    std::uint32_t k = start;
    do {
      rest_.push_back(ring_[k]);
      k = next_[k];
    } while (k != start);
    split_evenly(0, rest_.size() - 1, [&](std::size_t first, std::size_t middle, std::size_t last) {
      pacer.step();
      emit({rest_[first], rest_[middle], rest_[last]});
    });
  }

  // -- the grid of the remaining vertices, and of some cut since it was filled: about one vertex per square

  struct Squares {
    std::int64_t x, y;  // corner of the first square
    int shift = 0;      // side length 2^shift
    std::int64_t columns = 0, rows = 0;
    std::int64_t column(std::int64_t v) const { return (v - x) >> shift; }
    std::int64_t row(std::int64_t v) const { return (v - y) >> shift; }
  };

  void fill_grid(std::uint32_t start) {
    in_grid_ = left_ > kLargeRing / 2 ? left_ : 0;
    if (in_grid_ == 0) return;
    LatticePoint low = at(start), high = low;
    std::uint32_t k = start;
    do {
      const LatticePoint& p = at(k);
      low = {std::min(low.x, p.x), std::min(low.y, p.y)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y)};
      k = next_[k];
    } while (k != start);
    Squares& g = squares_;
    g = {low.x, low.y, 0, 0, 0};
    for (;; ++g.shift) {
      g.columns = g.column(high.x) + 1;
      g.rows = g.row(high.y) + 1;
      if (g.columns * g.rows <= static_cast<std::int64_t>(2 * left_)) break;
    }
    begin_.assign(static_cast<std::size_t>(g.columns * g.rows) + 1, 0);
    const auto square = [&](std::uint32_t m) {
      return static_cast<std::size_t>(g.row(at(m).y) * g.columns + g.column(at(m).x));
    };
    const auto each = [&](const auto& visit) {
      std::uint32_t m = start;
      do {
        visit(m);
        m = next_[m];
      } while (m != start);
    };
    each([&](std::uint32_t m) { ++begin_[square(m) + 1]; });
    for (std::size_t s = 0; s + 1 < begin_.size(); ++s) begin_[s + 1] += begin_[s];
    end_.assign(begin_.begin(), begin_.end() - 1);
    content_.resize(left_);
    each([&](std::uint32_t m) { content_[end_[square(m)]++] = m; });
  }

  bool is_ear_by_grid(std::uint32_t k, std::size_t& steps) const {
    const LatticePoint &a = at(prev_[k]), &b = at(k), &c = at(next_[k]);
    const Squares& g = squares_;
    const auto [x0, x1] = std::minmax({a.x, b.x, c.x});
    const auto [y0, y1] = std::minmax({a.y, b.y, c.y});
    for (std::int64_t row = g.row(y0); row <= g.row(y1); ++row) {
      // The squares of a row are consecutive.
      const auto first = static_cast<std::size_t>(row * g.columns + g.column(x0)),
                 last = static_cast<std::size_t>(row * g.columns + g.column(x1));
      ++steps;
      for (std::uint32_t n = begin_[first]; n < begin_[last + 1]; ++n) {
        const std::uint32_t m = content_[n];
        ++steps;
        if (prev_[m] != kNoIndex && m != k && m != prev_[k] && m != next_[k] && blocks(m, a, b, c))
          return false;
      }
    }
    return true;
  }

  std::span<const LatticePoint> points_;
  std::span<const std::uint32_t> ring_;
  Triangles* triangles_ = nullptr;
  std::vector<std::uint32_t> next_, prev_;
  std::size_t left_ = 0;
  Squares squares_;
  std::size_t in_grid_ = 0;  // number of vertices when the grid was filled; 0: no grid
  std::vector<std::uint32_t> begin_, end_, content_;
  std::vector<std::uint32_t> rest_;
};

}  // namespace

// Does not detect a turn formed by two corners at the same position. triangulate() detects its consequences.
bool is_convex(std::span<const LatticePoint> points, std::span<const std::uint32_t> ring) {
  const std::size_t n = ring.size();
  int turns = 0;  // the x direction changes twice in a convex ring, and four times in a ring that winds twice
  bool strict = false;
  std::int64_t last = 0;
  for (std::size_t i = n - 2, j = n - 1, k = 0; k < n; i = j, j = k++) {
    const LatticePoint &a = points[ring[i]], &b = points[ring[j]], &c = points[ring[k]];
    const std::int64_t o = orient2d(a, b, c);
    if (o < 0) return false;
    strict |= o > 0;
    const std::int64_t dx = b.x - a.x;
    if (dx != 0) {
      if (last != 0 && (dx > 0) != (last > 0)) ++turns;
      last = dx;
    }
  }
  return strict && turns <= 2;
}

bool clip_ears(std::span<const LatticePoint> points, std::span<const std::uint32_t> ring,
               Triangles& triangles, const Execution& execution, std::size_t& patience) {
  const std::size_t n = ring.size();
  if (n < 3) return true;
  if (n == 3) {
    triangles.push_back({ring[0], ring[1], ring[2]});
    return true;
  }
  if (is_convex(points, ring)) {
    Pacer pacer(execution);
    split_evenly(0, n - 1, [&](std::size_t first, std::size_t middle, std::size_t last) {
      pacer.step();
      triangles.push_back({ring[first], ring[middle], ring[last]});
    });
    return true;
  }
  return thread_scratch<EarClipper>().run(points, ring, triangles, execution, patience);
}

}  // namespace fracture
