// The bisectors of one cell. For a cell with many bisectors, also their arrangement: which facets meet, and
// where the neighbours are. Testing all of them for each point would cost points x neighbours.
#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/vec.hpp"
#include "common/delaunay/tetrahedralization.hpp"
#include "common/voronoi/site_tree.hpp"

namespace fracture {

/// The bisector of site i and `neighbor` j, seen from i: value(q) = half - u·(q - p_i) is positive on i's
/// side. |value - computed| <= error for every q in the box that the diagram was made for.
struct Bisector {
  Vec3d u;      ///< p_j - p_i
  double half;  ///< |u|^2 / 2
  double error;
  SiteId neighbor;
  TetId tet;  ///< one of the tetrahedra at both sites
};

/// A number with a bound of its error.
struct Certified {
  double value, error;
};

struct Neighborhood {
  SiteId site;    ///< the cell
  SiteTree tree;  ///< of the neighbours, in the order of the cell's bisectors
  /// For each facet, the facets that share an edge with it. Facets are indices into the cell's bisectors.
  std::vector<std::uint32_t> begin, adjacent;

  enum class RayAnswer {
    kInside,     ///< the point is in the cell
    kOutside,    ///< the point is beyond the facet found
    kUncertain,  ///< doubles do not decide, or the walk is too long
  };
  /// Finds the facet through which the ray from the cell's site through a point leaves the cell. The cell is
  /// convex, so this is the facet with the least value / half. These are the values of a linear function at
  /// the corners of the cell's polar dual. So repeatedly moving to an adjacent facet with a smaller value
  /// finds it (the simplex method). The values' errors certify the comparisons.
  ///
  /// `all`: the cell's bisectors. `value(bisector)`: its value at the point as a Certified, times a positive
  /// factor that is the same for all bisectors. `on`: up to two facets whose bisectors contain the point;
  /// `value` is not called for them. The walk starts there, or otherwise at `facet`. `facet`: where the walk
  /// ended. `looked_at` is increased by the number of bisectors tested.
  template <class Value>
  RayAnswer shoot_ray(std::span<const Bisector> all, const Value& value, std::span<const std::uint32_t> on,
                      std::uint32_t& facet, std::uint64_t& looked_at) const;

 private:
  static constexpr int kLongWalk = 64;
  static constexpr std::size_t kManyAdjacent = 64;
};

template <class Value>
Neighborhood::RayAnswer Neighborhood::shoot_ray(std::span<const Bisector> all, const Value& value,
                                                std::span<const std::uint32_t> on, std::uint32_t& facet,
                                                std::uint64_t& looked_at) const {
  const auto lies_on = [&](std::uint32_t k) {
    for (const std::uint32_t o : on)
      if (o == k) return true;
    return false;
  };
  if (!on.empty()) facet = on[0];
  Certified least = on.empty() ? value(all[facet]) : Certified{0, 0};
  const auto answer_so_far = [&] {
    return least.value < -least.error ? RayAnswer::kOutside : RayAnswer::kUncertain;
  };
  for (int step = 0; step < kLongWalk; ++step) {
    const std::uint32_t first = begin[facet], last = begin[facet + 1];
    if (last - first > kManyAdjacent) return answer_so_far();
    looked_at += last - first;
    bool uncertain = false, moved = false, meets_other = false;
    for (std::uint32_t m = first; m < last; ++m) {
      const std::uint32_t k = adjacent[m];
      if (lies_on(k)) {  // its value is 0, which is not less
        meets_other = true;
        continue;
      }
      const Certified v = value(all[k]);
      // Compare v / half_k with least / half_facet.
      const double a = all[facet].half * v.value, b = all[k].half * least.value;
      const double error = 1.001 * (all[facet].half * v.error + all[k].half * least.error) +
                           0x1.0p-48 * (std::fabs(a) + std::fabs(b)) + 1e-300;
      if (a - b < -error) {
        facet = k;
        least = v;
        moved = true;
      }
      uncertain |= std::fabs(a - b) <= error;
    }
    if (moved) continue;
    if (uncertain) return answer_so_far();
    if (on.size() == 2 && facet == on[0]) {  // the other end of an edge of the dual, with the same value
      if (!meets_other) return RayAnswer::kUncertain;
      facet = on[1];
      continue;
    }
    if (lies_on(facet)) return RayAnswer::kInside;
    return least.value > least.error ? RayAnswer::kInside : answer_so_far();
  }
  return answer_so_far();
}

}  // namespace fracture
