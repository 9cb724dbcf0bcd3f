#include "common/solid/weld.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "common/base/random.hpp"
#include "common/solid/near_points.hpp"
#include "tests/support/poll_gaps.hpp"
#include "tests/support/repetitions.hpp"

namespace fracture::solid_detail {
namespace {

using test::kMostPollGapMs;
using test::PollGaps;

Triangle triangle(int a, int b, int c) { return {VertexId{a}, VertexId{b}, VertexId{c}}; }

Mesh triangles_of(std::vector<Vec3f> positions) {
  Mesh mesh;
  mesh.positions = std::move(positions);
  for (std::uint32_t i = 0; i + 2 < mesh.positions.size(); i += 3)
    mesh.triangles.push_back({i, i + 1, i + 2});
  return mesh;
}

/// Positions in the plane z = 0 that collide in one slot of a table of up to 2^30. The hash is a fixed mix of
/// the coordinates' bits, x | y << 32 times 0x9e3779b97f4a7c15. The positions are computed by undoing its
/// steps.
std::vector<Vec3f> colliding_positions(std::size_t count) {
  const auto inverse = [](std::uint64_t odd) {  // modulo 2^64 (Newton)
    std::uint64_t x = odd;
    for (int i = 0; i < 6; ++i) x *= 2 - odd * x;
    return x;
  };
  const std::uint64_t first = inverse(0x9e3779b97f4a7c15ull), second = inverse(0xbf58476d1ce4e5b9ull);
  std::vector<Vec3f> positions;
  for (std::uint64_t k = 1; positions.size() < count; ++k) {
    std::uint64_t h = k << 30;
    h = (h ^ (h >> 32)) * second;
    std::uint64_t bits = h;
    for (int i = 0; i < 3; ++i) bits = h ^ (bits >> 29);
    bits *= first;
    const Vec3f p{std::bit_cast<float>(static_cast<std::uint32_t>(bits)),
                  std::bit_cast<float>(static_cast<std::uint32_t>(bits >> 32)), 0};
    if (std::fabs(p.x) <= 1e11f && std::fabs(p.y) <= 1e11f) positions.push_back(p);  // none is NaN
  }
  return positions;
}

TEST(WeldExact, PositionsThatCollideInAFixedHashAreNoMoreWorkThanOthers) {
  constexpr std::size_t kCount = 60'000;
  const Mesh mesh = triangles_of(colliding_positions(kCount));
  const test::Polled welded = test::polled([&](const Execution& execution) {
    SolidReport report;
    const Expected<Surface> surface = weld_exact(mesh, report, execution);
    ASSERT_TRUE(surface);
    EXPECT_EQ(surface->positions.size(), kCount);
  });
  EXPECT_LT(welded.polls, 100u) << "each poll stands for some thousand looks into the table";
  EXPECT_LT(welded.longest_ms, kMostPollGapMs);
}

TEST(WeldExact, NumbersVerticesInTheOrderOfTheirFirstUse) {
  const Mesh mesh = triangles_of({{5, 0, 0}, {1, 0, 0}, {3, 0, 0}, {1, 0, 0}, {5, 0, 0}, {2, 0, 0}});
  SolidReport report;
  const Expected<Surface> surface = weld_exact(mesh, report, {});
  ASSERT_TRUE(surface);
  EXPECT_EQ(surface->positions, (std::vector<Vec3f>{{5, 0, 0}, {1, 0, 0}, {3, 0, 0}, {2, 0, 0}}));
  EXPECT_EQ(surface->triangles, (std::vector<Triangle>{triangle(0, 1, 2), triangle(1, 0, 3)}));
  EXPECT_EQ(report.welded, 2u);
}

// -- points closer than a tolerance

std::vector<std::uint32_t> roots(DisjointSets sets) {
  std::vector<std::uint32_t> all(sets.size());
  for (std::uint32_t i = 0; i < all.size(); ++i) all[i] = sets.find(i);
  return all;
}

void expect_same_as_all_pairs(const std::vector<Vec3f>& points, double tolerance) {
  std::vector<VertexId> members(points.size());
  for (std::uint32_t i = 0; i < members.size(); ++i) members[i] = VertexId{i};
  DisjointSets expected(points.size()), sets(points.size());
  for (std::uint32_t i = 0; i < points.size(); ++i)
    for (std::uint32_t j = 0; j < i; ++j)
      if (length(to_double(points[i]) - to_double(points[j])) <= tolerance) expected.unite(i, j);
  unite_near(points, members, tolerance, sets, {});
  ASSERT_EQ(roots(sets), roots(expected)) << "tolerance " << tolerance;
}

TEST(UniteNear, IsThatOfAllPairs) {
  for (std::uint64_t seed = 0; seed < static_cast<std::uint64_t>(test::repetitions(200)); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    const std::uint64_t count = 2 + random.below(400), kind = random.below(4);
    const double far = random.below(2) == 0 ? 0 : 1e4,
                 scale = std::ldexp(1.0, static_cast<int>(random.below(20)) - 10);
    std::vector<Vec3f> points;
    for (std::uint64_t i = 0; i < count; ++i) {
      Vec3d p;
      for (int a = 0; a < 3; ++a)  // a lattice has many pairs at exactly the tolerance
        p[a] = kind == 0 ? static_cast<double>(random.below(8))
                         : random.uniform() * (kind == static_cast<unsigned>(a) ? 0.01 : 4);
      p = scale * (p + Vec3d{far, 0, far});
      const Vec3f q{static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
      if (std::find(points.begin(), points.end(), q) == points.end()) points.push_back(q);
    }
    for (const double tolerance : {0.05, 0.3, 1.0, 1.4, 10.0})
      expect_same_as_all_pairs(points, tolerance * scale);
  }
}

TEST(UniteNear, CrowdedCellsAreComparedByTheirNearestPoints) {
  // Two clouds of a few hundred points in neighbouring cells, at distances around the tolerance.
  for (int step = -3; step <= 3; ++step) {
    SCOPED_TRACE(step);
    Random random(static_cast<std::uint64_t>(step + 10));
    std::vector<Vec3f> points;
    for (int i = 0; i < test::repetitions(600); ++i) {
      const double y = 0.3 * random.uniform(), z = 0.3 * random.uniform(), x = 0.1 * random.uniform();
      points.push_back({static_cast<float>(i % 2 == 0 ? -x : x + 1 + 0.003 * step), static_cast<float>(y),
                        static_cast<float>(z)});
    }
    expect_same_as_all_pairs(points, 1.0);
  }
}

TEST(UniteNear, TolerancesBelowAndFarAboveAllDistances) {
  const std::vector<Vec3f> points{{0, 0, 0}, {1e-45f, 0, 0}, {3e38f, -3e38f, 0}, {1, 2, 3}};
  for (const double tolerance : {1e-320, 1e-46, 1e-44, 1e-30, 1.0, 1e30, 1e39, 1e300})
    expect_same_as_all_pairs(points, tolerance);
}

TEST(UniteNear, FourTimesThePointsWithinOneToleranceAreAboutFourTimesTheWork) {
  const auto polls = [](std::size_t count) {
    Random random(4);
    std::vector<Vec3f> points(count);
    std::vector<VertexId> members(count);
    for (std::uint32_t i = 0; i < count; ++i) {
      members[i] = VertexId{i};
      const double x = random.uniform(), y = random.uniform(), z = random.uniform();
      points[i] = {static_cast<float>(x), static_cast<float>(y), static_cast<float>(1e-3 * z + i % 2 * 4.01)};
    }
    DisjointSets sets(count);
    PollGaps gaps;
    unite_near(points, members, 4, sets, gaps.execution());
    EXPECT_EQ(sets.set_count(), 2u);
    return gaps.polls();
  };
  const std::uint64_t few = polls(50'000), many = polls(200'000);
  EXPECT_GT(few, 20u) << "work is polled";
  EXPECT_LT(many, 6 * few);
}

}  // namespace
}  // namespace fracture::solid_detail
