#include "common/solid/shells.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/base/pacer.hpp"
#include "common/exact/volume_sum.hpp"
#include "common/solid/polled.hpp"

namespace fracture::solid_detail {
namespace {

Vec3d origin_of(const Surface& surface, const Shell& shell) {
  return to_double(surface.positions[surface.triangles[shell.first][0]]);
}

/// The largest volume of a flat shell with this area and box, m³.
double flat_volume(const Shell& shell) {
  double largest = 0;
  for (int axis = 0; axis < 3; ++axis)
    largest = std::fmax(largest, std::fmax(std::fabs(shell.box.min[axis]), std::fabs(shell.box.max[axis])));
  return std::fmax(kFlatRatio * shell.area * std::sqrt(shell.area), kThinnestRatio * largest * shell.area);
}

/// Whether the shell encloses no volume beyond rounding errors.
bool is_flat(const Shell& shell) { return std::fabs(shell.volume) <= flat_volume(shell); }

/// Sums the volumes of these shells again, with twice the digits.
void refine_volumes(const Surface& surface, const std::vector<std::uint32_t>& cancelling, Shells& shells,
                    const Execution& execution) {
  std::vector<std::uint32_t> slot = filled(execution, shells.list.size(), kNoIndex);
  std::vector<exact::VolumeSum> sums;
  Pacer pacer(execution);
  for (const std::uint32_t id : cancelling) {
    pacer.step();
    slot[id] = static_cast<std::uint32_t>(sums.size());
    sums.emplace_back(origin_of(surface, shells.list[id]));
  }
  for (const TriangleId t : ids<TriangleId>(surface.triangles.size())) {
    pacer.step(4);
    const std::uint32_t s = slot[shells.of_triangle[t]];
    if (s == kNoIndex) continue;
    const Triangle& c = surface.triangles[t];
    sums[s].add(to_double(surface.positions[c[0]]), to_double(surface.positions[c[1]]),
                to_double(surface.positions[c[2]]));
  }
  for (const std::uint32_t id : cancelling) {
    pacer.step();
    shells.list[id].volume = sums[slot[id]].volume();
    shells.list[id].flat = is_flat(shells.list[id]);
  }
}

/// Union-find over the triangles (Tarjan 1975, path halving): the root of a set is its lowest member.
std::uint32_t root_of(std::vector<std::uint32_t>& up, std::uint32_t t) {
  while (up[t] != t) t = up[t] = up[up[t]];
  return t;
}
void unite(std::vector<std::uint32_t>& up, std::uint32_t s, std::uint32_t t) {
  if (up[s] == up[t]) return;  // the usual case
  s = root_of(up, s);
  t = root_of(up, t);
  up[std::max(s, t)] = std::min(s, t);
}

/// Returns the shell of each triangle. `first`: the lowest triangle of each shell.
std::vector<std::uint32_t> number_by_lowest(const Surface& surface, std::vector<TriangleId>& first,
                                            const Execution& execution) {
  // First, each block of triangles is processed separately; then the edges from a block to an earlier one.
  constexpr std::size_t kAtOnce = 32768;
  const std::size_t count = surface.triangles.size();
  std::vector<std::uint32_t> up = filled(execution, count, kNoIndex);
  std::vector<std::vector<HalfEdge>> between((count + kAtOnce - 1) / kAtOnce);
  parallel_for(execution, count, kAtOnce, [&](std::size_t begin, std::size_t end) {
    std::vector<HalfEdge>& leaves = between[begin / kAtOnce];
    for (std::size_t t = begin; t < end; ++t) {
      up[t] = static_cast<std::uint32_t>(t);
      for (std::size_t h = 3 * t; h < 3 * t + 3; ++h) {
        const TriangleId neighbour = triangle_of(surface.twin[h]);
        if (neighbour >= t) continue;
        if (neighbour >= begin)
          unite(up, neighbour, static_cast<std::uint32_t>(t));
        else
          leaves.push_back(static_cast<HalfEdge>(h));
      }
    }
  });
  Pacer pacer(execution);
  for (std::vector<HalfEdge>& leaves : between) {
    for (const HalfEdge h : leaves) {
      pacer.step();
      unite(up, triangle_of(surface.twin[h]), triangle_of(h));
    }
    leaves = {};
  }
  // A triangle's parent has a lower number, so its shell is already known.
  pacer.each(0, count, [&](std::size_t t) {
    if (up[t] != t) {
      up[t] = up[up[t]];
      return;
    }
    up[t] = static_cast<std::uint32_t>(first.size());
    first.push_back(TriangleId{t});
  });
  return up;
}

/// Contribution of a triangle to its shell's measurements.
struct Terms {
  double volume;    ///< six times the tetrahedron (origin, a, b, c)
  double area;      ///< twice the area
  double products;  ///< product of the lengths of two edges
};

/// Consecutive triangles of one shell; most triangles follow others of their shell.
struct Run {
  std::uint32_t shell, triangles;
  Box box;
};

/// Number of triangles whose terms are computed at once, and how many of them by one thread.
constexpr std::size_t kTermsAtOnce = 65536, kTermsOfOneThread = 8192;

/// Computes the terms of the triangles [begin, end), and divides them into runs.
void compute_terms(const Surface& surface, const Shells& shells, std::size_t begin, std::size_t end,
                   Terms* terms, std::vector<Run>& runs) {
  runs.clear();
  for (std::size_t t = begin; t < end;) {
    Run run{shells.of_triangle[t], 0, {}};
    const Vec3d origin = origin_of(surface, shells.list[run.shell]);
    for (; t < end && shells.of_triangle[t] == run.shell; ++t, ++run.triangles) {
      const Triangle& corners = surface.triangles[t];
      const Vec3d a = to_double(surface.positions[corners[0]]), b = to_double(surface.positions[corners[1]]),
                  c = to_double(surface.positions[corners[2]]);
      run.box.add(a);
      run.box.add(b);
      run.box.add(c);
      const Vec3d ab = b - a, ac = c - a, normal = cross(ab, ac);
      *terms++ = {dot(a - origin, normal), length(normal), exact::max_norm(ab) * exact::max_norm(ac)};
    }
    runs.push_back(run);
  }
}

/// Sums the contributions of the triangles to their shells: first along each uninterrupted run, then over the
/// runs, always in the order of the triangles, regardless of threads.
void sum_figures(const Surface& surface, Shells& shells, std::vector<double>& edge_products,
                 const Execution& execution) {
  const std::size_t count = surface.triangles.size();
  std::vector<Terms> terms(std::min(count, kTermsAtOnce));
  std::array<std::vector<Run>, kTermsAtOnce / kTermsOfOneThread> runs;
  std::uint32_t shell = kNoIndex;  // shell of the current run
  Terms sum{};
  const auto finish_run = [&] {
    if (shell == kNoIndex) return;
    shells.list[shell].volume += sum.volume;
    shells.list[shell].area += sum.area;
    edge_products[shell] += sum.products;
    sum = {};
  };
  for (std::size_t from = 0; from < count; from += kTermsAtOnce) {
    const std::size_t now = std::min(count - from, kTermsAtOnce);
    parallel_for(execution, now, kTermsOfOneThread, [&](std::size_t begin, std::size_t end) {
      compute_terms(surface, shells, from + begin, from + end, terms.data() + begin,
                    runs[begin / kTermsOfOneThread]);
    });
    const Terms* term = terms.data();
    for (std::size_t block = 0; block * kTermsOfOneThread < now; ++block)
      for (const Run& run : runs[block]) {
        if (run.shell != shell) finish_run();
        shell = run.shell;
        shells.list[shell].triangles += run.triangles;
        shells.list[shell].box.add(run.box);
        for (const Terms* const end = term + run.triangles; term < end; ++term) {
          sum.volume += term->volume;
          sum.area += term->area;
          sum.products += term->products;
        }
      }
  }
  finish_run();
}

}  // namespace

Shells find_shells(const Surface& surface, const Execution& execution) {
  Shells shells;
  std::vector<TriangleId> first;
  shells.of_triangle = number_by_lowest(surface, first, execution);
  shells.list = filled(execution, first.size(), Shell{});
  std::vector<double> edge_products = filled(execution, first.size(), 0.0);
  for_each_polled(execution, first.size(), [&](std::size_t s) { shells.list[s].first = first[s]; });
  sum_figures(surface, shells, edge_products, execution);
  Pacer pacer(execution);
  std::vector<std::uint32_t> cancelling;
  for (Shell& shell : shells.list) {
    pacer.step();
    shell.volume /= 6;
    shell.area /= 2;
    shell.flat = is_flat(shell);
    const auto id = static_cast<std::uint32_t>(&shell - shells.list.data());
    if (!shell.flat && exact::cancels(shell.volume, edge_products[id], shell.box.longest_side()))
      cancelling.push_back(id);
  }
  if (!cancelling.empty()) refine_volumes(surface, cancelling, shells, execution);
  return shells;
}

std::uint64_t count_cancelling(const Surface& surface, const Shells& shells, const Execution& execution) {
  // A thin shell in a plane has only small terms. The rounding of its corners may double them a few times.
  constexpr double kRounded = 8;
  std::vector<double> sums = filled(execution, shells.list.size(), 0.0);
  for_each_polled(execution, surface.triangles.size(), [&](std::size_t t) {
    const std::uint32_t s = shells.of_triangle[t];
    const Triangle& corners = surface.triangles[t];
    const Vec3d a = to_double(surface.positions[corners[0]]), b = to_double(surface.positions[corners[1]]),
                c = to_double(surface.positions[corners[2]]);
    sums[s] += std::fabs(dot(a - origin_of(surface, shells.list[s]), cross(b - a, c - a))) / 6;
  });
  std::uint64_t count = 0;
  for_each_polled(execution, sums.size(), [&](std::size_t s) {
    count += shells.list[s].flat && sums[s] > kRounded * flat_volume(shells.list[s]);
  });
  return count;
}

}  // namespace fracture::solid_detail
