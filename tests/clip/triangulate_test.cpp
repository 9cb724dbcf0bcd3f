// Triangulation of loops with holes. The topology is always checked: every loop edge occurs once, every other
// edge twice. The geometry is checked if the loops are embedded: no triangle is turned over, and the areas
// add up.
#include "common/clip/triangulate.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>
#include <vector>

#include "common/base/random.hpp"
#include "tests/support/repetitions.hpp"

namespace fracture {
namespace {

struct Loops {
  std::vector<LatticePoint> points;
  std::vector<std::uint32_t> begin{0};
  void add(const std::vector<LatticePoint>& loop) {
    points.insert(points.end(), loop.begin(), loop.end());
    begin.push_back(static_cast<std::uint32_t>(points.size()));
  }
  __int128 twice_area() const {
    __int128 sum = 0;
    for (std::size_t l = 0; l + 1 < begin.size(); ++l)
      for (std::uint32_t k = begin[l]; k < begin[l + 1]; ++k) {
        const LatticePoint &a = points[k], &b = points[k + 1 < begin[l + 1] ? k + 1 : begin[l]];
        sum += a.x * b.y - a.y * b.x;
      }
    return sum;
  }
};

std::vector<LatticePoint> reversed(std::vector<LatticePoint> loop) {
  std::reverse(loop.begin(), loop.end());
  return loop;
}

std::vector<LatticePoint> rectangle(std::int64_t x0, std::int64_t y0, std::int64_t x1, std::int64_t y1) {
  return {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}};
}

/// Expects that every loop edge is used once in its direction, and every other edge equally often in both
/// directions.
void expect_topology(const Loops& loops, const Triangulation& t) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> uses;
  for (const auto& tri : t.triangles)
    for (int e = 0; e < 3; ++e) {
      const std::uint32_t a = tri[e], b = tri[(e + 1) % 3];
      ASSERT_NE(a, b);
      uses[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
    }
  for (std::size_t l = 0; l + 1 < loops.begin.size(); ++l)
    for (std::uint32_t k = loops.begin[l]; k < loops.begin[l + 1]; ++k) {
      const std::uint32_t n = k + 1 < loops.begin[l + 1] ? k + 1 : loops.begin[l];
      uses[{std::min(k, n), std::max(k, n)}] -= k < n ? 1 : -1;
    }
  for (const auto& [edge, sum] : uses) EXPECT_EQ(sum, 0) << "edge " << edge.first << " " << edge.second;
  ASSERT_EQ(t.region.size(), t.triangles.size());
}

void expect_embedded(const Loops& loops, const Triangulation& t) {
  __int128 sum = 0;
  int turned = 0;
  for (const auto& tri : t.triangles) {
    const std::int64_t area = orient2d(loops.points[tri[0]], loops.points[tri[1]], loops.points[tri[2]]);
    turned += area < 0;
    sum += area;
  }
  EXPECT_EQ(turned, 0) << "triangles turned over";
  EXPECT_TRUE(sum == loops.twice_area());
  EXPECT_EQ(t.unnested_loops, 0u);
}

/// Rounding moves corners by a step or two. A triangle may be turned over by that much, but not more.
void expect_embedded_but_for_rounding(const Loops& loops, const Triangulation& t) {
  for (const auto& tri : t.triangles) {
    const LatticePoint &a = loops.points[tri[0]], &b = loops.points[tri[1]], &c = loops.points[tri[2]];
    const auto span = [](const LatticePoint& p, const LatticePoint& q) {
      return std::abs(p.x - q.x) + std::abs(p.y - q.y);
    };
    EXPECT_GE(orient2d(a, b, c), -3 * std::max({span(a, b), span(b, c), span(c, a)}));
  }
}

Triangulation run(const Loops& loops) {
  Triangulation t;
  triangulate(loops.points, loops.begin, t);
  expect_topology(loops, t);
  return t;
}

/// A star-shaped loop around a centre. Its radii vary, so it is far from convex.
std::vector<LatticePoint> star(Random& random, int n, std::int64_t cx, std::int64_t cy, std::int64_t radius) {
  // Takes the points of a square outline in order of angle and pulls each inwards by a random factor.
  std::vector<LatticePoint> loop;
  for (int k = 0; k < n; ++k) {
    const double s = 8.0 * k / n;
    double x, y;
    if (s < 1)
      x = 1, y = s;
    else if (s < 3)
      x = 2 - s, y = 1;
    else if (s < 5)
      x = -1, y = 4 - s;
    else if (s < 7)
      x = s - 6, y = -1;
    else
      x = 1, y = s - 8;
    const double r = (0.3 + 0.7 * random.uniform()) * static_cast<double>(radius);
    loop.push_back({cx + static_cast<std::int64_t>(x * r), cy + static_cast<std::int64_t>(y * r)});
  }
  return loop;
}

TEST(Triangulate, ASquareIsTwoTriangles) {
  Loops loops;
  loops.add(rectangle(0, 0, 10, 10));
  const Triangulation t = run(loops);
  EXPECT_EQ(t.triangles.size(), 2u);
  EXPECT_EQ(t.regions, 1u);
  expect_embedded(loops, t);
}

// Lattices of sites put two corners of a cut at one place. Neither corner turns right by itself, but both
// together may.
TEST(Triangulate, AReflexCornerThatStandsTwiceIsNotTakenForAConvexOne) {
  Loops loops;
  loops.add({{0, 30}, {40, 0}, {60, 0}, {60, 20}, {30, 20}, {30, 20}, {30, 40}});
  expect_embedded(loops, run(loops));
}

TEST(Triangulate, LoopsWhoseCornersStandTwiceAreNotTurnedOver) {
  Random random(20261122);
  for (int k = 0; k < test::repetitions(200); ++k) {
    Loops loops;
    std::vector<LatticePoint> twice;
    for (const LatticePoint& p : star(random, 5 + k % 40, 0, 0, 1 << 20)) twice.insert(twice.end(), {p, p});
    std::rotate(twice.begin(), twice.begin() + k % 2, twice.end());
    loops.add(twice);
    SCOPED_TRACE(k);
    expect_embedded(loops, run(loops));
  }
}

// A spike of zero width. On its way back lies a corner that sees another corner on a line through the end of
// the spike. An ear may then be good by itself and still leave a ring that is turned over. This loop is from
// a brick pattern.
TEST(Triangulate, ASpikeBesideACornerOnALineIsNotTurnedOver) {
  Loops loops;
  loops.add({{5836518, 4377388},
             {4377388, 5106954},
             {4377388, 5106954},
             {5040632, 4775332},
             {5040632, 4775332},
             {4377388, 4775332},
             {4377388, 4377388}});
  expect_embedded_but_for_rounding(loops, run(loops));
}

TEST(Triangulate, SpikesOfManyShapesAreNotTurnedOver) {
  Random random(20261123);
  for (int k = 0; k < test::repetitions(2000); ++k) {
    // The part of a triangle F, A, B before a line through D on A-B and E on F-B, with the way to B and back.
    const auto parts = static_cast<std::int64_t>(2 + random.below(40));
    const auto part = static_cast<std::int64_t>(1 + random.below(static_cast<std::uint64_t>(parts - 1)));
    const auto coordinate = [&] { return static_cast<std::int64_t>(random.below(20000)) - 10000; };
    LatticePoint a{coordinate(), coordinate()}, b{coordinate(), coordinate()};
    const LatticePoint f{0, 0};
    if (orient2d(f, a, b) < 0) std::swap(a, b);
    if (orient2d(f, a, b) < 1000) continue;
    LatticePoint d{parts * a.x + part * (b.x - a.x), parts * a.y + part * (b.y - a.y)};
    LatticePoint e{part * b.x, part * b.y};
    for (LatticePoint* p : {&d, &e}) {  // as rounding leaves them
      p->x += static_cast<std::int64_t>(random.below(3)) - 1;
      p->y += static_cast<std::int64_t>(random.below(3)) - 1;
    }
    a = {parts * a.x, parts * a.y};
    b = {parts * b.x, parts * b.y};
    std::vector<LatticePoint> ring{f, a, b, d, e};
    if (random.below(2) == 0) ring.insert(ring.begin() + 3, b);
    if (random.below(2) == 0) ring.insert(ring.end() - 1, d);
    std::rotate(ring.begin(), ring.begin() + static_cast<std::ptrdiff_t>(random.below(ring.size())),
                ring.end());
    Loops loops;
    loops.add(ring);
    SCOPED_TRACE(k);
    expect_embedded_but_for_rounding(loops, run(loops));
  }
}

TEST(Triangulate, AnAnnulusIsOneRegion) {
  Loops loops;
  loops.add(rectangle(0, 0, 30, 30));
  loops.add(reversed(rectangle(10, 10, 20, 20)));
  const Triangulation t = run(loops);
  EXPECT_EQ(t.triangles.size(), 8u);
  EXPECT_EQ(t.regions, 1u);
  expect_embedded(loops, t);
}

TEST(Triangulate, AnIslandInAHoleIsARegionOfItsOwn) {
  Loops loops;
  loops.add(rectangle(0, 0, 100, 100));
  loops.add(reversed(rectangle(10, 10, 90, 90)));
  loops.add(rectangle(20, 20, 80, 80));
  loops.add(reversed(rectangle(30, 30, 40, 40)));
  loops.add(reversed(rectangle(50, 50, 60, 70)));
  const Triangulation t = run(loops);
  EXPECT_EQ(t.regions, 2u);
  expect_embedded(loops, t);
}

TEST(Triangulate, SeparateLoopsAreSeparateRegions) {
  Loops loops;
  for (int k = 0; k < 5; ++k) loops.add(rectangle(10 * k, 0, 10 * k + 5, 5));
  const Triangulation t = run(loops);
  EXPECT_EQ(t.regions, 5u);
  expect_embedded(loops, t);
}

TEST(Triangulate, StarsOfManySizesAreCoveredWithoutOverturnedTriangles) {
  Random random(5);
  for (const int n : {5, 8, 13, 40, 63, 64, 65, 100, 300, 1000, 5000})
    for (int round = 0; round < 8; ++round) {
      SCOPED_TRACE(n);
      Loops loops;
      loops.add(star(random, n, 0, 0, 1 << 22));
      expect_embedded(loops, run(loops));
    }
}

TEST(Triangulate, AGridOfStarHolesInASquare) {
  Random random(6);
  for (const int grid : {1, 2, 5, 12}) {
    SCOPED_TRACE(grid);
    Loops loops;
    const std::int64_t cell = 1 << 16;
    loops.add(rectangle(0, 0, grid * cell, grid * cell));
    for (int i = 0; i < grid; ++i)
      for (int j = 0; j < grid; ++j)
        loops.add(
            reversed(star(random, 7 + (i + j) % 20, i * cell + cell / 2, j * cell + cell / 2, cell / 2 - 2)));
    const Triangulation t = run(loops);
    EXPECT_EQ(t.regions, 1u);
    expect_embedded(loops, t);
  }
}

TEST(Triangulate, MengerFloorManyAlignedHoles) {
  // All edges are parallel to the axes, with hundreds of equal coordinates: every tie of the sweep occurs.
  Loops loops;
  const int n = 27;
  loops.add(rectangle(0, 0, 3 * n, 3 * n));
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) loops.add(reversed(rectangle(3 * i + 1, 3 * j + 1, 3 * i + 2, 3 * j + 2)));
  const Triangulation t = run(loops);
  EXPECT_EQ(t.regions, 1u);
  expect_embedded(loops, t);
}

