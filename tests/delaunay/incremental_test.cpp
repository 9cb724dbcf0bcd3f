#include "common/delaunay/incremental.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "common/delaunay/reference/reference_delaunay.hpp"
#include "common/delaunay/spatial_order.hpp"
#include "tests/bench/delaunay_workloads.hpp"
#include "tests/delaunay/point_families.hpp"

namespace fracture {
namespace {

using test::point_families;
using test::PointFamily;
using Status = IncrementalDelaunay::Status;

enum class Method { kCavity, kFlips };
IncrementalDelaunay::Insertion insert(ReferenceDelaunay& d, const Vec3d& p, Method method) {
  return method == Method::kFlips ? d.insert_by_flips(p) : d.insert(p);
}

using Key = std::array<std::array<double, 3>, 4>;
std::vector<Key> tet_set(const IncrementalDelaunay& d) {
  std::vector<Key> keys;
  d.for_each_tet([&](const std::array<TetVertexId, 4>& v) {
    Key key;
    for (int k = 0; k < 4; ++k) key[k] = {d.position(v[k]).x, d.position(v[k]).y, d.position(v[k]).z};
    std::sort(key.begin(), key.end());
    keys.push_back(key);
  });
  std::sort(keys.begin(), keys.end());
  return keys;
}

BigTetrahedron big_of(const std::vector<Vec3d>& points) {
  Box box;
  for (const Vec3d& p : points) box.add(p);
  return big_tetrahedron(box);
}

ReferenceDelaunay build(const std::vector<Vec3d>& points, const BigTetrahedron& big, Method method) {
  ReferenceDelaunay d(big);
  for (const Vec3d& p : points) insert(d, p, method);
  return d;
}

TEST(IncrementalDelaunay, IsValidAfterEveryInsertionByEitherMethod) {
  for (const Method method : {Method::kCavity, Method::kFlips})
    for (const PointFamily& family : point_families()) {
      const std::vector<Vec3d> points = family.make(64, 5);
      ReferenceDelaunay d(big_of(points));
      for (const Vec3d& p : points) {
        insert(d, p, method);
        const auto error = d.validate();
        ASSERT_FALSE(error.has_value()) << family.name << ", " << d.site_count() << " sites: " << *error;
      }
    }
}

TEST(IncrementalDelaunay, IsValidOnEveryInputOfTheBenchmarkUpTo100kSites) {
  for (const std::string& name : bench::workload_names()) {
    if (name == "random_1M") continue;
    const std::vector<Vec3d> points = bench::make_workload(name).points;
    IncrementalDelaunay d(big_of(points));
    for (const std::uint32_t i : spatial_order(points))
      ASSERT_EQ(d.insert(points[i]).status, Status::kInserted);
    const auto error = d.validate();
    EXPECT_FALSE(error.has_value()) << name << ": " << *error;
  }
}

TEST(IncrementalDelaunay, FlipsAndCavityGiveTheSameTetrahedra) {
  for (const PointFamily& family : point_families())
    for (const std::uint32_t n : {27u, 343u, 1000u}) {
      const std::vector<Vec3d> points = family.make(n, 31);
      const BigTetrahedron big = big_of(points);
      const ReferenceDelaunay flips = build(points, big, Method::kFlips);
      ASSERT_FALSE(flips.validate().has_value()) << family.name << ": " << *flips.validate();
      ASSERT_EQ(tet_set(flips), tet_set(build(points, big, Method::kCavity))) << family.name;
    }
}

TEST(IncrementalDelaunay, TheFlipMethodUsesEveryFlip) {
  const std::vector<Vec3d> points = test::lattice(1000, 3, 1);
  const ReferenceDelaunay d = build(points, big_of(points), Method::kFlips);
  EXPECT_GT(d.flips().flip14, 0u);
  EXPECT_GT(d.flips().flip26, 0u);
  EXPECT_GT(d.flips().flip_n2n, 0u);
  EXPECT_GT(d.flips().flip23, 0u);
  EXPECT_GT(d.flips().flip32, 0u);
  EXPECT_GT(d.flips().flip44, 0u);
  EXPECT_GT(d.counters().in_sphere.ties, 0u);
}

TEST(IncrementalDelaunay, WholeListsGiveTheSameResultByFlips) {
  for (const PointFamily& family : point_families()) {
    SCOPED_TRACE(family.name);
    std::vector<Vec3d> points = family.make(200, 12);
    Box box;
    for (const Vec3d& p : points) box.add(p);
    points.push_back(points[7]);                                              // a duplicate
    points.push_back(box.max + 50.0 * (box.max - box.min) + Vec3d{1, 1, 1});  // owns no point of the box
    FlipCounts counts;
    Expected<Tetrahedralization> cavity = tetrahedralize(points, box, {}),
                                 flips = tetrahedralize_by_flips(points, box, {}, &counts);
    ASSERT_TRUE(cavity && flips);
    EXPECT_GT(counts.flip14 + counts.flip26 + counts.flip_n2n, 0u);
    EXPECT_EQ(flips->duplicates_merged, cavity->duplicates_merged);
    EXPECT_EQ(flips->far_sites_dropped, cavity->far_sites_dropped);
    EXPECT_EQ(flips->site_of_input, cavity->site_of_input);
    canonicalize(*cavity);
    canonicalize(*flips);
    EXPECT_EQ(flips->points, cavity->points);
    EXPECT_EQ(flips->tet_of_site, cavity->tet_of_site);
    ASSERT_EQ(flips->tets.size(), cavity->tets.size());
    for (std::size_t i = 0; i < flips->tets.size(); ++i) {
      EXPECT_EQ(flips->tets[i].v, cavity->tets[i].v);
      EXPECT_EQ(flips->tets[i].n, cavity->tets[i].n);
    }
  }
  const std::vector<Vec3d> nowhere{{std::nan(""), 0, 0}};
  EXPECT_EQ(tetrahedralize_by_flips(nowhere, {}, {}).error().pointer, "/points/0");
}

TEST(IncrementalDelaunay, CanonicalNumberingDoesNotDependOnMethodOrHistory) {
  for (const PointFamily& family : point_families()) {
    const std::vector<Vec3d> points = family.make(200, 8);
    const BigTetrahedron big = big_of(points);
    const ReferenceDelaunay a = build(points, big, Method::kCavity);
    ReferenceDelaunay b = build(points, big, Method::kFlips);
    b.remove(TetVertexId{4});  // and put it back: the same vertex id
    b.insert(points[0]);
    Tetrahedralization ta = a.snapshot(), tb = b.snapshot();
    canonicalize(ta);
    canonicalize(tb);
    ASSERT_EQ(ta.points, tb.points) << family.name;
    ASSERT_EQ(ta.tet_of_site, tb.tet_of_site) << family.name;
    ASSERT_EQ(ta.tets.size(), tb.tets.size());
    for (std::size_t i = 0; i < ta.tets.size(); ++i) {
      ASSERT_EQ(ta.tets[i].v, tb.tets[i].v) << family.name;
      ASSERT_EQ(ta.tets[i].n, tb.tets[i].n) << family.name;
    }
  }
}

// Uses so many tetrahedra that those already read are released, and that their storage has holes.
TEST(IncrementalDelaunay, TheLastSnapshotIsLikeAnyOther) {
  const std::vector<Vec3d> points = test::random_cube(165'000, 5);
  IncrementalDelaunay delaunay(big_of(points));
  std::vector<SiteId> site_of_vertex(4, kNoSite);
  for (const std::uint32_t k : spatial_order(points, {})) {
    delaunay.insert(points[k]);
    site_of_vertex.push_back(SiteId{k});
  }
  const Tetrahedralization copy = delaunay.snapshot(site_of_vertex),
                           last = delaunay.take_snapshot(site_of_vertex);
  ASSERT_GT(copy.tets.size(), IncrementalDelaunay::kManyTets) << "none is forgotten";
  EXPECT_EQ(copy.points, last.points);
  EXPECT_EQ(copy.tet_of_site, last.tet_of_site);
  ASSERT_EQ(copy.tets.size(), last.tets.size());
  for (std::size_t i = 0; i < copy.tets.size(); ++i) {
    ASSERT_EQ(copy.tets[i].v, last.tets[i].v) << i;
    ASSERT_EQ(copy.tets[i].n, last.tets[i].n) << i;
  }
}

// Runs 10,000 operations over all families, with validate() after each. Now and then it compares the
// tetrahedra with a set built from scratch.
TEST(IncrementalDelaunay, RandomInsertionsAndRemovalsKeepItValidAndEqualToARebuild) {
  const std::vector<PointFamily> families = point_families();
  const int operations = 10'000 / static_cast<int>(families.size()) + 1;
  for (const PointFamily& family : families) {
    SCOPED_TRACE(family.name);
    const std::vector<Vec3d> pool = family.make(60, 77);
    const BigTetrahedron big = big_of(pool);
    ReferenceDelaunay d(big);
    Random random(99);
    std::vector<TetVertexId> live;
    for (int i = 0; i < operations; ++i) {
      // The size varies between empty and about 40.
      const std::uint64_t target = (i / 40) % 2 ? 8 : 40;
      if (live.empty() || random.below(2 * target) >= live.size()) {
        const auto [status, v] =
            insert(d, pool[random.below(pool.size())], i % 3 == 0 ? Method::kFlips : Method::kCavity);
        const bool known = std::find(live.begin(), live.end(), v) != live.end();
        ASSERT_EQ(status, known ? Status::kDuplicate : Status::kInserted);
        if (!known) live.push_back(v);
      } else {
        const std::size_t k = random.below(live.size());
        d.remove(live[k]);
        live.erase(live.begin() + static_cast<std::ptrdiff_t>(k));
      }
      ASSERT_EQ(d.site_count(), live.size());
      const auto error = d.validate();
      ASSERT_FALSE(error.has_value()) << "operation " << i << ": " << *error;
      if (i % 20 == 0) {
        std::vector<Vec3d> points;
        for (const TetVertexId v : live) points.push_back(d.position(v));
        ASSERT_EQ(tet_set(d), tet_set(build(points, big, Method::kCavity))) << "operation " << i;
      }
    }
  }
}

TEST(IncrementalDelaunay, RemovingEverySiteLeavesTheBigTetrahedron) {
  for (const PointFamily& family : point_families()) {
    const std::vector<Vec3d> points = family.make(300, 4);
    ReferenceDelaunay d = build(points, big_of(points), Method::kCavity);
    std::vector<TetVertexId> live;
    for (const TetVertexId v : ids<TetVertexId>(4, d.vertex_end())) live.push_back(v);
    Random random(1);
    shuffle(live, random);
    for (const TetVertexId v : live) d.remove(v);
    EXPECT_EQ(d.tet_count(), 1u) << family.name;
    EXPECT_FALSE(d.validate().has_value()) << family.name;
  }
}

TEST(IncrementalDelaunay, RemovesAVertexOfVeryHighDegree) {
  std::vector<Vec3d> points = point_families()[4].make(1000, 1);  // cospherical
  ASSERT_EQ(point_families()[4].name, "cospherical");
  const BigTetrahedron big = big_of(points);
  const auto expected = tet_set(build(points, big, Method::kCavity));
  points.push_back({0, 0, 0});
  ReferenceDelaunay d = build(points, big, Method::kCavity);
  d.remove(TetVertexId{d.vertex_end() - 1});
  EXPECT_FALSE(d.validate().has_value());
  EXPECT_EQ(tet_set(d), expected);
}

TEST(IncrementalDelaunay, RefusesPointsOutsideTheDomainAndRemovalOfCorners) {
  const std::vector<Vec3d> points = test::random_cube(10, 1);
  ReferenceDelaunay d = build(points, big_of(points), Method::kCavity);
  const auto before = tet_set(d);
  EXPECT_EQ(d.insert({2, 0, 0}).status, Status::kOutsideDomain);
  EXPECT_EQ(d.insert_by_flips({2, 0, 0}).status, Status::kOutsideDomain);
  EXPECT_EQ(d.insert({std::nan(""), 0, 0}).status, Status::kOutsideDomain);
  EXPECT_THROW(d.remove(TetVertexId{2}), InternalError);
  EXPECT_THROW(d.remove(TetVertexId{400}), InternalError);
  EXPECT_EQ(tet_set(d), before);
}

TEST(BigTetrahedron, KeepsItsCornersOnTheLatticeOfTheSitesAndFarFromThem) {
  for (const PointFamily& family : point_families())
    for (const std::uint32_t n : {1u, 2u, 100u}) {
      Box box;
      for (const Vec3d& p : family.make(n, 6)) box.add(p);
      const BigTetrahedron big = big_tetrahedron(box);
      const Vec3d size = box.size();
      for (const Vec3d& c : big.corners())
        for (int a = 0; a < 3; ++a) {
          const double away = std::max(c[a] - box.max[a], box.min[a] - c[a]);
          EXPECT_GT(away, std::max({size.x, size.y, size.z})) << family.name;
          EXPECT_EQ(std::fabs(c[a] - big.center[a]), big.half);
        }
    }
  Box lattice;  // 21 bits wide, anywhere: the corners need two more bits and no finer step
  lattice.add(Vec3d{-12345, 777, 0});
  lattice.add(Vec3d{-12345 + 2097151.0, 2000000, 999});
  for (const Vec3d& c : big_tetrahedron(lattice).corners())
    for (int a = 0; a < 3; ++a) {
      EXPECT_EQ(c[a], std::nearbyint(c[a]));
      EXPECT_LT(std::fabs(c[a]), 0x1p23);
    }
}

}  // namespace
}  // namespace fracture
