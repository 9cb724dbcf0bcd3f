#include "common/sites/column_sampler.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <utility>

#include "common/base/pacer.hpp"

namespace fracture::sites_detail {
namespace {

/// Coordinates across and along the axis: (u, v, axis) is right-handed.
struct Frame {
  int u, v, axis;
};
Frame frame_of(int axis) { return {(axis + 1) % 3, (axis + 2) % 3, axis}; }

/// Twice the signed area of (a, b, p) in the plane across the axis. Evaluated from the vertex with the lower
/// id, so that both triangles of an edge get the same number with opposite signs and a column passes exactly
/// one of them.
double side(const Frame& f, const Vec3d& a, const Vec3d& b, bool a_first, double u, double v) {
  const Vec3d &p = a_first ? a : b, &q = a_first ? b : a;
  const double area = (q[f.u] - p[f.u]) * (v - p[f.v]) - (q[f.v] - p[f.v]) * (u - p[f.u]);
  return a_first ? area : -area;
}
/// A column on an edge counts as left of it, seen from the lower vertex.
bool left(double side, bool a_first) { return a_first ? side >= 0 : side > 0; }

/// Of the first coordinate; empty where low > high.
struct Range {
  double low = HUGE_VAL, high = -HUGE_VAL;
  void add(double u) {
    low = std::fmin(low, u);
    high = std::fmax(high, u);
  }
};
/// Where the triangle lies within the strip from v0 to v1.
Range within(const std::array<Vec3d, 3>& p, const Frame& f, double v0, double v1) {
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

/// Held at a time. A batch of columns has about kCrossingsPerBatch where its depth was estimated well.
constexpr std::size_t kMostCrossings = 2 * ColumnSampler::kCrossingsPerBatch;

/// Vertices or triangles of a block of parallel work, and crossings that a thread counts at a time.
constexpr std::size_t kAtOnce = 1024, kCountedTogether = 4096;

constexpr std::uint64_t kSiteStream = 0x5173'0000'0000'0001ull, kProbeStream = 0x5173'0000'0000'0002ull;

}  // namespace

ColumnSampler::ColumnSampler(const Solid& solid, std::uint64_t seed, const Execution& execution)
    : solid_(solid), execution_(execution), seed_(seed) {}

void ColumnSampler::choose_axis() {
  const Solid& solid = solid_;
  // The axis along which most candidates are kept: least (projected area × width). Normals are found on all threads,
  // some at a time, and added up in the order of the triangles.
  const std::size_t triangles = solid.triangles.size(), some = std::min(triangles, 16 * kAtOnce);
  std::vector<Vec3d> normals(some);
  const auto each_normal = [&](const auto& visit) {
    for (std::size_t first = 0; first < triangles; first += some) {
      const std::size_t count = std::min(some, triangles - first);
      parallel_for(execution_, count, kAtOnce, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
          const auto& c = solid.triangles[first + k];
          const Vec3d a = to_double(solid.positions[c[0]]);
          normals[k] = cross(to_double(solid.positions[c[1]]) - a, to_double(solid.positions[c[2]]) - a);
        }
      });
      for (std::size_t k = 0; k < count; ++k) visit(first + k, normals[k]);
    }
  };
  std::array<double, 3> area{};
  each_normal([&](std::size_t, const Vec3d& n) {
    for (int k = 0; k < 3; ++k) area[k] += n[k] < 0 ? -0.5 * n[k] : 0;
  });
  const Vec3d size = solid.box.size();
  for (int k = 1; k < 3; ++k)
    if (area[k] * size[k] < area[axis_] * size[axis_]) axis_ = k;
  resize_with_polls(execution_, entry_area_, triangles);
  double sum = 0;
  each_normal([&](std::size_t t, const Vec3d& n) {
    if (n[axis_] < 0) sum -= n[axis_];
    entry_area_[t] = sum;
  });

  cap_ = size[axis_];
  if (solid.report.volume >= area[axis_] * size[axis_] / 64) return;
  std::vector<Column> probes;
  for (std::uint64_t k = 0; k < 256; ++k) probes.push_back(column(kProbeStream, k));
  double longest = 0;
  for (const Chord& chord : chords(probes)) longest = std::fmax(longest, chord.length);
  if (longest > 0) cap_ = longest;
}

