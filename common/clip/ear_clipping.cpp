#include "common/clip/ear_clipping.hpp"

#include <cstdlib>

namespace fracture {
namespace {

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

// Halves the ring again and again: triangles of even size rather than a fan of slivers.
void split_convex(std::span<const std::uint32_t> ring, std::size_t first, std::size_t last,
                  Triangles& triangles) {
  if (last - first < 2) return;
  const std::size_t middle = first + (last - first) / 2;
  triangles.push_back({ring[first], ring[middle], ring[last]});
  split_convex(ring, first, middle, triangles);
  split_convex(ring, middle, last, triangles);
}

void link_ring(std::size_t n, std::vector<std::uint32_t>& next, std::vector<std::uint32_t>& prev) {
  next.resize(n);
  prev.resize(n);
  for (std::uint32_t k = 0; k < n; ++k) {
    next[k] = k + 1;
    prev[k] = k - 1;
  }
  next[n - 1] = 0;
  prev[0] = static_cast<std::uint32_t>(n - 1);
}

bool in_triangle(const LatticePoint& p, const LatticePoint& a, const LatticePoint& b, const LatticePoint& c) {
  return orient2d(a, b, p) >= 0 && orient2d(b, c, p) >= 0 && orient2d(c, a, p) >= 0;
}

}  // namespace

bool is_convex(std::span<const LatticePoint> points, std::span<const std::uint32_t> ring) {
  // A convex ring changes its direction in x twice; a ring that winds twice does so four times.
  int turns = 0;
  bool strict = false;
  std::int64_t last = 0;
  // Corners at one place are one corner: each of them alone would hide the turn that they make together.
  const auto at = [&](std::size_t k) -> const LatticePoint& { return points[ring[k]]; };
  const std::size_t n = ring.size();
  std::size_t j = n - 1;
  while (j > 0 && at(j) == at(0)) --j;
  std::size_t i = j;
  while (i > 0 && at(i) == at(j)) --i;
  for (std::size_t k = 0; k < n; ++k) {
    if (at(k) == at(j)) continue;
    const LatticePoint &a = at(i), &b = at(j), &c = at(k);
    const std::int64_t o = orient2d(a, b, c);
    if (o < 0) return false;
    strict |= o > 0;
    const std::int64_t dx = b.x - a.x;
    if (dx != 0) {
      if (last != 0 && (dx > 0) != (last > 0)) ++turns;
      last = dx;
    }
    i = j;
    j = k;
  }
  return strict && turns <= 2;
}

void clip_ears(std::span<const LatticePoint> points, std::span<const std::uint32_t> ring,
               Triangles& triangles) {
  const std::size_t n = ring.size();
  if (n < 3) return;
  if (n == 3) {
    triangles.push_back({ring[0], ring[1], ring[2]});
    return;
  }
  if (is_convex(points, ring)) {
    split_convex(ring, 0, n - 1, triangles);
    return;
  }

  thread_local std::vector<std::uint32_t> next, prev;  // kept: rings are many and small
  link_ring(n, next, prev);
  const auto at = [&](std::uint32_t k) -> const LatticePoint& { return points[ring[k]]; };
  const auto area = [&](std::uint32_t k) { return orient2d(at(prev[k]), at(k), at(next[k])); };
  const auto is_ear = [&](std::uint32_t k) {
    const LatticePoint &a = at(prev[k]), &b = at(k), &c = at(next[k]);
    for (std::uint32_t m = next[next[k]]; m != prev[k]; m = next[m]) {
      const LatticePoint& p = at(m);
      if (p == a || p == b || p == c) continue;  // a pinch touches, it does not block
      if (area(m) <= 0 && in_triangle(p, a, b, c)) return false;
    }
    return true;
  };
  // A ring that crosses itself may pass a point twice; an ear between its two visits uses one edge in both
  // directions, which cancels: nothing to emit.
  const auto emit = [&](std::uint32_t k) {
    const std::array<std::uint32_t, 3> t{ring[prev[k]], ring[k], ring[next[k]]};
    if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) triangles.push_back(t);
  };
  const auto cut = [&](std::uint32_t k) {
    emit(k);
    next[prev[k]] = next[k];
    prev[next[k]] = prev[k];
  };

  std::uint32_t k = 0;
  std::size_t left = n, since_cut = 0;
  while (left > 3) {
    if (area(k) > 0 && is_ear(k)) {
      cut(k);
      --left;
      since_cut = 0;
      k = next[next[k]];  // skipping one spreads the ears around the ring
      continue;
    }
    k = next[k];
    if (++since_cut < left) continue;
    // No proper ear: a flat one, or at worst the smallest.
    std::uint32_t best = k;
    for (std::size_t m = 0; m < left; ++m, k = next[k])
      if (std::llabs(area(k)) < std::llabs(area(best))) best = k;
    cut(best);
    --left;
    since_cut = 0;
    k = next[best];
  }
  emit(k);
}

}  // namespace fracture
