#include "common/clip/delaunay_flips.hpp"

#include <algorithm>

namespace fracture {
namespace {

constexpr std::uint32_t kNone = 0xffffffffu;

/// > 0 when d lies strictly inside the circle through the counter-clockwise a, b, c. Differences have 26
/// bits, the determinant fewer than 110: exact.
bool in_circle(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c, const LatticePoint& d) {
  const std::int64_t ax = a.x - d.x, ay = a.y - d.y, bx = b.x - d.x, by = b.y - d.y, cx = c.x - d.x,
                     cy = c.y - d.y;
  const __int128 al = static_cast<__int128>(ax) * ax + static_cast<__int128>(ay) * ay;
  const __int128 bl = static_cast<__int128>(bx) * bx + static_cast<__int128>(by) * by;
  const __int128 cl = static_cast<__int128>(cx) * cx + static_cast<__int128>(cy) * cy;
  return al * (static_cast<__int128>(bx) * cy - static_cast<__int128>(by) * cx) -
             bl * (static_cast<__int128>(ax) * cy - static_cast<__int128>(ay) * cx) +
             cl * (static_cast<__int128>(ax) * by - static_cast<__int128>(ay) * bx) >
         0;
}

class Flipper {
 public:
  Flipper(std::span<const LatticePoint> points, std::span<std::array<std::uint32_t, 3>> triangles)
      : points_(points), triangles_(triangles) {
    pair_edges();
  }

  void run() {
    std::vector<std::uint32_t> queue;
    for (std::uint32_t h = 0; h < twin_.size(); ++h)
      if (twin_[h] != kNone && h < twin_[h]) queue.push_back(h);
    std::size_t flips = kFlipsPerTriangle * triangles_.size();
    while (!queue.empty() && flips > 0) {
      const std::uint32_t h = queue.back();
      queue.pop_back();
      if (twin_[h] == kNone || !should_flip(h)) continue;
      const std::uint32_t g = twin_[h];
      flip(h);
      --flips;
      for (const std::uint32_t t : {h / 3, g / 3})
        for (std::uint32_t k = 3 * t; k < 3 * t + 3; ++k)
          if (twin_[k] != kNone) queue.push_back(k);
    }
  }

 private:
  // Half-edge h = 3 t + k runs from corner k to corner k+1 of triangle t.
  std::uint32_t from(std::uint32_t h) const { return triangles_[h / 3][h % 3]; }
  static std::uint32_t next(std::uint32_t h) { return h % 3 == 2 ? h - 2 : h + 1; }
  const LatticePoint& at(std::uint32_t v) const { return points_[v]; }

  // Twins by the lower end: each point has few edges, so its list is searched in place.
  void pair_edges() {
    twin_.assign(3 * triangles_.size(), kNone);
    std::vector<std::uint32_t> begin(points_.size() + 1, 0), half(twin_.size());
    for (std::uint32_t h = 0; h < twin_.size(); ++h) ++begin[std::min(from(h), from(next(h))) + 1];
    for (std::size_t v = 0; v < points_.size(); ++v) begin[v + 1] += begin[v];
    std::vector<std::uint32_t> end(begin.begin(), begin.end() - 1);
    for (std::uint32_t h = 0; h < twin_.size(); ++h) half[end[std::min(from(h), from(next(h)))]++] = h;
    for (std::size_t v = 0; v < points_.size(); ++v) {
      const auto upper = [&](std::uint32_t h) { return std::max(from(h), from(next(h))); };
      std::sort(half.begin() + begin[v], half.begin() + begin[v + 1], [&](std::uint32_t x, std::uint32_t y) {
        return upper(x) != upper(y) ? upper(x) < upper(y) : x < y;
      });
      for (std::uint32_t k = begin[v]; k < begin[v + 1];) {
        std::uint32_t last = k + 1;
        while (last < begin[v + 1] && upper(half[last]) == upper(half[k])) ++last;
        // Only a clean pair may be flipped; an edge that occurs more often (rounded loops that touch) stays
        // as it is.
        if (last - k == 2 && from(half[k]) != from(half[k + 1])) {
          twin_[half[k]] = half[k + 1];
          twin_[half[k + 1]] = half[k];
        }
        k = last;
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
    // The test on the triangle that is not flat.
    if (orient2d(at(a), at(b), at(c)) > 0) return in_circle(at(a), at(b), at(c), at(d));
    if (orient2d(at(b), at(a), at(d)) > 0) return in_circle(at(b), at(a), at(d), at(c));
    return true;
  }

  void flip(std::uint32_t h) {
    const std::uint32_t g = twin_[h], t = h / 3, u = g / 3;
    const std::uint32_t a = from(h), b = from(next(h)), c = from(next(next(h))), d = from(next(next(g)));
    const std::uint32_t bc = twin_[next(h)], ca = twin_[next(next(h))], ad = twin_[next(g)],
                        db = twin_[next(next(g))];
    triangles_[t] = {c, a, d};  // edges c-a, a-d, d-c
    triangles_[u] = {d, b, c};  // edges d-b, b-c, c-d
    const auto join = [&](std::uint32_t x, std::uint32_t y) {
      twin_[x] = y;
      if (y != kNone) twin_[y] = x;
    };
    join(3 * t, ca);
    join(3 * t + 1, ad);
    join(3 * u, db);
    join(3 * u + 1, bc);
    join(3 * t + 2, 3 * u + 2);
  }

  std::span<const LatticePoint> points_;
  std::span<std::array<std::uint32_t, 3>> triangles_;
  std::vector<std::uint32_t> twin_;
};

}  // namespace

void flip_to_delaunay(std::span<const LatticePoint> points,
                      std::span<std::array<std::uint32_t, 3>> triangles) {
  if (triangles.size() > 1) Flipper(points, triangles).run();
}

}  // namespace fracture