ColumnSampler::Column ColumnSampler::column(std::uint64_t stream, std::uint64_t number) const {
  Random seeder(seed_ ^ stream);
  Random random(seeder() + number * 0xd1b54a32d192ed03ull);
  const double pick = random.uniform() * entry_area_.back();
  double b = random.uniform(), c = random.uniform();
  const double keep = random.uniform(), share = random.uniform();
  if (b + c > 1) b = 1 - b, c = 1 - c;
  // The first running sum beyond `pick` belongs to a triangle of positive area.
  const auto it = std::upper_bound(entry_area_.begin(), entry_area_.end(), pick);
  auto triangle = static_cast<std::uint32_t>(it - entry_area_.begin());
  if (it == entry_area_.end())  // pick rounded up to the total
    triangle = static_cast<std::uint32_t>(
        std::lower_bound(entry_area_.begin(), entry_area_.end(), entry_area_.back()) - entry_area_.begin());
  const auto& corners = solid_.triangles[triangle];
  const Vec3d p = to_double(solid_.positions[corners[0]]);
  const Vec3d q = p + b * (to_double(solid_.positions[corners[1]]) - p) +
                  c * (to_double(solid_.positions[corners[2]]) - p);
  const Frame f = frame_of(axis_);
  return {triangle, q[f.u], q[f.v], keep, share};
}