TEST(Triangulate, CollinearPointsOnEveryEdge) {
  Loops loops;
  std::vector<LatticePoint> ring;
  for (int k = 0; k < 50; ++k) ring.push_back({k, 0});
  for (int k = 0; k < 50; ++k) ring.push_back({50, k});
  for (int k = 0; k < 50; ++k) ring.push_back({50 - k, 50});
  for (int k = 0; k < 50; ++k) ring.push_back({0, 50 - k});
  loops.add(ring);
  const Triangulation t = run(loops);
  expect_embedded(loops, t);
  EXPECT_EQ(t.triangles.size(), ring.size() - 2);
}

TEST(Triangulate, NoFlatTrianglesWherePointsOnALineSeeTheInside) {
  // Sixty points along each side of a square. Every triangulation without flat triangles connects them
  // towards the inside.
  Loops loops;
  std::vector<LatticePoint> ring;
  for (int k = 0; k < 60; ++k) ring.push_back({1000 * k, 0});
  for (int k = 0; k < 60; ++k) ring.push_back({60000, 1000 * k});
  for (int k = 0; k < 60; ++k) ring.push_back({60000 - 1000 * k, 60000});
  for (int k = 0; k < 60; ++k) ring.push_back({0, 60000 - 1000 * k});
  loops.add(ring);
  const Triangulation t = run(loops);
  for (const auto& tri : t.triangles)
    EXPECT_GT(orient2d(loops.points[tri[0]], loops.points[tri[1]], loops.points[tri[2]]), 0);
}

