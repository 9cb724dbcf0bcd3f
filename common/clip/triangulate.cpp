#include "common/clip/triangulate.hpp"

#include <algorithm>
#include <cstdlib>
#include <numeric>
#include <tuple>

#include "common/base/disjoint_sets.hpp"
#include "common/base/id.hpp"
#include "common/base/pacer.hpp"
#include "common/base/scratch.hpp"
#include "common/clip/delaunay_flips.hpp"
#include "common/clip/ear_clipping.hpp"
#include "common/clip/least_area.hpp"
#include "common/clip/monotone_partition.hpp"
#include "common/clip/pinched_ring.hpp"
#include "common/clip/touching_loops.hpp"

namespace fracture {
namespace {

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

// Up to this size, ears are as fast as a sweep and give better triangles.
constexpr std::size_t kSmallRing = 64;

/// Garey, Johnson, Preparata & Tarjan 1978, implemented as ear cutting on a linked ring, so that it cannot
/// use an edge twice: a triangle is only cut if its three corners are consecutive. Returns false and emits
/// nothing if the ring is not monotone.
bool triangulate_monotone(std::span<const LatticePoint> points, std::span<const std::uint32_t> ring,
                          Triangles& triangles, const Execution& execution) {
  const std::size_t n = ring.size(), before = triangles.size();
  std::vector<std::uint32_t> next(n), prev(n), order(n);
  for (std::size_t k = 0; k < n; ++k) {
    next[k] = static_cast<std::uint32_t>((k + 1) % n);
    prev[k] = static_cast<std::uint32_t>((k + n - 1) % n);
  }
  std::iota(order.begin(), order.end(), 0u);
  const auto at = [&](std::uint32_t k) -> const LatticePoint& { return points[ring[k]]; };
  sort_with_polls(execution, order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::tie(at(a).y, at(a).x, ring[a], a) < std::tie(at(b).y, at(b).x, ring[b], b);
  });
  const auto cut = [&](std::uint32_t k) {
    triangles.push_back({ring[prev[k]], ring[k], ring[next[k]]});
    next[prev[k]] = next[k];
    prev[next[k]] = prev[k];
  };
  const auto fail = [&] {
    triangles.resize(before);
    return false;
  };

  Pacer pacer(execution);
  std::vector<std::uint32_t> stack{order[0], order[1]};
  for (std::size_t m = 2; m < n; ++m) {
    pacer.step(2);
    const std::uint32_t v = order[m], top = stack.back();
    if (next[top] == v || prev[top] == v) {
      // The same chain (or the last vertex, adjacent to both): cut while the top corner is convex.
      while (stack.size() >= 2) {
        const std::uint32_t k = stack.back();
        const bool forward = next[k] == v;
        if (!forward && prev[k] != v) return fail();
        if (m + 1 < n && orient2d(at(prev[k]), at(k), at(next[k])) <= 0) break;
        if (prev[k] == next[k]) break;
        const std::uint32_t below = stack[stack.size() - 2];
        if ((forward ? prev[k] : next[k]) != below) return fail();
        cut(k);
        stack.pop_back();
      }
      stack.push_back(v);
    } else {
      // The opposite chain: cut a fan from v over the whole stack, starting at its bottom, which is v's
      // neighbour.
      for (std::size_t s = 0; s + 1 < stack.size(); ++s) {
        const std::uint32_t k = stack[s];
        if (next[k] != v && prev[k] != v) return fail();
        if ((next[k] == v ? prev[k] : next[k]) != stack[s + 1]) return fail();
        cut(k);
      }
      stack.assign({top, v});
    }
  }
  return triangles.size() == before + n - 2 || fail();
}

/// Triangulates one ring after another.
class RingTriangulator {
 public:
  /// `points`: total number of points of all rings.
  RingTriangulator(std::size_t points, const Execution& execution)
      : execution_(execution),
        pacer_(execution),
        patience_((std::size_t{1} << 19) + kStepsPerPoint * points) {}