bool ColumnSampler::cross_all(int axis, std::span<const Column> columns, std::vector<Crossing>& crossings) {
  crossings.clear();
  if (columns.empty()) return true;
  Pacer pacer(execution_);
  const Frame f = frame_of(axis);
  // A grid over where columns stand, about sixteen cells for each of them, and a rim of cells for all that
  // lies outside: most triangles meet empty cells only.
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
  // Monotone: a column between the extreme coordinates of a triangle stands in a cell between theirs.
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
  // Where the columns stand close together nearly all triangles lie beyond one side of all of them; what takes time
  // is only done for the others.
  std::vector<std::uint8_t> beyond(solid_.positions.size());
  std::vector<CellOfVertex> cells(beyond.size());  // of those that are not beyond
  const auto find_cell = [&](const Vec3d& p) {
    return CellOfVertex{static_cast<std::uint16_t>(cell_u(p[f.u])),
                        static_cast<std::uint16_t>(cell_v(p[f.v]))};
  };
  parallel_for(execution_, beyond.size(), kAtOnce, [&](std::size_t first, std::size_t last) {
    for (std::size_t v = first; v < last; ++v) {
      const Vec3d p = to_double(solid_.positions[v]);
      const double at_u = p[f.u], at_v = p[f.v];
      beyond[v] = static_cast<std::uint8_t>((at_u < low_u) | (at_u > high_u) << 1 | (at_v < low_v) << 2 |
                                            (at_v > high_v) << 3);
      if (beyond[v] == 0) cells[v] = find_cell(p);
    }
  });
  const auto cell_of_vertex = [&](VertexId v) {
    return beyond[v] == 0 ? cells[v] : find_cell(to_double(solid_.positions[v]));
  };
  const auto cross = [&](std::uint32_t t, std::uint32_t item, std::vector<Crossing>& out) {
    const Column& column = columns[item];
    const auto& id = solid_.triangles[t];
    const Vec3d a = to_double(solid_.positions[id[0]]), b = to_double(solid_.positions[id[1]]),
                c = to_double(solid_.positions[id[2]]);
    const bool ab = id[0] < id[1], bc = id[1] < id[2], ca = id[2] < id[0];
    const double sc = side(f, a, b, ab, column.u, column.v), sa = side(f, b, c, bc, column.u, column.v),
                 sb = side(f, c, a, ca, column.u, column.v);
    const bool lc = left(sc, ab);
    if (lc != left(sa, bc) || lc != left(sb, ca)) return;
    const double sum = sa + sb + sc;
    if (sum == 0) return;
    // Left of all three edges: counter-clockwise across the axis, so the normal points along it: a way out.
    out.push_back({item, (sa * a[axis] + sb * b[axis] + sc * c[axis]) / sum, lc ? -1 : 1, t});
  };
  // Rows and cells of the grid are far wider than the rounding of coordinates: what lies a whole row or cell
  // off is off for sure.
  const auto reach = [](double low, double high) { return std::fmax(std::fabs(low), std::fabs(high)); };
  const bool wide = scale_u > 0 && scale_v > 0 && 1 / scale_u > 1e-12 * reach(low_u, high_u) &&
                    1 / scale_v > 1e-12 * reach(low_v, high_v);
  constexpr std::uint32_t kManyCells = 64;
  const auto cross_triangle = [&](std::uint32_t t, std::vector<Crossing>& out, std::uint64_t& comparisons,
                                  Pacer& own_pacer) {
    const auto& id = solid_.triangles[t];
    if ((beyond[id[0]] & beyond[id[1]] & beyond[id[2]]) != 0) return;
    const CellOfVertex a = cell_of_vertex(id[0]), b = cell_of_vertex(id[1]), c = cell_of_vertex(id[2]);
    const auto compare = [&](std::uint32_t first, std::uint32_t end) {
      comparisons += end - first;
      own_pacer.step(end - first);
      for (std::uint32_t k = first; k < end; ++k) cross(t, items[k], out);
    };
    if (a == b && b == c) {  // most triangles are smaller than a cell
      const std::uint32_t at = a.v * side_count + a.u;
      return compare(start[at], start[at + 1]);
    }
    const std::uint32_t u0 = std::min(std::min(a.u, b.u), c.u), u1 = std::max(std::max(a.u, b.u), c.u);
    const std::uint32_t v0 = std::min(std::min(a.v, b.v), c.v), v1 = std::max(std::max(a.v, b.v), c.v);
    const bool by_rows = wide && (u1 - u0) * (v1 - v0) > kManyCells;
    const std::array<Vec3d, 3> corners{to_double(solid_.positions[id[0]]), to_double(solid_.positions[id[1]]),
                                       to_double(solid_.positions[id[2]])};
    for (std::uint32_t v = v0; v <= v1; ++v) {
      std::uint32_t first = u0, last = u1;
      if (by_rows) {  // a triangle that is long and thin meets few of the cells of its box
        own_pacer.step();
        const double row = low_v + (static_cast<double>(v) - 1) / scale_v;
        const Range range = within(corners, f, row - 1 / scale_v, row + 2 / scale_v);
        if (range.low > range.high) continue;
        first = std::max(first, cell_u(range.low - 1 / scale_u));
        last = std::min(last, cell_u(range.high + 1 / scale_u));
        if (first > last) continue;
      }
      compare(start[v * side_count + first], start[v * side_count + last + 1]);
    }
  };
  // Whether all together find too many does not depend on who finds them when.
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

  // By column (counting sort), then the few of each.
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

std::vector<ColumnSampler::Chord> ColumnSampler::chords(std::span<const Column> columns) {
  Pacer pacer(execution_);
  std::vector<Crossing> crossings;
  std::vector<Chord> chords(columns.size());
  for (std::size_t done = 0; done < columns.size();) {
    const std::span<const Column> some = columns.subspan(done, std::min(batch(), columns.size() - done));
    if (!cross_all(axis_, some, crossings)) {
      depth_ *= 4;
      continue;
    }
    depth_ = 1 + crossings.size() / (some.size() + 1);
    for (std::size_t i = 0; i < crossings.size();) {
      const std::uint32_t column = crossings[i].column;
      const std::size_t first = i;
      Chord chord;
      int winding = 0;
      bool open = false;
      for (; i < crossings.size() && crossings[i].column == column; ++i) {
        pacer.step();
        const int before = winding;
        winding += crossings[i].enters;
        if (before <= 0 && winding >= 1 && crossings[i].triangle == some[column].triangle) {
          chord.begin = crossings[i].at;
          open = true;
        } else if (open && winding <= 0) {
          chord.length = crossings[i].at - chord.begin;
          open = false;
        }
      }
      // Rounding next to a vertex can lose a crossing; such a column is not used.
      if (winding == 0) chords[done + column] = chord;
      chords[done + column].crossings = static_cast<std::uint32_t>(i - first);
    }
    done += some.size();
  }
  return chords;
}

std::vector<bool> ColumnSampler::inside(std::span<const Vec3d> points) {
  // Along the shortest side of the box columns meet the fewest triangles.
  const Vec3d size = solid_.box.size();
  int axis = 0;
  for (int a = 1; a < 3; ++a)
    if (size[a] < size[axis]) axis = a;
  const Frame f = frame_of(axis);
  Pacer pacer(execution_);
  std::vector<bool> result(points.size(), false);
  std::vector<std::uint32_t> candidates;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    pacer.step();
    bool in_box = true;
    for (int a = 0; a < 3; ++a)
      in_box = in_box && points[i][a] >= solid_.box.min[a] && points[i][a] <= solid_.box.max[a];
    if (in_box) candidates.push_back(i);
  }
  std::vector<Column> columns;
  std::vector<Crossing> crossings;
  for (std::size_t first = 0; first < candidates.size();) {
    const std::size_t count = std::min(candidates.size() - first, batch());
    columns.clear();
    for (std::size_t k = 0; k < count; ++k) {
      const Vec3d& p = points[candidates[first + k]];
      pacer.step();
      columns.push_back({kNoIndex, p[f.u], p[f.v], 0, 0});
    }
    if (!cross_all(axis, columns, crossings)) {
      depth_ *= 4;
      continue;
    }
    depth_ = 1 + crossings.size() / (count + 1);
    for (std::size_t i = 0; i < crossings.size();) {
      const std::uint32_t column = crossings[i].column, point = candidates[first + column];
      int below = 0, total = 0;
      for (; i < crossings.size() && crossings[i].column == column; ++i) {
        pacer.step();
        total += crossings[i].enters;
        if (crossings[i].at < points[point][axis]) below += crossings[i].enters;
      }
      result[point] = total == 0 && below >= 1;  // a lost crossing (see chords()): not used
    }
    first += count;
  }
  return result;
}

