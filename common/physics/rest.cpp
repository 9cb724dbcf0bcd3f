#include "common/physics/rest.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "common/base/pacer.hpp"
#include "common/physics/hull_maker.hpp"
#include "common/physics/hull_trim.hpp"

namespace fracture {
namespace {

/// Maximum number of cuts for a pair of bodies. Each cut separates two of their hulls.
constexpr int kMostCuts = 64;

/// Two overlapping hulls, with their extents along the normal in world coordinates.
struct Clash {
  CollisionHull &a, &b;
  const Vec3d &pivot_a, &pivot_b;
  Vec3d normal;            ///< from a to b
  double last_a, first_b;  ///< coordinates along the normal
};

Clash clash_of(const Overlap& overlap, const FragmentSet& set, CollisionHulls& hulls) {
  const auto [a, b] = overlap.pair;
  Clash clash{hulls.of_fragment[a].hulls[overlap.hull_a],
              hulls.of_fragment[b].hulls[overlap.hull_b],
              set.fragments[a].pivot,
              set.fragments[b].pivot,
              overlap.normal,
              -HUGE_VAL,
              HUGE_VAL};
  for (const Vec3f& p : clash.a.points)
    clash.last_a = std::fmax(clash.last_a, dot(clash.normal, clash.pivot_a + to_double(p)));
  for (const Vec3f& p : clash.b.points)
    clash.first_b = std::fmin(clash.first_b, dot(clash.normal, clash.pivot_b + to_double(p)));
  return clash;
}

/// Two hulls after a cut, and the shares of their volumes that are left.
struct Cut {
  CollisionHull a, b;
  double share_a = 0, share_b = 0;
  double least() const { return std::fmin(share_a, share_b); }
};

Cut cut(const Clash& clash, double end_a, double begin_b, const Execution& execution) {
  Cut made;
  const auto share = [](const CollisionHull& rest, const CollisionHull& whole) {
    const double volume = volume_within(whole.points, whole.triangles);
    return volume > 0 ? volume_within(rest.points, rest.triangles) / volume : 0;
  };
  made.a = trimmed(clash.a, clash.normal, end_a - dot(clash.normal, clash.pivot_a), execution);
  made.b = trimmed(clash.b, -1.0 * clash.normal, dot(clash.normal, clash.pivot_b) - begin_b, execution);
  made.share_a = share(made.a, clash.a);
  made.share_b = share(made.b, clash.b);
  return made;
}

/// Trims two bodies until they overlap by at most the tolerance, if possible. Returns the remaining overlap.
double trim_apart(const BodyPair& pair, const Bodies& bodies, const FragmentSet& set, CollisionHulls& hulls,
                  double tolerance, const Execution& execution) {
  const double gap = std::fmin(kHullInset, tolerance);  // less than the inset in small solids
  for (int k = 0; k < kMostCuts; ++k) {
    const Overlap overlap = deepest_overlap(bodies, pair, execution);
    if (overlap.depth <= tolerance) return overlap.depth;
    const Clash clash = clash_of(overlap, set, hulls);
    const double middle = 0.5 * (clash.last_a + clash.first_b);
    std::array<Cut, 3> cuts{cut(clash, clash.first_b - gap, clash.first_b, execution),
                            cut(clash, clash.last_a, clash.last_a + gap, execution),
                            cut(clash, middle - 0.5 * gap, middle + 0.5 * gap, execution)};
    Cut& best = *std::max_element(cuts.begin(), cuts.end(),
                                  [](const Cut& x, const Cut& y) { return x.least() < y.least(); });
    if (!(best.least() > 0)) return overlap.depth;
    clash.a = std::move(best.a);
    clash.b = std::move(best.b);
    hulls.of_fragment[pair.a].least_share *= std::fmin(best.share_a, 1);
    hulls.of_fragment[pair.b].least_share *= std::fmin(best.share_b, 1);
  }
  return deepest_overlap(bodies, pair, execution).depth;
}

Bodies bodies_of(const FragmentSet& set, const CollisionHulls& hulls, const Execution& execution) {
  Pacer pacer(execution);
  Bodies bodies;
  for (std::size_t k = 0; k < set.fragments.size(); ++k) {
    pacer.step();
    bodies.fragments.push_back(&set.fragments[k]);
    bodies.hulls.push_back(&hulls.of_fragment[k]);
  }
  return bodies;
}

/// An unfinished result, and the pairs that need filters, ascending.
struct Search {
  Rest rest;
  std::vector<BodyPair> deep;

