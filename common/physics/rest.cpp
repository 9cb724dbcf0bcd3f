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

/// A hull before and after a cut.
struct CutHull {
  CollisionHull left;
  double before = 0, after = 0;  ///< m³
  double share() const { return before > 0 ? after / before : 0; }
  void replace(CollisionHull& hull) {
    if (after < before) keep_trimmed(hull, std::move(left), before);
  }
};

struct Cut {
  CutHull a, b;
  double least() const { return std::fmin(a.share(), b.share()); }
};

Cut cut(const Clash& clash, double end_a, double begin_b, const Execution& execution) {
  const auto part = [&](const CollisionHull& hull, const Vec3d& normal, double offset) {
    CutHull made{.left = trimmed(hull, normal, offset, execution),
                 .before = volume_within(hull.points, hull.triangles)};
    made.after = volume_within(made.left.points, made.left.triangles);
    return made;
  };
  return {part(clash.a, clash.normal, end_a - dot(clash.normal, clash.pivot_a)),
          part(clash.b, -1.0 * clash.normal, dot(clash.normal, clash.pivot_b) - begin_b)};
}

/// Trims two bodies until they overlap by at most the tolerance, if possible.
void trim_apart(const BodyPair& pair, const Bodies& bodies, const FragmentSet& set, CollisionHulls& hulls,
                double tolerance, const Execution& execution) {
  const double gap = std::fmin(kHullInset, tolerance);  // less than the inset in small solids
  for (int k = 0; k < kMostCuts; ++k) {
    const Overlap overlap = deepest_overlap(bodies, pair, execution);
    if (overlap.depth <= tolerance) return;
    const Clash clash = clash_of(overlap, set, hulls);
    const double middle = 0.5 * (clash.last_a + clash.first_b);
    std::array<Cut, 3> cuts{cut(clash, clash.first_b - gap, clash.first_b, execution),
                            cut(clash, clash.last_a, clash.last_a + gap, execution),
                            cut(clash, middle - 0.5 * gap, middle + 0.5 * gap, execution)};
    Cut& best = *std::max_element(cuts.begin(), cuts.end(),
                                  [](const Cut& x, const Cut& y) { return x.least() < y.least(); });
    if (!(best.least() > 0)) return;
    best.a.replace(clash.a);
    best.b.replace(clash.b);
  }
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

/// Trims the pairs. A trim may change what the next one with the same body finds. So each pair waits for the earlier pairs
/// with one of its bodies, and the results are those of one pair after the other. Pairs that wait for equally many others
/// have no body in common: they are trimmed in parallel.
void trim_all_apart(std::span<const BodyPair> pairs, const Bodies& bodies, const FragmentSet& set,
                    CollisionHulls& hulls, double tolerance, const Execution& execution) {
  Pacer pacer(execution);
  std::vector<std::uint32_t> next_round(bodies.size(), 0);  // per body: the first round in which it is free
  std::vector<std::vector<BodyPair>> rounds;
  for (const BodyPair& pair : pairs) {
    pacer.step();
    const std::uint32_t round = std::max(next_round[pair.a], next_round[pair.b]);
    next_round[pair.a] = next_round[pair.b] = round + 1;
    if (round == rounds.size()) rounds.emplace_back();
    rounds[round].push_back(pair);
  }
  for (const std::vector<BodyPair>& round : rounds)
    parallel_for(execution, round.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k)
        trim_apart(round[k], bodies, set, hulls, tolerance, execution);
    });
}

/// An unfinished result, and the pairs that need filters, ascending.
struct Search {
  Rest rest;
  std::vector<BodyPair> deep;

  /// Counts the pairs that may collide, and their deepest overlap.
  void count_left(const std::vector<Overlap>& overlaps) {
    RestFigures& figures = rest.figures;
    for (const Overlap& overlap : overlaps) {
      if (std::binary_search(deep.begin(), deep.end(), overlap.pair)) continue;
      figures.left += overlap.depth > figures.tolerance;
      figures.deepest = std::fmax(figures.deepest, overlap.depth);
    }
  }
};

Search begin(const Bodies& bodies, const CellsOfBodies& cells, double tolerance, HullFilters filters,
             const Execution& execution) {
  Search search;
  search.rest.figures.tolerance = tolerance;
  const std::vector<Overlap> overlaps = find_overlaps(bodies, cells, execution);
  for (const Overlap& overlap : overlaps)
    if (overlap.depth > tolerance) search.deep.push_back(overlap.pair);
  search.rest.figures.pairs = static_cast<std::uint32_t>(search.deep.size());
  if (filters == HullFilters::kNone) search.deep.clear();
  search.count_left(overlaps);
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
    const double share = least_share(hulls->hulls);
    figures.trimmed += share < 1;
    figures.least_share = std::fmin(figures.least_share, share);
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
    for (const BodyPair& pair : beyond) is_cut[pair.a] = is_cut[pair.b] = 1;
    trim_all_apart(beyond, bodies, set, hulls, tolerance, execution);
    std::vector<char> is_deep(search.deep.size(), 1);
    parallel_for(execution, is_deep.size(), 16, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) {
        const BodyPair& pair = search.deep[k];
        if (std::binary_search(beyond.begin(), beyond.end(), pair))
          is_deep[k] = 0;
        else if (is_cut[pair.a] || is_cut[pair.b])
          is_deep[k] = deepest_overlap(bodies, pair, execution).depth > tolerance;
      }
    });
    std::size_t left = 0;
    for (std::size_t k = 0; k < is_deep.size(); ++k)
      if (is_deep[k]) search.deep[left++] = search.deep[k];
    search.deep.resize(left);
    search.rest.filters = make_collision_filters(bodies.size(), search.deep, execution);
  }
  if (search.rest.trimmed_for_filters) {
    // A body that was measured may have been trimmed later, because of another one.
    search.rest.figures.left = 0;
    search.rest.figures.deepest = 0;
    search.count_left(find_overlaps(bodies, cells, execution));
  }
  return sum_up(std::move(search), bodies, execution);
}

}  // namespace fracture