double ColumnSampler::height_on_triangle(const Column& column) const {
  const auto& id = solid_.triangles[column.triangle];
  double sum = 0;
  for (const std::uint32_t v : id) sum += to_double(solid_.positions[v])[axis_];
  return sum / 3;
}

Vec3d ColumnSampler::place(const Column& column, double along) const {
  const Frame f = frame_of(axis_);
  Vec3d p;
  p[f.u] = column.u;
  p[f.v] = column.v;
  p[axis_] = along;
  return p;
}

std::vector<Vec3d> ColumnSampler::sample(std::uint32_t count) {
  if (entry_area_.empty() && count > 0) choose_axis();
  std::vector<Vec3d> points;
  points.reserve(count);
  std::uint64_t candidate = 0;
  std::uint32_t refused = 0;
  std::uint64_t looked_at = 0;
  double rate = 0.5;  // kept candidates per candidate, so far: only the size of the next batch depends on it
  std::vector<Column> columns;
  Pacer pacer(execution_);
  while (points.size() < count) {
    const double wanted = static_cast<double>(count - points.size()) / std::fmax(rate, 1e-3);
    // Columns that meet very many triangles (tangled surfaces) come in small batches, to bound the memory.
    const auto tried = static_cast<std::uint64_t>(std::fmin(1.1 * wanted + 32, static_cast<double>(batch())));
    columns.resize(tried);
    parallel_for(execution_, tried, kAtOnce / 4, [&](std::size_t first, std::size_t last) {
      for (std::size_t k = first; k < last; ++k) columns[k] = column(kSiteStream, candidate + k);
    });
    const std::vector<Chord> found = chords(columns);
    for (std::size_t k = 0; k < columns.size() && points.size() < count; ++k) {
      pacer.step(2);
      const Chord& chord = found[k];
      const bool kept = chord.length > 0 && columns[k].keep * cap_ < chord.length;
      looked_at += chord.crossings;
      if (!kept && ++refused < kPatience && looked_at < kCrossingsPerPoint) continue;
      const bool has_chord = chord.length > 0;
      const double along =
          has_chord ? chord.begin + columns[k].share * chord.length : height_on_triangle(columns[k]);
      points.push_back(place(columns[k], along));
      refused = 0;
      looked_at = 0;
    }
    candidate += tried;
    rate = (static_cast<double>(points.size()) + 1) / (static_cast<double>(candidate) + 1);
  }
  return points;
}

}  // namespace fracture::sites_detail
