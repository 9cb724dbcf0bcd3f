// Several threads prepare solids, each with its own vertices, tables or blocks of triangles. The solid does
// not depend on that.
#include <gtest/gtest.h>

#include <bit>
#include <limits>
#include <map>

#include "common/base/random.hpp"
#include "common/solid/edges.hpp"
#include "common/solid/same_positions.hpp"
#include "common/solid/shells.hpp"
#include "common/solid/solid.hpp"
#include "common/solid/weld.hpp"
#include "tests/support/full_tests.hpp"
#include "tests/support/poll_gaps.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::solid_detail {
namespace {

Execution with_threads(int threads) {
  Execution execution;
  execution.threads = threads;
  return execution;
}

/// The mesh with its triangles in another order, so that none is near its neighbours.
Mesh shuffled(Mesh mesh, std::uint64_t seed) {
  Random random(seed);
  for (std::size_t t = mesh.triangles.size(); t > 1; --t)
    std::swap(mesh.triangles[t - 1], mesh.triangles[random.below(t)]);
  return mesh;
}

std::vector<test::NamedMesh> large_meshes() {
  const Mesh sphere = test::sphere_with(150'000);
  return {{"sphere", sphere},
          {"shuffled sphere", shuffled(sphere, 1)},
          {"three wedges a triangle", test::unindexed(shuffled(test::sphere_with(60'000), 2))},
          {"seams", test::sphere_with_seams(200, 300)},
          {"cubes", test::cube_field(22)},
          {"shuffled cubes, half of them inside out",
           shuffled(test::joined({test::cube_field(16),
                                  test::reversed(test::translated(test::cube_field(16), {40, 0, 0}))}),
                    3)},
          {"sponge", test::menger_sponge(3)},
          {"shells in shells", shuffled(test::nested_spheres(8, 10'000, 0.1), 4)},
          {"touching bodies",
           test::joined({sphere, test::two_cubes_sharing_an_edge(), test::two_cubes_sharing_a_face(),
                         test::two_cubes_sharing_a_vertex()})},
          {"open", test::joined({sphere, test::cube_without({1, 4})})}};
}

void expect_same(const Solid& a, const Solid& b) {
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_EQ(a.triangles, b.triangles);
  EXPECT_EQ(a.wedges, b.wedges);
  EXPECT_EQ(a.material, b.material);
  EXPECT_EQ(a.edges, b.edges);
  EXPECT_EQ(a.edge_vertices, b.edge_vertices);
  EXPECT_EQ(a.shell, b.shell);
  EXPECT_EQ(a.part, b.part);
  EXPECT_EQ(a.layers, b.layers);
  EXPECT_EQ(a.box.min, b.box.min);
  EXPECT_EQ(a.box.max, b.box.max);
  EXPECT_EQ(a.report, b.report);
  ASSERT_EQ(a.parts.size(), b.parts.size());
  for (std::size_t p = 0; p < a.parts.size(); ++p) {
    EXPECT_EQ(a.parts[p].shells, b.parts[p].shells);
    EXPECT_EQ(a.parts[p].volume, b.parts[p].volume);
    EXPECT_EQ(a.parts[p].box.min, b.parts[p].box.min);
    EXPECT_EQ(a.parts[p].box.max, b.parts[p].box.max);
  }
}

TEST(PrepareThreads, SolidsAreTheSameForEveryNumberOfThreads) {
  std::size_t input = 0;
  for (test::NamedMesh& named : large_meshes()) {
    ++input;
    SCOPED_TRACE(named.name);
    const auto mesh = std::make_shared<const Mesh>(std::move(named.mesh));
    const Expected<Solid> alone = make_solid(mesh, {}, {});
    ASSERT_TRUE(alone);
    alone->validate();
    std::size_t turn = 0;
    for (const int threads : {2, 3, 7}) {
      if (!test::has_turn(input, turn++, 3)) continue;
      SCOPED_TRACE(threads);
      const Expected<Solid> solid = make_solid(mesh, {}, with_threads(threads));
      ASSERT_TRUE(solid);
      expect_same(*alone, *solid);
    }
  }
}

TEST(PrepareThreads, RefusalsAreTheSameForEveryNumberOfThreads) {
  Mesh mesh = test::sphere_with(100'000);
  mesh.positions[30'000].y = std::numeric_limits<float>::quiet_NaN();
  mesh.positions[20'000].x = std::numeric_limits<float>::infinity();
  for (const int threads : {1, 2, 3, 7}) {
    SolidReport report;
    const Expected<Surface> surface = weld_exact(mesh, report, with_threads(threads));
    ASSERT_FALSE(surface);
    EXPECT_EQ(surface.error().code, ErrorCode::kNotFinite);
    EXPECT_NE(surface.error().detail.find("Vertex 20000 "), std::string::npos) << surface.error().detail;
  }
}

// -- the same positions

std::vector<std::uint32_t> first_of_same_by_map(const std::vector<Vec3f>& positions) {
  std::map<std::array<std::uint32_t, 3>, std::uint32_t> seen;
  std::vector<std::uint32_t> first;
  for (const Vec3f& position : positions) {
    const Vec3f p = with_one_zero(position);
    const std::array<std::uint32_t, 3> bits{std::bit_cast<std::uint32_t>(p.x),
                                            std::bit_cast<std::uint32_t>(p.y),
                                            std::bit_cast<std::uint32_t>(p.z)};
    first.push_back(seen.try_emplace(bits, static_cast<std::uint32_t>(first.size())).first->second);
  }
  return first;
}

void expect_lowest_of_same(const std::vector<Vec3f>& positions) {
  const std::vector<std::uint32_t> expected = first_of_same_by_map(positions);
  for (const int threads : {1, 2, 3, 7}) {
    const auto first = first_of_same(positions, with_threads(threads));
    ASSERT_EQ(std::vector(first.get(), first.get() + positions.size()), expected) << threads << " threads";
  }
}

TEST(FirstOfSame, IsThatOfAMap) {
  for (const std::size_t count : {0, 1, 2, 1000, 16'383, 16'384, 70'000, 300'000}) {
    if (test::short_tests() && count > 100'000) continue;
    SCOPED_TRACE(count);
    Random random(count + 1);
    std::vector<Vec3f> scattered, lattice;
    const auto coordinate = [&] { return static_cast<float>(random.uniform() - 0.5); };
    const auto whole = [&] { return static_cast<float>(static_cast<int>(random.below(41)) - 20); };
    for (std::size_t i = 0; i < count; ++i) {
      const float x = coordinate(), y = coordinate(), z = coordinate();
      scattered.push_back(i > 0 && random.below(3) == 0 ? scattered[random.below(i)] : Vec3f{x, y, z});
      const float i_x = whole(), i_y = whole(), i_z = whole();
      lattice.push_back({i_x, i_y, i_z});
    }
    expect_lowest_of_same(scattered);
    expect_lowest_of_same(lattice);
  }
}

TEST(FirstOfSame, ZerosOfBothSignsAreOneAndANaNIsLikeItself) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::vector<Vec3f> positions;
  for (int i = 0; i < 50'000; ++i) {
    positions.push_back({i % 2 == 0 ? 0.0f : -0.0f, i % 3 == 0 ? 0.0f : -0.0f, 1});
    positions.push_back({nan, 0, i % 2 == 0 ? 1.0f : 2.0f});
  }
  expect_lowest_of_same(positions);
}

TEST(FirstOfSame, AllAtOnePlaceAreNoMoreWorkThanOthers) {
  constexpr std::size_t kCount = 1'000'000;
  const auto polls = [](const std::vector<Vec3f>& positions) {
    const test::Polled made =
        test::polled([&](const Execution& execution) { first_of_same(positions, execution); });
    EXPECT_LT(made.longest_ms, test::kMostPollGapMs);
    return made.polls;
  };
  std::vector<Vec3f> apart;
  for (std::size_t i = 0; i < kCount; ++i) apart.push_back({static_cast<float>(i), 0, 0});
  EXPECT_LT(polls(std::vector<Vec3f>(kCount, {1, 2, 3})), 2 * polls(apart));
}

// -- counts, and surfaces that are not manifold

TEST(WeldExact, OnlyWedgesThatTrianglesUseAreCounted) {
  Mesh mesh;  // wedges 0 and 5 are unused, at the places of 1 and 2; 6 is at 3
  mesh.positions = {{1, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.triangles = {{1, 2, 3}, {2, 1, 4}, {6, 2, 4}, {1, 6, 4}};
  for (const bool first_too : {false, true}) {
    if (first_too) mesh.triangles.push_back({0, 4, 2});
    SolidReport report;
    const Expected<Surface> surface = weld_exact(mesh, report, {});
    ASSERT_TRUE(surface);
    EXPECT_EQ(surface->positions, (std::vector<Vec3f>{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}}));
    EXPECT_EQ(report.welded, first_too ? 2u : 1u);
  }
}

TEST(PairClosedManifold, NoEdgeIsUsedTwiceByTwoPairs) {
  const Mesh bodies[] = {test::two_cubes_sharing_an_edge(), test::joined({test::cube(2), test::cube(2)}),
                         test::cube_without({2}), test::klein_bottle()};
  for (const Mesh& mesh : bodies)
    for (const int threads : {1, 2, 7}) {
      SolidReport report;
      Surface surface = weld_exact(mesh, report, {}).value();
      EXPECT_FALSE(pair_closed_manifold(surface, with_threads(threads)));
    }
}

TEST(PairClosedManifold, GluesAsTheSortedTableDoes) {
  std::size_t input = 0;
  for (const Mesh& mesh : {test::sphere_with(150'000), shuffled(test::menger_sponge(2), 5),
                           shuffled(test::torus(400, 200), 6), test::two_cubes_sharing_a_vertex()}) {
    SolidReport report;
    Surface expected = weld_exact(mesh, report, {}).value();
    const bool clean = pair_clean_edges(expected, EdgeTable(expected, {}), {});
    ++input;
    std::size_t turn = 0;
    for (const int threads : {1, 2, 3, 7}) {
      if (!test::has_turn(input, turn++, 2)) continue;
      Surface surface = expected;
      surface.twin.of_triangle.clear();
      ASSERT_EQ(pair_closed_manifold(surface, with_threads(threads)), clean);
      if (!clean) continue;
      ASSERT_EQ(surface.twin, expected.twin) << threads << " threads";
    }
  }
}

}  // namespace
}  // namespace fracture::solid_detail
