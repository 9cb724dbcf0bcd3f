#include "common/rough/crossings.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>

namespace fracture {
namespace {

using Corners = std::array<Vec3d, 3>;

/// A triangle with its plane.
struct Facet {
  Corners corners;
  Vec3d normal;  // unit; zero where the triangle is flat: then every height is 0

  explicit Facet(const Corners& t) : corners(t), normal(cross(t[1] - t[0], t[2] - t[0])) {
    const double l = length(normal);
    normal = l > 0 ? (1 / l) * normal : Vec3d{};
  }
  double height(const Vec3d& p) const { return dot(normal, p - corners[0]); }
  /// Are there points of t on both sides?
  bool parts(const Facet& t, double tolerance) const {
    const double a = height(t.corners[0]), b = height(t.corners[1]), c = height(t.corners[2]);
    return std::fmax(a, std::fmax(b, c)) > tolerance && std::fmin(a, std::fmin(b, c)) < -tolerance;
  }
  /// x in the plane: farther than the tolerance inside all sides?
  bool contains(const Vec3d& x, double tolerance) const {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3d side = corners[(k + 1) % 3] - corners[k];
      if (!(dot(normal, cross(side, x - corners[k])) > tolerance * length(side))) return false;
    }
    return true;
  }
};

bool edges_pierce(const Facet& s, const Facet& t, double tolerance) {
  std::array<double, 3> h{};
  for (std::size_t k = 0; k < 3; ++k) h[k] = t.height(s.corners[k]);
  for (std::size_t k = 0; k < 3; ++k) {
    const double p = h[k], q = h[(k + 1) % 3];
    if (!((p > tolerance && q < -tolerance) || (p < -tolerance && q > tolerance))) continue;
    const Vec3d& from = s.corners[k];
    if (t.contains(from + (p / (p - q)) * (s.corners[(k + 1) % 3] - from), tolerance)) return true;
  }
  return false;
}

bool cross_each_other(const Facet& s, const Facet& t, double tolerance) {
  // Where one lies on one side of the other's plane, nothing is pierced.
  if (!s.parts(t, tolerance) || !t.parts(s, tolerance)) return false;
  return edges_pierce(s, t, tolerance) || edges_pierce(t, s, tolerance);
}

struct Bounds {
  Vec3d low, high;
};

Bounds bounds_of(const Corners& t) {
  Bounds b{t[0], t[0]};
  for (const Vec3d& p : {t[1], t[2]})
    for (int a = 0; a < 3; ++a) {
      b.low[a] = p[a] < b.low[a] ? p[a] : b.low[a];
      b.high[a] = p[a] > b.high[a] ? p[a] : b.high[a];
    }
  return b;
}

bool overlap(const Bounds& x, const Bounds& y) {
  return x.low.x <= y.high.x && y.low.x <= x.high.x && x.low.y <= y.high.y && y.low.y <= x.high.y &&
         x.low.z <= y.high.z && y.low.z <= x.high.z;
}

}  // namespace

bool triangles_cross(const std::array<Vec3d, 3>& s, const std::array<Vec3d, 3>& t, double tolerance) {
  return cross_each_other(Facet(s), Facet(t), tolerance);
}

