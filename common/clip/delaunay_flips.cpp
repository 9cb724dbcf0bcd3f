#include "common/clip/delaunay_flips.hpp"

#include <algorithm>
#include <cmath>

#include "common/base/id.hpp"
#include "common/base/pacer.hpp"
#include "common/base/scratch.hpp"

namespace fracture {

bool in_circle(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c, const LatticePoint& d) {
  const std::int64_t ax = a.x - d.x, ay = a.y - d.y, bx = b.x - d.x, by = b.y - d.y, cx = c.x - d.x,
                     cy = c.y - d.y;
  // Products of two differences are exact in 64 bits. As doubles, each of these six products has a relative
  // error of at most 2^-53, each of the three terms less than 4 * 2^-53, and their sum less than 8 * 2^-53 of
  // the sum of magnitudes.
  const auto a2 = static_cast<double>(ax * ax + ay * ay), b2 = static_cast<double>(bx * bx + by * by),
             c2 = static_cast<double>(cx * cx + cy * cy);
  const double u = a2 * static_cast<double>(bx * cy - by * cx),
               v = b2 * static_cast<double>(ax * cy - ay * cx),
               w = c2 * static_cast<double>(ax * by - ay * bx);
  const double sum = u - v + w, bound = 0x1.0p-50 * (std::fabs(u) + std::fabs(v) + std::fabs(w));
  if (std::fabs(sum) > bound) return sum > 0;
  const auto term = [](std::int64_t square, std::int64_t minor) {
    return static_cast<__int128>(square) * minor;
  };
  return term(ax * ax + ay * ay, bx * cy - by * cx) - term(bx * bx + by * by, ax * cy - ay * cx) +
             term(cx * cx + cy * cy, ax * by - ay * bx) >
         0;
}

namespace {

/// Keeps its memory between triangulations, because they are many and small.
class Flipper {
 public:
  void run(std::span<const LatticePoint> points, std::span<std::array<std::uint32_t, 3>> triangles,
           const Execution& execution) {
    Pacer pacer(execution);
    points_ = points;
    corner_.resize(4 * triangles.size());
    for (std::size_t t = 0; t < triangles.size(); ++t)
      for (std::size_t k = 0; k < 3; ++k) corner_[4 * t + k] = triangles[t][k];
    pair_edges(pacer);
    queue_.clear();
    for (std::uint32_t h = 0; h < twin_.size(); ++h)
      if (twin_[h] != kNoIndex && h < twin_[h]) queue_.push_back(h);
    std::size_t flips = kFlipsPerTriangle * triangles.size();
    while (!queue_.empty() && flips > 0) {
      const std::uint32_t h = queue_.back();
      queue_.pop_back();
      pacer.step(4);
      if (twin_[h] == kNoIndex || !should_flip(h)) continue;
      const std::uint32_t g = twin_[h];
      flip(h);
      --flips;
      for (const std::uint32_t t : {h & ~3u, g & ~3u})
        for (std::uint32_t k = t; k < t + 3; ++k)
          if (twin_[k] != kNoIndex) queue_.push_back(k);
    }
    for (std::size_t t = 0; t < triangles.size(); ++t)
      for (std::size_t k = 0; k < 3; ++k) triangles[t][k] = corner_[4 * t + k];
  }

  std::size_t bytes() const { return bytes_of_vectors(corner_, twin_, queue_, begin_, end_, uses_); }
  void release() { release_vectors(corner_, twin_, queue_, begin_, end_, uses_); }

 private:
  // Half-edge h = 4 t + k, k = 0, 1, 2, goes from corner k to corner k+1 of triangle t.
  std::uint32_t from(std::uint32_t h) const { return corner_[h]; }
  static std::uint32_t next(std::uint32_t h) { return (h & 3) == 2 ? h - 2 : h + 1; }
  const LatticePoint& at(std::uint32_t v) const { return points_[v]; }