  /// Triangulates a whole loop, or a ring of its `partition`.
  void add(std::span<const LatticePoint> points, std::span<const std::uint32_t> ring,
           const Partition* partition, Triangles& triangles) {
    if (partition)
      add_ring(points, ring, *partition, triangles);
    else if (ring.size() <= kSmallRing || is_convex(points, ring))
      clip(points, ring, ear_patience(ring.size()), triangles);
    else
      add_loop(points, ring, triangles);
  }
  enum class Small {
    kEars,
    kLeastArea  ///< if corners are on diagonals, a good ear may leave a ring that is turned over
  };
  /// Also divides the ring where it returns to a position. `small`: the method for rings of some dozens of
  /// corners.
  void add_divided(std::span<const LatticePoint> points, std::span<const std::uint32_t> ring,
                   const Partition* partition, Small small, Triangles& triangles) {
    std::vector<std::vector<std::uint32_t>> rings;
    divide_pinched_ring(points, ring, rings, triangles);
    for (const auto& r : rings) {
      if (small == Small::kLeastArea && r.size() <= kSmallRing) {
        pacer_.step(1 + r.size() * r.size() * r.size() / 64);
        if (triangulate_least_area(points, r, triangles)) continue;
      }
      add(points, r, partition, triangles);
    }
  }
  /// Whether some ring was triangulated without regard to the shape of its triangles.
  bool given_up() const { return given_up_; }

 private:
  static constexpr std::uint32_t kManyCrossings = 8;
  /// If many rings cross themselves, limits their total work to less than the sum of the rings' own limits.
  static constexpr std::size_t kStepsPerPoint = 512;

  void add_ring(std::span<const LatticePoint> points, std::span<const std::uint32_t> ring,
                const Partition& partition, Triangles& triangles) {
    if (ring.size() > kSmallRing && triangulate_monotone(points, ring, triangles, execution_)) return;
    // The ring is not monotone after all, because the loops touch or cross. If there are many crossings, no
    // good triangulation exists.
    const bool hopeless = ring.size() > kSmallRing && partition.crossings > kManyCrossings;
    clip(points, ring, hopeless ? 4 * ring.size() : ear_patience(ring.size()), triangles);
  }
  void clip(std::span<const LatticePoint> points, std::span<const std::uint32_t> ring, std::size_t patience,
            Triangles& triangles) {
    std::size_t left = std::min(patience, patience_);
    const std::size_t given = left;
    given_up_ |= !clip_ears(points, ring, triangles, execution_, left);
    patience_ -= given - left;
  }
  void add_loop(std::span<const LatticePoint> points, std::span<const std::uint32_t> loop,
                Triangles& triangles) {
    std::vector<LatticePoint> own(loop.size());
    for (std::size_t k = 0; k < loop.size(); ++k) own[k] = points[loop[k]];
    const std::array<std::uint32_t, 2> begin{0, static_cast<std::uint32_t>(loop.size())};
    Partition partition;
    partition_monotone(own, begin, partition, execution_);
    const std::size_t from = triangles.size();
    for (std::size_t r = 0; r < partition.count(); ++r)
      add_ring(own, partition.ring(r), partition, triangles);
    for (std::size_t t = from; t < triangles.size(); ++t)
      for (std::uint32_t& k : triangles[t]) k = loop[k];
  }

