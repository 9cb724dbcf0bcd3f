// Finds where columns cross the triangles of the surface.
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <utility>

#include "common/base/pacer.hpp"
#include "common/sites/column_sampler.hpp"

namespace fracture::sites_detail {
namespace {

/// A point in the plane perpendicular to the axis.
struct PlanePoint {
  double u, v;
};

/// Twice the signed area of (a, b, p) in that plane. The evaluation starts from the vertex with the lower id.
/// So both triangles at an edge get the same number with opposite signs, and a column crosses exactly one of
/// them.
double side(const PlanePoint& a, const PlanePoint& b, bool a_first, double u, double v) {
  const PlanePoint &p = a_first ? a : b, &q = a_first ? b : a;
  const double area = (q.u - p.u) * (v - p.v) - (q.v - p.v) * (u - p.u);
  return a_first ? area : -area;
}
/// Whether the column is left of the edge. A column exactly on the edge counts as left, seen from the lower
/// vertex.
bool left(double side, bool a_first) { return a_first ? side >= 0 : side > 0; }

/// An interval of the first coordinate; empty if low > high.
struct Range {
  double low = HUGE_VAL, high = -HUGE_VAL;
  void add(double u) {
    low = std::fmin(low, u);
    high = std::fmax(high, u);
  }
};
/// The part of the triangle inside the strip from v0 to v1.
Range within(const std::array<Vec3d, 3>& p, const ColumnFrame& f, double v0, double v1) {
  Range range;
  for (int k = 0; k < 3; ++k) {
    const Vec3d &a = p[k], &b = p[(k + 1) % 3];
    if (a[f.v] >= v0 && a[f.v] <= v1) range.add(a[f.u]);
    for (const double v : {v0, v1})
      if ((a[f.v] < v) != (b[f.v] < v))
        range.add(a[f.u] + (v - a[f.v]) / (b[f.v] - a[f.v]) * (b[f.u] - a[f.u]));
  }
  return range;
}

/// Maximum number of crossings held at a time. A batch of columns has about kCrossingsPerBatch crossings if
/// its depth was estimated well.
constexpr std::size_t kMostCrossings = 2 * ColumnSampler::kCrossingsPerBatch;

/// Number of crossings that a thread counts before it updates the shared counter.
constexpr std::size_t kCountedTogether = 4096;

}  // namespace

bool ColumnSampler::cross_all(int axis, std::span<const Column> columns, std::vector<Crossing>& crossings) {
  crossings.clear();
  if (columns.empty()) return true;
  Pacer pacer(execution_);
  const ColumnFrame f(axis);
  // A grid over the columns, with about sixteen cells per column, and a rim of cells for everything outside.
  // Most triangles meet only empty cells.
  const auto side_count = 2 + static_cast<std::uint32_t>(std::fmin(
                                  4096, 4 * std::ceil(std::sqrt(static_cast<double>(columns.size())))));
  double low_u = columns[0].u, high_u = low_u, low_v = columns[0].v, high_v = low_v;
  for (const Column& c : columns) {
    pacer.step();
    low_u = std::fmin(low_u, c.u);
    high_u = std::fmax(high_u, c.u);
    low_v = std::fmin(low_v, c.v);
    high_v = std::fmax(high_v, c.v);
  }
  const auto scale = [&](double size) { return size > 1e-300 ? (side_count - 2) / size : 0; };
  const double scale_u = scale(high_u - low_u), scale_v = scale(high_v - low_v);
  // Monotone: a column between the extreme coordinates of a triangle is in a cell between their cells.
  const auto cell = [rim = side_count - 1](double t, double low, double high, double scaling) {
    if (t < low) return 0u;
    if (t > high) return rim;
    const auto c = 1 + static_cast<std::uint32_t>((t - low) * scaling);
    return c < rim ? c : rim - 1;
  };
  const auto cell_u = [&](double u) { return cell(u, low_u, high_u, scale_u); };
  const auto cell_v = [&](double v) { return cell(v, low_v, high_v, scale_v); };
  std::vector<std::uint32_t> start(static_cast<std::size_t>(side_count) * side_count + 2, 0),
      items(columns.size());
  const auto cell_of = [&](const Column& c) { return cell_v(c.v) * side_count + cell_u(c.u); };
  for (const Column& c : columns) {
    pacer.step();
    ++start[cell_of(c) + 2];
  }
  for (std::size_t i = 2; i < start.size(); ++i) {
    pacer.step();
    start[i] += start[i - 1];
  }
  for (std::uint32_t i = 0; i < columns.size(); ++i) {
    pacer.step();
    items[start[cell_of(columns[i]) + 1]++] = i;
  }

  struct CellOfVertex {
    std::uint16_t u, v;
    bool operator==(const CellOfVertex&) const = default;
  };
  // If the columns are close together, nearly all triangles are beyond one side of all columns. Only the
  // other triangles go through the expensive steps.
  std::vector<std::uint8_t> beyond(solid_.positions.size());
  std::vector<CellOfVertex> cells(beyond.size());  // only of vertices that are not beyond
  const auto find_cell = [&](const Vec3d& p) {
    return CellOfVertex{static_cast<std::uint16_t>(cell_u(p[f.u])),
                        static_cast<std::uint16_t>(cell_v(p[f.v]))};
  };
  const auto inner_cell = [last = side_count - 2](double t, double low, double scaling) {  // like cell()
    return static_cast<std::uint16_t>(std::min(1 + static_cast<std::uint32_t>((t - low) * scaling), last));
  };
  parallel_for(execution_, beyond.size(), kAtOnce, [&](std::size_t first, std::size_t last) {
    for (std::size_t v = first; v < last; ++v) {
      const Vec3d p = to_double(solid_.positions[v]);
      const double at_u = p[f.u], at_v = p[f.v];
      beyond[v] = static_cast<std::uint8_t>((at_u < low_u) | (at_u > high_u) << 1 | (at_v < low_v) << 2 |
                                            (at_v > high_v) << 3);
      if (beyond[v] == 0) cells[v] = {inner_cell(at_u, low_u, scale_u), inner_cell(at_v, low_v, scale_v)};
    }
  });
  const auto cell_of_vertex = [&](VertexId v) {
    return beyond[v] == 0 ? cells[v] : find_cell(to_double(solid_.positions[v]));
  };
  /// A triangle projected along the columns.
  struct Crossed {
    std::uint32_t number;
    std::array<Vec3d, 3> corners;
    std::array<PlanePoint, 3> across;
    std::array<bool, 3> first;  // the edge from corner k leaves the vertex with the lower id
  };
  const auto seen = [&](std::uint32_t t) {
    Crossed triangle;
    triangle.number = t;
    const auto& id = solid_.triangles[t];
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3d& p = triangle.corners[k] = to_double(solid_.positions[id[k]]);
      triangle.across[k] = {p[f.u], p[f.v]};
      triangle.first[k] = id[k] < id[(k + 1) % 3];
    }
    return triangle;
  };
  const auto cross = [&](const Crossed& t, std::uint32_t item, std::vector<Crossing>& out) {
    const Column& column = columns[item];
    const auto& [a, b, c] = t.across;
    const double sc = side(a, b, t.first[0], column.u, column.v),
                 sa = side(b, c, t.first[1], column.u, column.v),
                 sb = side(c, a, t.first[2], column.u, column.v);
    const bool lc = left(sc, t.first[0]);
    if (lc != left(sa, t.first[1]) || lc != left(sb, t.first[2])) return;
    const double sum = sa + sb + sc;
    if (sum == 0) return;
    // Left of all three edges: counter-clockwise across the axis, so the normal points along the axis and the
    // column leaves the solid.
    const double at = (sa * t.corners[0][axis] + sb * t.corners[1][axis] + sc * t.corners[2][axis]) / sum;
    out.push_back({item, at, lc ? -1 : 1, t.number});
  };
  // Rows and cells of the grid are far wider than the rounding error of coordinates. So anything a whole row
  // or cell away is certainly outside.
  const auto reach = [](double low, double high) { return std::fmax(std::fabs(low), std::fabs(high)); };
  const bool wide = scale_u > 0 && scale_v > 0 && 1 / scale_u > 1e-12 * reach(low_u, high_u) &&
                    1 / scale_v > 1e-12 * reach(low_v, high_v);
  constexpr std::uint32_t kManyCells = 64;
  const auto cross_triangle = [&](std::uint32_t t, std::vector<Crossing>& out, std::uint64_t& comparisons,
                                  Pacer& own_pacer) {
    const auto& id = solid_.triangles[t];
    if ((beyond[id[0]] & beyond[id[1]] & beyond[id[2]]) != 0) return;
    const CellOfVertex a = cell_of_vertex(id[0]), b = cell_of_vertex(id[1]), c = cell_of_vertex(id[2]);
    const auto compare = [&](const Crossed& triangle, std::uint32_t first, std::uint32_t end) {
      comparisons += end - first;
      own_pacer.step(end - first);
      for (std::uint32_t k = first; k < end; ++k) cross(triangle, items[k], out);
    };
    const std::uint32_t u0 = std::min(std::min(a.u, b.u), c.u), u1 = std::max(std::max(a.u, b.u), c.u);
    const std::uint32_t v0 = std::min(std::min(a.v, b.v), c.v), v1 = std::max(std::max(a.v, b.v), c.v);
    own_pacer.step((v1 - v0) / 8);
    bool any = false;  // most triangles are as small as a cell, and most cells are empty
    for (std::uint32_t v = v0; v <= v1 && !any; ++v)
      any = start[v * side_count + u0] < start[v * side_count + u1 + 1];
    if (!any) return;
    const Crossed triangle = seen(t);
    const bool by_rows = wide && (u1 - u0) * (v1 - v0) > kManyCells;
    for (std::uint32_t v = v0; v <= v1; ++v) {
      std::uint32_t first = u0, last = u1;
      if (by_rows) {  // a long, thin triangle meets few of the cells in its box
        own_pacer.step();
        const double row = low_v + (static_cast<double>(v) - 1) / scale_v;
        const Range range = within(triangle.corners, f, row - 1 / scale_v, row + 2 / scale_v);
        if (range.low > range.high) continue;
        first = std::max(first, cell_u(range.low - 1 / scale_u));
        last = std::min(last, cell_u(range.high + 1 / scale_u));
        if (first > last) continue;
      }
      compare(triangle, start[v * side_count + first], start[v * side_count + last + 1]);
    }
  };
  // Whether the total is too large does not depend on thread timing.
  std::atomic<std::size_t> held{0};
  std::atomic<std::uint64_t> comparisons{0};
  const auto are_too_many = [&] { return held > kMostCrossings && columns.size() > 16; };
  const std::size_t triangles = solid_.triangles.size();
  std::vector<std::vector<Crossing>> found((triangles + kAtOnce - 1) / kAtOnce);
  parallel_for(execution_, triangles, kAtOnce, [&](std::size_t first, std::size_t last) {
    if (are_too_many()) return;
    Pacer own_pacer(execution_);
    std::vector<Crossing>& out = found[first / kAtOnce];
    std::size_t counted = 0;
    const auto count = [&] { held += out.size() - std::exchange(counted, out.size()); };
    std::uint64_t own_comparisons = 0;
    for (std::size_t t = first; t < last; ++t) {
      own_pacer.step();
      cross_triangle(static_cast<std::uint32_t>(t), out, own_comparisons, own_pacer);
      if (out.size() - counted < kCountedTogether) continue;
      count();
      if (are_too_many()) break;
    }
    count();
    comparisons += own_comparisons;
  });
  comparisons_ += comparisons;
  if (are_too_many()) return false;

