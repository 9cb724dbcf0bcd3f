// Work on a hundred thousand bonds, thousands of anchors, and cells with thousands of neighbours. It grows no
// faster than its input, and it can be interrupted anywhere.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stop_token>

#include "common/base/random.hpp"
#include "common/gltf/report_text.hpp"
#include "common/hits/difference.hpp"
#include "common/pipeline/fracture.hpp"
#include "common/structure/anchors.hpp"
#include "common/structure/bond_graph.hpp"
#include "common/structure/clusters.hpp"
#include "common/structure/hierarchy.hpp"
#include "common/structure/support.hpp"
#include "tests/structure/blocks.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/full_tests.hpp"
#include "tests/support/poll_gaps.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::test {
namespace {

/// n x n x n unit cubes without shapes, each bonded to its neighbours.
FragmentSet wall(std::uint32_t n) {
  FragmentSet set;
  for (std::uint32_t k = 0; k < n * n * n; ++k)
    set.fragments.push_back(block(
        7 * k, {static_cast<double>(k % n), static_cast<double>(k / n % n), static_cast<double>(k / n / n)}));
  for (std::uint32_t k = 0; k < n * n * n; ++k) {
    if (k % n + 1 < n) bind(set, k, k + 1, 1);
    if (k / n % n + 1 < n) bind(set, k, k + n, 1);
    if (k / n / n + 1 < n) bind(set, k, k + n * n, 1);
  }
  return set;
}

/// A block in the middle of a ring of n blocks, bonded to all of them. Each block of the ring is bonded to
/// the next.
FragmentSet wheel(std::uint32_t n) {
  FragmentSet set;
  Random random(1);
  set.fragments.push_back(block(0, {0, 0, 0}));
  for (std::uint32_t k = 0; k < n; ++k) {
    const CirclePoint p = circle_point(k, n);
    set.fragments.push_back(block(k + 1, {p.cos, p.sin, 0}));
  }
  for (std::uint32_t k = 0; k < n; ++k) bind(set, 0, k + 1, random.uniform());
  for (std::uint32_t k = 0; k < n; ++k)
    bind(set, std::min(k, (k + 1) % n) + 1, std::max(k, (k + 1) % n) + 1, random.uniform());
  return set;
}

/// The exponent with which the work grows when the input grows by the factor `growth`.
double exponent(std::uint64_t small_work, std::uint64_t large_work, double growth) {
  return std::log(static_cast<double>(large_work) / static_cast<double>(small_work)) / std::log(growth);
}

constexpr std::uint32_t kSide = 33;  // 36 thousand blocks, 105 thousand bonds

TEST(LargeSets, AHierarchyOfManyLevelsCanBeInterruptedAnywhere) {
  const FragmentSet set = wall(kSide);
  Hierarchy h;
  const Polled made = polled([&](const Execution& execution) {
    h = make_hierarchy(set, {2, 5, 20, 100, 500, 2000, 9000, 20'000}, execution);
  });
  EXPECT_LT(made.longest_ms, kMostPollGapMs);
  EXPECT_EQ(h.levels.size(), 8u);
  EXPECT_GT(made.polls, 100u);
}

TEST(LargeSets, SupportCanBeInterruptedAnywhere) {
  FragmentSet set = wall(kSide);
  AnchoredFragments anchored{std::vector<char>(set.fragments.size(), 0), kSide};
  for (std::uint32_t k = 0; k < kSide; ++k) anchored.held[k] = 1;
  SupportOptions options;
  options.density = 100;
  // The iterations take a while, so this run is stopped. The rest is measured with few iterations.
  const Polled stopped = polled([&](const Execution& watched) {
    std::stop_source source;
    Execution execution = watched;
    execution.stop = source.get_token();
    std::uint64_t polls = 0;
    execution.watch = [&] {
      watched.watch();
      if (++polls == 500) source.request_stop();
    };
    EXPECT_THROW(analyze_support(set, anchored, options, execution), Interrupted);
  });
  EXPECT_LT(stopped.longest_ms, kMostPollGapMs);

  FragmentSet row = wall(2);
  row.fragments.resize(1);
  row.bonds.clear();
  for (std::uint32_t k = 1; k < 60'000; ++k) row.fragments.push_back(block(k, {k * 1.0, 0, 0}));
  for (std::uint32_t k = 1; k < 60'000; ++k) bind(row, k - 1, k, 1);
  AnchoredFragments of_row;
  for (const Fragment& f : row.fragments) {
    of_row.held.push_back(f.id % 3 != 0);
    of_row.count += f.id % 3 != 0;
  }
  std::string text;
  const Polled written = polled([&](const Execution& execution) {
    const Support support = analyze_support(row, of_row, options, execution);
    JsonText json(execution);
    write_support(json, row, support);
    text = json.text();
  });
  EXPECT_LT(written.longest_ms, kMostPollGapMs);
  EXPECT_EQ(nlohmann::json::parse(text)["bonds"]["stress"].size(), row.bonds.size());
}

TEST(LargeSets, KeepingWhatChangedCanBeInterruptedAnywhere) {
  FracturedSolid whole;
  whole.set = wall(kSide);
  Delta& delta = whole.delta.emplace();
  for (std::size_t k = 0; k < whole.set.fragments.size(); k += 3)
    delta.changed.push_back(whole.set.fragments[k].id);
  std::reverse(whole.set.bonds.begin(), whole.set.bonds.end());
  FracturedSolid made;
  double longest = HUGE_VAL;
  for (int k = 0; k < 4 && longest >= kMostPollGapMs; ++k) {
    made = whole;
    PollGaps gaps;
    keep_changed(made, gaps.execution());
    longest = std::min(longest, gaps.longest_ms());
  }
  EXPECT_LT(longest, kMostPollGapMs);
  const FragmentSet& set = made.set;
  EXPECT_EQ(set.fragments.size(), delta.changed.size());
  EXPECT_TRUE(std::is_sorted(set.bonds.begin(), set.bonds.end(), [](const Bond& x, const Bond& y) {
    return x.a != y.a ? x.a < y.a : x.b < y.b;
  }));
}

// Formerly, each block of the ring that joined a cluster summed all bonds of the middle block.
TEST(LargeSets, ABlockWithManyBondsIsNotSummedAgainForEachOfThem) {
  std::vector<std::uint64_t> polls;
  for (const std::uint32_t n : {4000u, 16'000u}) {
    const FragmentSet set = wheel(n);
    const BondGraph graph = BondGraph::of_fragments(set);
    std::vector<std::uint32_t> cluster;
    const Polled found =
        polled([&](const Execution& execution) { cluster = find_clusters(graph, 10, execution); });
    polls.push_back(found.polls);
    EXPECT_LT(found.longest_ms, kMostPollGapMs);
    // There are as many clusters as requested, and each is connected.
    std::vector<Bond> within;
    for (const Bond& b : set.bonds)
      if (cluster[b.a] == cluster[b.b]) within.push_back(b);
    std::vector<BondGraph::Node> nodes;
    for (const Fragment& f : set.fragments) nodes.push_back({f.mass.volume, f.mass.center_of_mass});
    std::vector<std::uint32_t> lowest = BondGraph(nodes, within).components();
    std::sort(lowest.begin(), lowest.end());
    lowest.erase(std::unique(lowest.begin(), lowest.end()), lowest.end());
    EXPECT_EQ(lowest.size(), 10u);
    EXPECT_EQ(*std::max_element(cluster.begin(), cluster.end()), 9u);
  }
  EXPECT_LT(exponent(polls[0], polls[1], 4), 1.15);
}

Fragment shape(const Mesh& mesh) {
  Fragment f;
  f.positions = mesh.positions;
  for (const auto& t : mesh.triangles) f.indices.insert(f.indices.end(), t.begin(), t.end());
  return f;
}

constexpr double kRingSide = 2.8;  ///< the longest side of torus()

TEST(LargeSets, AnchorsHoldWhatTheyLieInOrOnHoweverManyThereAre) {
  const Mesh ring = torus(40, 20);
  Random random(5);
  const auto place = [&] {
    return Vec3d{3 * random.uniform() - 1.5, 3 * random.uniform() - 1.5, random.uniform() - 0.5};
  };
  for (int run = 0; run < sized(15, 60); ++run) {
    // There are enough outside points for a search in a tree. The last point decides the result.
    Anchors anchors;
    while (anchors.points.size() < 30)
      if (const Vec3d p = place(); winding_number(ring, p) < 0.5) anchors.points.push_back(p);
    FragmentSet set;
    set.fragments.push_back(shape(ring));
    EXPECT_EQ(find_anchored(set, anchors, kRingSide).count, 0u);
    const Vec3d last = place();
    anchors.points.push_back(last);
    EXPECT_EQ(find_anchored(set, anchors, kRingSide).count, winding_number(ring, last) > 0.5 ? 1u : 0u);
    // On a corner, an edge, a face.
    const auto& t = ring.triangles[static_cast<std::size_t>(random.uniform() * 1600)];
    const Vec3d a = to_double(ring.positions[t[0]]), b = to_double(ring.positions[t[1]]),
                c = to_double(ring.positions[t[2]]);
    for (const Vec3d& on : {a, 0.5 * (a + b), (1.0 / 3) * (a + b + c)}) {
      anchors.points.back() = on;
      EXPECT_EQ(find_anchored(set, anchors, kRingSide).count, 1u);
    }
  }
}

// Points in the hole of a ring. Formerly each was compared with all triangles of the ring.
TEST(LargeSets, AnchorsAreNotComparedWithEveryTriangle) {
  std::vector<std::uint64_t> polls;
  for (const int size : {1, 4}) {
    Anchors anchors;
    Random random(9);
    for (int k = 0; k < 2000 * size; ++k)
      anchors.points.push_back({0.8 * random.uniform() - 0.4, 0.8 * random.uniform() - 0.4, 0.1});
    FragmentSet set;
    set.fragments.push_back(shape(torus(400 * size, 40)));
    const Polled found = polled([&](const Execution& execution) {
      EXPECT_EQ(find_anchored(set, anchors, kRingSide, execution).count, 0u);
    });
    EXPECT_LT(found.longest_ms, kMostPollGapMs);
    polls.push_back(found.polls);
  }
  EXPECT_LT(exponent(polls[0], polls[1], 4), 1.3);  // n log n, and more triangles above a point
}

TEST(LargeSets, AnchorsOfManyVerticesCanBeInterruptedAnywhere) {
  FragmentSet set;
  set.fragments.push_back(shape(torus(3000, 200)));
  Anchors anchors;
  anchors.planes.push_back({{0, 0, 1}, -5});
  anchors.boxes.push_back({{-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1}});
  for (int k = 0; k < 20; ++k) anchors.points.push_back({0.01 * k, 0, 0});
  const Polled found = polled([&](const Execution& execution) {
    EXPECT_EQ(find_anchored(set, anchors, kRingSide, execution).count, 0u);
  });
  EXPECT_LT(found.longest_ms, kMostPollGapMs);
}

/// The cells of a site and of the sites on a sphere around it, which all meet the region.
std::vector<SiteId> cells_around(int others, std::uint64_t& polls, double& gap) {
  std::vector<Vec3d> sites{{0, 0, 0}};
  for (const Vec3f& p : sphere_with(2 * others).positions) sites.push_back(to_double(p));
  Box bounds;
  bounds.add(Vec3d{-2, -2, -2});
  bounds.add(Vec3d{2, 2, 2});
  const Tetrahedralization t = *tetrahedralize(sites, bounds, {});
  const VoronoiDiagram diagram(t, bounds);
  Region region;
  region.radius = 1.2;
  std::vector<SiteId> found;
  const Polled looked =
      polled([&](const Execution& execution) { found = cells_meeting(region, diagram, bounds, execution); });
  gap = looked.longest_ms;
  polls = looked.polls;
  return found;
}

// Formerly each facet of a cell was cut by all bisectors of the cell.
TEST(LargeSets, ACellWithManyNeighborsCutsEachFacetByThoseAroundIt) {
  std::uint64_t small = 0, large = 0;
  double gap = 0;
  const std::size_t few = cells_around(3000, small, gap).size();
  const std::size_t many = cells_around(12'000, large, gap).size();
  EXPECT_LT(gap, kMostPollGapMs);
  EXPECT_GT(few, 2900u);
  EXPECT_GT(many, 11'900u);
  EXPECT_LT(exponent(small, large, static_cast<double>(many) / static_cast<double>(few)), 1.15);
}

}  // namespace
}  // namespace fracture::test