  const Execution& execution_;
  Pacer pacer_;
  std::size_t patience_;  // remaining steps of the search for ears
  bool given_up_ = false;
};

/// Length in the 1-norm.
std::int64_t span_of(const LatticePoint& p, const LatticePoint& q) {
  return std::llabs(p.x - q.x) + std::llabs(p.y - q.y);
}

/// Whether the triangle is lower than two lattice steps over its longest edge. This indicates collinear loop
/// points that do not face the inside.
bool is_flat(std::span<const LatticePoint> points, const std::array<std::uint32_t, 3>& t) {
  const LatticePoint &a = points[t[0]], &b = points[t[1]], &c = points[t[2]];
  return orient2d(a, b, c) <= 2 * std::max({span_of(a, b), span_of(b, c), span_of(c, a)});
}

int orientation(std::span<const LatticePoint> points, std::uint32_t begin, std::uint32_t end) {
  __int128 sum = 0;
  for (std::uint32_t k = begin + 1; k + 1 < end; ++k)
    sum += orient2d(points[begin], points[k], points[k + 1]);
  return sum > 0 ? 1 : sum < 0 ? -1 : 0;
}

/// Twice the area of the triangles that are turned over by more than rounding explains: those higher than two
/// lattice steps over their longest edge.
__int128 turned_over(std::span<const LatticePoint> points, const Triangles& triangles) {
  __int128 sum = 0;
  for (const auto& t : triangles) {
    const LatticePoint &a = points[t[0]], &b = points[t[1]], &c = points[t[2]];
    const std::int64_t area = orient2d(a, b, c);
    if (area < 0 && area < -2 * std::max({span_of(a, b), span_of(b, c), span_of(c, a)})) sum -= area;
  }
  return sum;
}

struct LoopOfPoints {
  std::vector<std::uint32_t> points;
  std::size_t bytes() const { return bytes_of_vectors(points); }
  void release() { release_vectors(points); }
};

/// The main part of triangulate(), for loops without repeated corners. `ring(points, ring, partition,
/// triangles)` triangulates one ring. Without a partition, it is a whole loop, which may be large and not
/// monotone.
template <class Ring>
void triangulate_loops(std::span<const LatticePoint> points, std::span<const std::uint32_t> loop_begin,
                       const Execution& execution, const Ring& ring, Triangulation& out) {
  out.clear();
  Pacer pacer(execution);
  const auto loops = static_cast<std::uint32_t>(loop_begin.size() - 1);
  bool holes = false;
  for (std::uint32_t l = 0; l < loops && loops > 1; ++l) {
    pacer.step(loop_begin[l + 1] - loop_begin[l]);
    holes |= orientation(points, loop_begin[l], loop_begin[l + 1]) < 0;
  }
  if (!holes) {  // every loop is a separate region
    std::vector<std::uint32_t>& loop = thread_scratch<LoopOfPoints>().points;  // reused for all loops
    for (std::uint32_t l = 0; l < loops; ++l) {
      loop.resize(loop_begin[l + 1] - loop_begin[l]);
      pacer.step(loop.size());
      std::iota(loop.begin(), loop.end(), loop_begin[l]);
      ring(points, std::span<const std::uint32_t>(loop), nullptr, out.triangles);
      out.region.resize(out.triangles.size(), out.regions++);
    }
    return;
  }
  Partition partition;
  partition_monotone(points, loop_begin, partition, execution);
  out.unnested_loops = static_cast<std::uint32_t>(partition.unnested.size());
  // The rings of one region become consecutive. Regions are numbered by their first ring.
  std::vector<std::uint32_t> number(loops, 0xffffffffu);
  for (std::size_t r = 0; r < partition.count(); ++r) {
    pacer.step();
    std::uint32_t& region = number[partition.ring_loop[r]];
    if (region == 0xffffffffu) region = out.regions++;
    ring(points, partition.ring(r), &partition, out.triangles);
    out.region.resize(out.triangles.size(), region);
  }
}

DisjointSets joined_points(std::size_t points, const Triangles& triangles) {
  DisjointSets joined(points);
  for (const auto& t : triangles) {
    joined.unite(t[0], t[1]);
    joined.unite(t[1], t[2]);
  }
  return joined;
}

/// Assigns one region to each connected set of triangles.
void number_regions(std::size_t points, Triangulation& out) {
  DisjointSets joined = joined_points(points, out.triangles);
  std::vector<std::uint32_t> number(points, kNoIndex);
  out.regions = 0;
  for (std::size_t t = 0; t < out.triangles.size(); ++t) {
    std::uint32_t& region = number[joined.find(out.triangles[t][0])];
    if (region == kNoIndex) region = out.regions++;
    out.region[t] = region;
  }
}

enum class Touching {
  kKept,
  kLinked  ///< and moved apart; see touching_loops.hpp
};

/// The same for loops that pass positions more than once: removes repeated corners, and divides rings where
/// they return to a position.
Triangulation triangulate_pinched(std::span<const LatticePoint> points,
                                  std::span<const std::uint32_t> loop_begin, Touching touching,
                                  RingTriangulator::Small small, const Execution& execution) {
  Pacer pacer(execution);
  Triangles flat;
  std::vector<std::uint32_t> kept, begin{0}, loop;
  for (std::size_t l = 0; l + 1 < loop_begin.size(); ++l) {
    loop.resize(loop_begin[l + 1] - loop_begin[l]);
    pacer.step(loop.size());
    std::iota(loop.begin(), loop.end(), loop_begin[l]);
    const std::vector<std::uint32_t> rest = leave_out_repeated(points, loop, flat);
    kept.insert(kept.end(), rest.begin(), rest.end());
    begin.push_back(static_cast<std::uint32_t>(kept.size()));
  }
  std::vector<LatticePoint> places;
  if (touching == Touching::kLinked) {
    link_touching_loops(points, kept, begin, flat, execution);
    places = moved_inwards(points, kept, begin, execution);
  } else {
    for (const std::uint32_t k : kept) places.push_back(points[k]);
  }
  Triangulation out;
  RingTriangulator rings(points.size(), execution);
  triangulate_loops(
      places, begin, execution,
      [&](const auto& p, const auto& ring, const Partition* partition, Triangles& triangles) {
        rings.add_divided(p, ring, partition, small, triangles);
      },
      out);
  std::vector<std::uint32_t> region_of(points.size(), 0xffffffffu);
  for (std::size_t t = 0; t < out.triangles.size(); ++t)
    for (std::uint32_t& k : out.triangles[t]) region_of[k = kept[k]] = out.region[t];
  for (const auto& t : flat) {
    std::uint32_t& region = region_of[t[0]];
    if (region == 0xffffffffu) region = out.regions++;
    out.triangles.push_back(t);
    out.region.push_back(region);
  }
  if (touching == Touching::kLinked) number_regions(points.size(), out);
  return out;
}

/// Divides regions that are not connected because a ring between their parts enclosed nothing.
void divide_regions(std::size_t points, Triangulation& out) {
  DisjointSets joined = joined_points(points, out.triangles);
  std::vector<std::uint32_t> part_of(out.regions, kNoIndex), number(points, kNoIndex);
  bool divided = false;
  for (std::size_t t = 0; t < out.triangles.size(); ++t) {
    const std::uint32_t part = joined.find(out.triangles[t][0]);
    std::uint32_t& first = part_of[out.region[t]];
    if (first == kNoIndex) {
      first = part;
      number[part] = out.region[t];
    } else if (number[part] == kNoIndex) {
      number[part] = out.regions++;
      divided = true;
    }
  }
  for (std::size_t t = 0; divided && t < out.triangles.size(); ++t)
    out.region[t] = number[joined.find(out.triangles[t][0])];
}

}  // namespace