  // Sort by column (counting sort), then sort the few crossings within each column.
  std::vector<std::size_t> begin(columns.size() + 1, 0);
  const auto each = [&](const auto& visit) {
    for (const std::vector<Crossing>& some : found) {
      pacer.step(1 + some.size());
      for (const Crossing& c : some) visit(c);
    }
  };
  each([&](const Crossing& c) { ++begin[c.column + 1]; });
  for (std::size_t k = 0; k < columns.size(); ++k) begin[k + 1] += begin[k];
  resize_with_polls(execution_, crossings, begin.back());
  std::vector<std::size_t> next(begin.begin(), begin.end() - 1);
  each([&](const Crossing& c) { crossings[next[c.column]++] = c; });
  parallel_for(execution_, columns.size(), kAtOnce / 4, [&](std::size_t first, std::size_t last) {
    const auto at = [&](std::size_t n) { return crossings.begin() + static_cast<std::ptrdiff_t>(n); };
    Pacer own_pacer(execution_);
    for (std::size_t k = first; k < last; ++k) {
      own_pacer.step(4 * (begin[k + 1] - begin[k]));
      sort_with_polls(execution_, at(begin[k]), at(begin[k + 1]), [](const Crossing& x, const Crossing& y) {
        if (x.at != y.at) return x.at < y.at;
        if (x.enters != y.enters) return x.enters > y.enters;
        return x.triangle < y.triangle;
      });
    }
  });
  return true;
}

}  // namespace fracture::sites_detail
