#include "common/sites/column_sampler.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "common/base/pacer.hpp"

namespace fracture::sites_detail {
namespace {

constexpr std::uint64_t kSiteStream = 0x5173'0000'0000'0001ull, kProbeStream = 0x5173'0000'0000'0002ull;

}  // namespace

ColumnSampler::ColumnSampler(const Solid& solid, std::uint64_t seed, const Execution& execution)
    : solid_(solid), execution_(execution), seed_(seed) {}

void ColumnSampler::choose_axis() {
  const Solid& solid = solid_;
  // Choose the axis along which most candidates are kept: the one with the least (projected area × width).
  // All threads compute twice the entry areas, one block of triangles at a time. The areas are then added up
  // for each axis in the order of the triangles.
  const std::size_t triangles = solid.triangles.size(), some = std::min(triangles, 16 * kAtOnce);
  std::vector<Vec3d> areas(some);
  std::array<std::vector<double>, 3> entry_area;
  for (std::vector<double>& sums : entry_area) resize_with_polls(execution_, sums, triangles);
  Vec3d area;
  for (std::size_t first = 0; first < triangles; first += some) {
    const std::size_t count = std::min(some, triangles - first);
    parallel_for(execution_, count, kAtOnce, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) {
        const auto& c = solid.triangles[first + k];
        const Vec3d a = to_double(solid.positions[c[0]]);
        const Vec3d n = cross(to_double(solid.positions[c[1]]) - a, to_double(solid.positions[c[2]]) - a);
        areas[k] = {std::max(0.0, -n.x), std::max(0.0, -n.y), std::max(0.0, -n.z)};
      }
    });
    for (std::size_t k = 0; k < count; ++k) {
      area = area + areas[k];
      entry_area[0][first + k] = area.x;
      entry_area[1][first + k] = area.y;
      entry_area[2][first + k] = area.z;
    }
  }
  area = 0.5 * area;
  const Vec3d size = solid.box.size();
  for (int k = 1; k < 3; ++k)
    if (area[k] * size[k] < area[axis_] * size[axis_]) axis_ = k;
  entry_area_ = std::move(entry_area[static_cast<std::size_t>(axis_)]);

  // The probability that a candidate is kept. All chords together make up the volume.
  const auto probability = [&] { return std::fmin(solid.report.volume / (area[axis_] * cap_), 1); };
  cap_ = size[axis_];
  rate_ = probability();
  if (solid.report.volume >= area[axis_] * size[axis_] / 64) return;
  std::vector<Column> probes;
  for (std::uint64_t k = 0; k < 256; ++k) probes.push_back(column(kProbeStream, k));
  double longest = 0;
  for (const Chord& chord : chords(probes)) longest = std::fmax(longest, chord.length);
  if (longest > 0) cap_ = longest;
  rate_ = probability();
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
  const ColumnFrame f(axis_);
  return {triangle, q[f.u], q[f.v], keep, share};
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
      // Rounding next to a vertex can lose a crossing; a column with a lost crossing is not used.
      if (winding == 0) chords[done + column] = chord;
      chords[done + column].crossings = static_cast<std::uint32_t>(i - first);
    }
    done += some.size();
  }
  return chords;
}

std::vector<bool> ColumnSampler::inside(std::span<const Vec3d> points) {
  // Columns along the shortest side of the box meet the fewest triangles.
  const Vec3d size = solid_.box.size();
  int axis = 0;
  for (int a = 1; a < 3; ++a)
    if (size[a] < size[axis]) axis = a;
  const ColumnFrame f(axis);
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
      result[point] = total == 0 && below >= 1;  // false if a crossing was lost (see chords())
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
  const ColumnFrame f(axis_);
  Vec3d p;
  p[f.u] = column.u;
  p[f.v] = column.v;
  p[axis_] = along;
  return p;
}

std::vector<Vec3d> ColumnSampler::spread(std::uint32_t count) {
  if (entry_area_.empty() && count > 0) choose_axis();
  Pacer pacer(execution_);
  std::vector<Column> columns;
  for (std::uint64_t k = 0; k < 2 * std::uint64_t{count}; ++k) {
    pacer.step(4);
    columns.push_back(column(kSiteStream, k));
  }
  const std::vector<Chord> found = chords(columns);
  double all = 0;
  for (const Chord& chord : found) all += std::fmax(chord.length, 0);
  std::vector<Vec3d> points;
  if (!(all > 0)) return points;
  const double apart = all / count;
  double before = 0;  // length of all chords before this one
  std::uint32_t next = 0;
  const auto at = [&] { return (next + columns[next].share) * apart; };
  for (std::size_t k = 0; k < columns.size(); ++k) {
    const Chord& chord = found[k];
    if (!(chord.length > 0)) continue;
    for (; next < count && at() < before + chord.length; ++next) {
      pacer.step();
      points.push_back(place(columns[k], chord.begin + std::fmax(at() - before, 0)));
    }
    before += chord.length;
  }
  return points;
}

std::vector<Vec3d> ColumnSampler::sample(std::uint32_t count) {
  if (entry_area_.empty() && count > 0) choose_axis();
  std::vector<Vec3d> points;
  points.reserve(count);
  std::uint64_t candidate = 0;
  std::uint32_t refused = 0;
  std::uint64_t looked_at = 0;
  double rate = rate_;  // share of the candidates that are kept; affects only the size of the next batch
  std::vector<Column> columns;
  Pacer pacer(execution_);
  while (points.size() < count) {
    const double wanted = static_cast<double>(count - points.size()) / std::fmax(rate, 1e-3);
    // Columns that meet very many triangles (tangled surfaces) are tested in small batches, to bound the
    // memory.
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