void triangulate(std::span<const LatticePoint> points, std::span<const std::uint32_t> loop_begin,
                 Triangulation& out, const Execution& execution) {
  RingTriangulator rings(points.size(), execution);
  triangulate_loops(
      points, loop_begin, execution,
      [&](const auto& p, const auto& ring, const Partition* partition, Triangles& triangles) {
        rings.add(p, ring, partition, triangles);
      },
      out);
  bool pinched = false;
  // If loops cross everywhere, further attempts do not help.
  if (__int128 turned = turned_over(points, out.triangles); turned > 0 && !rings.given_up()) {
    using Small = RingTriangulator::Small;
    const auto try_again = [&](Touching touching, Small small, __int128 most) {
      if (turned == 0) return;
      Triangulation other = triangulate_pinched(points, loop_begin, touching, small, execution);
      const __int128 now = turned_over(points, other.triangles);
      if (now > most) return;
      pinched = true;
      turned = now;
      out = std::move(other);
    };
    try_again(Touching::kKept, Small::kEars, turned - 1);
    try_again(Touching::kKept, Small::kLeastArea, 0);  // loops that cross stay as they are
    try_again(Touching::kLinked, Small::kLeastArea, 0);
  }
  if (pinched || out.regions + 1 < loop_begin.size()) divide_regions(points.size(), out);
  // Flips stay within a region, because regions share no inner edge.
  if (!rings.given_up() && std::any_of(out.triangles.begin(), out.triangles.end(),
                                       [&](const auto& t) { return is_flat(points, t); }))
    flip_to_delaunay(points, out.triangles, execution);
}

}  // namespace fracture