  // Finds twins by their lower end. Each point has few edges, so its list is sorted by the upper end in
  // place.
  void pair_edges(Pacer& pacer) {
    const auto size = static_cast<std::uint32_t>(corner_.size());
    twin_.assign(size, kNoIndex);
    begin_.assign(points_.size() + 1, 0);
    uses_.resize(size / 4 * 3);
    const auto each = [&](const auto& visit) {
      for (std::uint32_t t = 0; t < size; t += 4) {
        pacer.step();
        for (std::uint32_t h = t; h < t + 3; ++h) {
          const std::uint32_t u = from(h), v = from(next(h));
          visit(std::min(u, v), std::max(u, v), h);
        }
      }
    };
    each([&](std::uint32_t low, std::uint32_t, std::uint32_t) { ++begin_[low + 1]; });
    for (std::size_t v = 0; v < points_.size(); ++v) begin_[v + 1] += begin_[v];
    end_.assign(begin_.begin(), begin_.end() - 1);
    each([&](std::uint32_t low, std::uint32_t high, std::uint32_t h) {
      uses_[end_[low]++] = static_cast<std::uint64_t>(high) << 32 | h;
    });
    for (std::size_t v = 0; v < points_.size(); ++v) {
      const std::uint32_t last = begin_[v + 1];
      pacer.step(1 + 4 * (last - begin_[v]));
      std::sort(uses_.begin() + begin_[v], uses_.begin() + last);
      for (std::uint32_t k = begin_[v]; k < last;) {
        std::uint32_t other = k + 1;
        while (other < last && uses_[other] >> 32 == uses_[k] >> 32) ++other;
        // Only a clean pair may be flipped. An edge that is used more often (rounded loops that touch) stays
        // as it is.
        if (other - k == 2) {
          const auto h = static_cast<std::uint32_t>(uses_[k]), g = static_cast<std::uint32_t>(uses_[k + 1]);
          if (from(h) != from(g)) {
            twin_[h] = g;
            twin_[g] = h;
          }
        }
        k = other;
      }
    }
  }

  //        c                 c
  //      / | \             /   \        h = a -> b in (a, b, c), its twin b -> a in (b, a, d)
  //     a  |h b    flip   a-----b       (drawn with a, b as the ends of h)
  //      \ | /             \   /
  //        d                 d
  bool should_flip(std::uint32_t h) const {
    const std::uint32_t a = from(h), b = from(next(h)), c = from(next(next(h))),
                        d = from(next(next(twin_[h])));
    if (c == d) return false;
    if (orient2d(at(c), at(a), at(d)) <= 0 || orient2d(at(d), at(b), at(c)) <= 0)
      return false;  // not strictly convex
    // Test with the triangle that is not flat.
    if (orient2d(at(a), at(b), at(c)) > 0) return in_circle(at(a), at(b), at(c), at(d));
    if (orient2d(at(b), at(a), at(d)) > 0) return in_circle(at(b), at(a), at(d), at(c));
    return true;
  }

  void flip(std::uint32_t h) {
    const std::uint32_t g = twin_[h], t = h & ~3u, u = g & ~3u;
    const std::uint32_t a = from(h), b = from(next(h)), c = from(next(next(h))), d = from(next(next(g)));
    const std::uint32_t bc = twin_[next(h)], ca = twin_[next(next(h))], ad = twin_[next(g)],
                        db = twin_[next(next(g))];
    const auto set = [&](std::uint32_t first, std::uint32_t p, std::uint32_t q, std::uint32_t r) {
      corner_[first] = p;
      corner_[first + 1] = q;
      corner_[first + 2] = r;
    };
    set(t, c, a, d);  // edges c-a, a-d, d-c
    set(u, d, b, c);  // edges d-b, b-c, c-d
    const auto join = [&](std::uint32_t x, std::uint32_t y) {
      twin_[x] = y;
      if (y != kNoIndex) twin_[y] = x;
    };
    join(t, ca);
    join(t + 1, ad);
    join(u, db);
    join(u + 1, bc);
    join(t + 2, u + 2);
  }

  std::span<const LatticePoint> points_;
  std::vector<std::uint32_t> corner_, twin_;  // by half-edge
  std::vector<std::uint32_t> queue_;
  std::vector<std::uint32_t> begin_, end_;  // per point: its range in uses_
  std::vector<std::uint64_t> uses_;         // upper end << 32 | half-edge, by lower end
};

}  // namespace

void flip_to_delaunay(std::span<const LatticePoint> points, std::span<std::array<std::uint32_t, 3>> triangles,
                      const Execution& execution) {
  if (triangles.size() > 1) thread_scratch<Flipper>().run(points, triangles, execution);
}

}  // namespace fracture