std::uint64_t find_crossings(const CapSurface& caps, const SurfaceGrid& outside, const Box& box, double width,
                             double tolerance, const std::vector<char>& suspects, std::vector<char>& crossing,
                             const Execution& execution) {
  const std::size_t n = caps.triangles.size();
  const UniformGrid grid(box, width);
  std::vector<Bounds> bounds(n);
  std::vector<Facet> facets;
  facets.reserve(n);
  std::vector<std::uint32_t> begin(grid.size() + 1, 0);
  for (std::size_t t = 0; t < n; ++t) {
    const auto& v = caps.triangles[t];
    facets.emplace_back(Corners{caps.points[v[0] - caps.first], caps.points[v[1] - caps.first],
                                caps.points[v[2] - caps.first]});
    bounds[t] = bounds_of(facets[t].corners);
    grid.each_cell(bounds[t].low, bounds[t].high,
                   [&](const UniformGrid::Cell& c) { ++begin[grid.index(c) + 1]; });
  }
  for (std::size_t c = 0; c < grid.size(); ++c) begin[c + 1] += begin[c];
  std::vector<std::uint32_t> member(begin.back()), next(begin.begin(), begin.end() - 1);
  for (std::uint32_t t = 0; t < n; ++t)
    grid.each_cell(bounds[t].low, bounds[t].high,
                   [&](const UniformGrid::Cell& c) { member[next[grid.index(c)]++] = t; });

  const auto is_moved = [&](std::size_t t) {
    return std::any_of(caps.triangles[t].begin(), caps.triangles[t].end(),
                       [&](VertexId v) { return caps.moved[v - caps.first] != 0; });
  };
  const auto shared_corners = [&](std::size_t s, std::size_t t) {
    int shared = 0;
    for (const VertexId v : caps.triangles[s])
      for (const VertexId w : caps.triangles[t]) shared += v == w;
    return shared;
  };
  // Can the triangle have reached the outer surface? Its flat points are within 0.58 of its longest edge of a
  // corner.
  const auto may_touch_surface = [&](std::size_t t) {
    double longest = 0, move = 0, surface = HUGE_VAL;
    for (std::size_t k = 0; k < 3; ++k) {
      longest = std::fmax(longest, length(facets[t].corners[(k + 1) % 3] - facets[t].corners[k]));
      move = std::fmax(move, caps.surface[caps.triangles[t][k] - caps.first]);
      surface = std::fmin(surface, caps.surface[caps.triangles[t][k] - caps.first]);
    }
    return surface < 0.58 * longest + move;
  };

  constexpr std::size_t kBlock = 256;
  std::vector<std::vector<std::uint32_t>> found((n + kBlock - 1) / kBlock);
  std::atomic<std::uint64_t> pairs{0};
  parallel_for(execution, n, kBlock, [&](std::size_t first, std::size_t last) {
    std::vector<std::uint32_t>& out = found[first / kBlock];
    std::uint64_t count = 0;
    for (std::size_t s = first; s < last; ++s) {
      const bool moved = is_moved(s), suspect = suspects.empty() || suspects[s];
      grid.each_cell(bounds[s].low, bounds[s].high, [&](const UniformGrid::Cell& cell) {
        const std::size_t c = grid.index(cell);
        for (std::uint32_t k = begin[c]; k < begin[c + 1]; ++k) {
          const std::uint32_t t = member[k];
          if (t <= s || !overlap(bounds[s], bounds[t])) continue;
          if (!suspect && !suspects[t]) continue;
          if (!moved && !is_moved(t)) continue;
          if (!cross_each_other(facets[s], facets[t], tolerance) || shared_corners(s, t) >= 2) continue;
          // Once for each pair: in the cell where their boxes' overlap begins.
          const Vec3d corner{std::fmax(bounds[s].low.x, bounds[t].low.x),
                             std::fmax(bounds[s].low.y, bounds[t].low.y),
                             std::fmax(bounds[s].low.z, bounds[t].low.z)};
          if (grid.cell_of(corner) != cell) continue;
          out.push_back(static_cast<std::uint32_t>(s));
          out.push_back(t);
          ++count;
        }
      });
      if (!moved || !suspect || !may_touch_surface(s)) continue;
      bool touches = false;
      outside.each_near({bounds[s].low, bounds[s].high}, [&](std::uint32_t t) {
        if (touches) return;
        const Corners other = outside.corners(t);
        touches =
            overlap(bounds[s], bounds_of(other)) && cross_each_other(facets[s], Facet(other), tolerance);
      });
      if (!touches) continue;
      out.push_back(static_cast<std::uint32_t>(s));
      ++count;
    }
    pairs += count;
  });
  crossing.assign(n, 0);
  for (const auto& block : found)
    for (const std::uint32_t t : block) crossing[t] = 1;
  return pairs;
}

}  // namespace fracture