  void see(const Overlap& overlap) { see(overlap.pair, overlap.depth); }
  void see(const BodyPair& pair, double depth) {
    if (depth > rest.figures.tolerance)
      deep.push_back(pair);
    else
      rest.figures.deepest = std::fmax(rest.figures.deepest, depth);
  }
  /// Records a pair that may collide.
  void leave(double depth) {
    ++rest.figures.left;
    rest.figures.deepest = std::fmax(rest.figures.deepest, depth);
  }
};

Search begin(const Bodies& bodies, const CellsOfBodies& cells, double tolerance, HullFilters filters,
             const Execution& execution) {
  Search search;
  search.rest.figures.tolerance = tolerance;
  const std::vector<Overlap> overlaps = find_overlaps(bodies, cells, execution);
  for (const Overlap& overlap : overlaps) search.see(overlap);
  search.rest.figures.pairs = static_cast<std::uint32_t>(search.deep.size());
  if (filters == HullFilters::kNone) {
    for (const Overlap& overlap : overlaps)
      if (overlap.depth > tolerance) search.leave(overlap.depth);
    search.deep.clear();
  }
  search.rest.filters = make_collision_filters(bodies.size(), search.deep, execution);
  search.rest.trimmed_for_filters = !search.rest.filters.beyond.empty();
  return search;
}

Rest sum_up(Search&& search, const Bodies& bodies, const Execution& execution) {
  Pacer pacer(execution);
  Rest rest = std::move(search.rest);
  RestFigures& figures = rest.figures;
  figures.filtered = static_cast<std::uint32_t>(search.deep.size());
  figures.systems = rest.filters.systems;
  for (const BodyPair& pair : search.deep) {
    pacer.step();
    rest.filtered.push_back({bodies.fragments[pair.a]->id, bodies.fragments[pair.b]->id});
  }
  for (const FragmentHulls* hulls : bodies.hulls) {
    pacer.step();
    figures.trimmed += hulls->least_share < 1;
    figures.least_share = std::fmin(figures.least_share, hulls->least_share);
  }
  return rest;
}

}  // namespace

Rest find_rest(const Bodies& bodies, const CellsOfBodies& cells, double tolerance, HullFilters filters,
               const Execution& execution) {
  return sum_up(begin(bodies, cells, tolerance, filters, execution), bodies, execution);
}

Rest bring_to_rest(const FragmentSet& set, CollisionHulls& hulls, const CellsOfBodies& cells,
                   double tolerance, HullFilters filters, const Execution& execution) {
  const Bodies bodies = bodies_of(set, hulls, execution);
  Search search = begin(bodies, cells, tolerance, filters, execution);
  // Each round has fewer pairs, so the loop ends.
  while (!search.rest.filters.beyond.empty()) {
    std::vector<char> is_cut(bodies.size(), 0);
    const std::vector<BodyPair> beyond = std::move(search.rest.filters.beyond);
    for (const BodyPair& pair : beyond) {
      is_cut[pair.a] = is_cut[pair.b] = 1;
      const double depth = trim_apart(pair, bodies, set, hulls, tolerance, execution);
      if (depth > tolerance)
        search.leave(depth);
      else
        search.see(pair, depth);
    }
    for (const BodyPair& pair : std::exchange(search.deep, {})) {
      if (std::binary_search(beyond.begin(), beyond.end(), pair)) continue;
      if (is_cut[pair.a] || is_cut[pair.b])
        search.see(pair, deepest_overlap(bodies, pair, execution).depth);
      else
        search.deep.push_back(pair);
    }
    search.rest.filters = make_collision_filters(bodies.size(), search.deep, execution);
  }
  return sum_up(std::move(search), bodies, execution);
}

}  // namespace fracture