TEST(Triangulate, RandomLoopsThatCrossThemselvesStillUseEveryEdgeOnce) {
  Random random(7);
  for (int round = 0; round < test::repetitions(200); ++round) {
    SCOPED_TRACE(round);
    Loops loops;
    const int count = 1 + static_cast<int>(random.below(4));
    for (int l = 0; l < count; ++l) {
      std::vector<LatticePoint> ring;
      const int n = 3 + static_cast<int>(random.below(round % 10 == 0 ? 200 : 20));
      for (int k = 0; k < n; ++k) {
        const auto x = static_cast<std::int64_t>(random.below(12)),
                   y = static_cast<std::int64_t>(random.below(12));
        ring.push_back({x, y});
      }
      loops.add(ring);
    }
    run(loops);
  }
}

TEST(Triangulate, AllPointsAtOnePlace) {
  Loops loops;
  loops.add(std::vector<LatticePoint>(9, LatticePoint{3, 3}));
  EXPECT_EQ(run(loops).triangles.size(), 7u);
}

TEST(Triangulate, AClockwiseLoopOutsideEveryOtherIsCounted) {
  Loops loops;
  loops.add(rectangle(0, 0, 10, 10));
  loops.add(reversed(rectangle(100, 100, 110, 110)));
  EXPECT_EQ(run(loops).unnested_loops, 1u);
}

TEST(Triangulate, TwoPointLoopsGiveNothing) {
  Loops loops;
  loops.add({{0, 0}, {5, 5}});
  Triangulation t;
  triangulate(loops.points, loops.begin, t);
  EXPECT_TRUE(t.triangles.empty());
}

}  // namespace
}  // namespace fracture
