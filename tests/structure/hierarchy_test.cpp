// Levels of clusters: each level is a partition of the next one. Clusters are connected and compact, and
// their bonds add up.
#include "common/structure/hierarchy.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <set>

#include "common/base/disjoint_sets.hpp"
#include "common/structure/bond_graph.hpp"
#include "common/structure/clusters.hpp"
#include "tests/structure/seed.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/fractured.hpp"
#include "tests/support/full_tests.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/site_families.hpp"

namespace fracture::test {
namespace {

/// Number of additional pieces of clusters that bonds do not connect: 0 if every cluster is connected.
std::size_t torn_clusters(std::size_t nodes, const std::vector<Bond>& bonds,
                          const std::vector<std::uint32_t>& cluster) {
  DisjointSets sets(nodes);
  for (const Bond& b : bonds)
    if (cluster[b.a] == cluster[b.b]) sets.unite(b.a, b.b);
  std::set<std::uint32_t> clusters(cluster.begin(), cluster.end());
  return sets.set_count() - clusters.size();
}

Fractured levels_of(const Mesh& mesh, std::uint32_t sites, std::vector<std::uint32_t> levels,
                    int threads = 1) {
  FractureParameters p;
  p.pattern = PointsPattern{random_sites(box_of(mesh), sites, kSeed)};
  p.levels = std::move(levels);
  return fracture_mesh(mesh, p, threads);
}

TEST(Clusters, RowOfEightInFourIsPairsOfNeighbors) {
  FractureParameters p;
  const Mesh bar = box({0, 0, 0}, {8, 1, 1});
  p.pattern = PointsPattern{row_of_sites(box_of(bar), 8)};
  const FragmentSet set = fracture_mesh(bar, p).set;
  ASSERT_EQ(set.fragments.size(), 8u);
  EXPECT_EQ(find_clusters(BondGraph::of_fragments(set), 4, {}),
            (std::vector<std::uint32_t>{0, 0, 1, 1, 2, 2, 3, 3}));
  EXPECT_EQ(find_clusters(BondGraph::of_fragments(set), 1, {}), std::vector<std::uint32_t>(8, 0));
  EXPECT_EQ(find_clusters(BondGraph::of_fragments(set), 9, {}),
            (std::vector<std::uint32_t>{0, 1, 2, 3, 4, 5, 6, 7}));
}

TEST(Clusters, MorePartsThanClustersArePutTogetherByPlace) {
  FractureParameters p;
  p.pattern = PointsPattern{{{0, 0, 0}}};
  const FragmentSet set = fracture_mesh(cube_field(3), p).set;  // 27 cubes that touch no other
  ASSERT_EQ(set.fragments.size(), 27u);
  const auto cluster = find_clusters(BondGraph::of_fragments(set), 3, {});
  std::map<std::uint32_t, int> size;
  for (const std::uint32_t c : cluster) ++size[c];
  ASSERT_EQ(size.size(), 3u);
  for (const auto& [c, n] : size) EXPECT_NEAR(n, 9, 1) << c;
}

TEST(Hierarchy, EachLevelIsAPartitionOfTheNextAndItsClustersAreConnected) {
  std::size_t input = 0;
  for (const NamedMesh& shape : closed_shapes()) {
    if (!has_turn(input++, 0, 3)) continue;
    SCOPED_TRACE(shape.name);
    const Fractured made = levels_of(shape.mesh, 120, {5, 20, 60});
    const FragmentSet& set = made.set;
    const Hierarchy& h = made.hierarchy;
    ASSERT_EQ(h.levels.size(), 3u);
    const std::vector<std::uint32_t> component = BondGraph::of_fragments(set).components();
    const std::size_t parts = std::set<std::uint32_t>(component.begin(), component.end()).size();
    ASSERT_EQ(h.cluster_of_fragment.size(), set.fragments.size());
    std::vector<std::uint32_t> group = h.cluster_of_fragment;  // each fragment's cluster, finest level first
    const std::vector<std::uint32_t> counts{5, 20, 60};
    for (std::size_t level = 3; level-- > 0;) {
      const ClusterLevel& here = h.levels[level];
      EXPECT_EQ(here.clusters.size(), std::min<std::size_t>(counts[level], set.fragments.size()));
      if (parts <= counts[level]) {
        EXPECT_EQ(torn_clusters(set.fragments.size(), set.bonds, group), 0u) << "level " << level;
      }
      std::vector<double> volume(here.clusters.size(), 0);
      std::vector<std::uint32_t> fragments(here.clusters.size(), 0);
      for (std::size_t f = 0; f < group.size(); ++f) {
        volume[group[f]] += set.fragments[f].mass.volume;
        ++fragments[group[f]];
      }
      double area = 0, between = 0;
      for (const Bond& b : here.bonds) area += b.area;
      for (const Bond& b : set.bonds) between += group[b.a] != group[b.b] ? b.area : 0;
      EXPECT_NEAR(area, between, 1e-9 * (1 + between));
      std::set<std::uint64_t> ids;
      for (std::size_t c = 0; c < here.clusters.size(); ++c) {
        EXPECT_NEAR(here.clusters[c].volume, volume[c], 1e-12 + 1e-9 * volume[c]);
        EXPECT_EQ(here.clusters[c].fragments, fragments[c]);
        EXPECT_GT(fragments[c], 0u);
        EXPECT_EQ(here.clusters[c].parent == kNoIndex, level == 0);
        ids.insert(here.clusters[c].id);
      }
      EXPECT_EQ(ids.size(), here.clusters.size());
      if (level == 0) break;
      for (std::uint32_t& g : group) g = here.clusters[g].parent;
    }
  }
}

TEST(Hierarchy, ClustersAreCompactAndOfSimilarVolume) {
  const Fractured made = levels_of(cube(), 400, {8});
  const FragmentSet& set = made.set;
  const ClusterLevel& level = made.hierarchy.levels[0];
  ASSERT_EQ(level.clusters.size(), 8u);
  for (const Cluster& c : level.clusters) {
    EXPECT_GT(c.volume, 0.4 / 8);
    EXPECT_LT(c.volume, 2.0 / 8);
  }
  // The mean distance of a cluster's volume from its centre: 0.24 in a cube of half the size, 0.48 in the
  // whole cube.
  double moment = 0, volume = 0;
  for (std::size_t f = 0; f < set.fragments.size(); ++f) {
    const MassProperties& m = set.fragments[f].mass;
    moment += m.volume *
              length(m.center_of_mass - level.clusters[made.hierarchy.cluster_of_fragment[f]].center_of_mass);
    volume += m.volume;
  }
  EXPECT_LT(moment / volume, 0.3);
}

TEST(Hierarchy, SameForAnyNumberOfThreadsAndFromRunToRun) {
  const Mesh mesh = torus(24, 12);
  const Fractured a = levels_of(mesh, 150, {4, 16, 64}, 1), b = levels_of(mesh, 150, {4, 16, 64}, 2);
  EXPECT_EQ(a.hierarchy.cluster_of_fragment, b.hierarchy.cluster_of_fragment);
  for (std::size_t level = 0; level < 3; ++level)
    for (std::size_t c = 0; c < a.hierarchy.levels[level].clusters.size(); ++c)
      EXPECT_EQ(a.hierarchy.levels[level].clusters[c].id, b.hierarchy.levels[level].clusters[c].id);
}

TEST(Hierarchy, BondNormalsPointFromAToB) {
  const Fractured made = levels_of(box({0, 0, 0}, {4, 1, 1}), 60, {2, 8});
  for (const ClusterLevel& level : made.hierarchy.levels)
    for (const Bond& b : level.bonds) {
      EXPECT_LT(b.a, b.b);
      EXPECT_NEAR(length(b.normal), 1, 1e-12);
    }
  const ClusterLevel& halves = made.hierarchy.levels[0];
  ASSERT_EQ(halves.bonds.size(), 1u);
  EXPECT_GT(
      dot(halves.bonds[0].normal, halves.clusters[1].center_of_mass - halves.clusters[0].center_of_mass), 0);
}

TEST(Hierarchy, NoLevelsNoClusters) {
  const Fractured made = levels_of(cube(), 20, {});
  EXPECT_TRUE(made.hierarchy.levels.empty());
  EXPECT_TRUE(made.hierarchy.cluster_of_fragment.empty());
}

}  // namespace
}  // namespace fracture::test
