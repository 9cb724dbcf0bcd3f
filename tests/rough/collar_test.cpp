#include "common/rough/collar.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>

#include "common/base/random.hpp"
#include "common/clip/delaunay_flips.hpp"
#include "tests/rough/loops.hpp"

namespace fracture {
namespace {

LatticePoint at(double angle, double radius) {
  return {std::llround(radius * std::cos(angle)), std::llround(radius * std::sin(angle))};
}

/// A counter-clockwise loop with `radius(k)` for each corner.
template <class Radius>
std::vector<LatticePoint> star(int corners, const Radius& radius) {
  std::vector<LatticePoint> loop;
  for (int k = 0; k < corners; ++k) loop.push_back(at(2 * std::numbers::pi * k / corners, radius(k)));
  return loop;
}
std::vector<LatticePoint> clockwise(std::vector<LatticePoint> loop) { return {loop.rbegin(), loop.rend()}; }

std::int64_t twice_area(const test::Loops<LatticePoint>& loops) {
  std::int64_t sum = 0;
  for (std::size_t l = 0; l + 1 < loops.begin.size(); ++l)
    for (std::uint32_t k = loops.begin[l]; k < loops.begin[l + 1]; ++k)
      sum += orient2d({}, loops.points[k], loops.points[k + 1 < loops.begin[l + 1] ? k + 1 : loops.begin[l]]);
  return sum;
}

/// Expects that the triangles cover the area between the loops once. They must be counter-clockwise and have
/// the enclosed area. Each edge of the loops must be in one triangle, and each other edge in two.
void expect_covered(const test::Loops<LatticePoint>& loops, const Collar& collar) {
  std::int64_t area = 0;
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> uses;
  for (const auto& t : collar.triangles()) {
    const std::int64_t twice = orient2d(loops.points[t[0]], loops.points[t[1]], loops.points[t[2]]);
    EXPECT_GT(twice, 0);
    area += twice;
    for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ((++uses[{t[k], t[(k + 1) % 3]}]), 1);
  }
  EXPECT_EQ(area, twice_area(loops));
  EXPECT_EQ(collar.triangles().size(), loops.points.size() + 2 * (loops.begin.size() - 3));
  for (std::size_t l = 0; l + 1 < loops.begin.size(); ++l)
    for (std::uint32_t k = loops.begin[l]; k < loops.begin[l + 1]; ++k) {
      const std::uint32_t next = k + 1 < loops.begin[l + 1] ? k + 1 : loops.begin[l];
      EXPECT_EQ((uses.count({k, next})), 1u);
      EXPECT_EQ((uses.count({next, k})), 0u);
    }
}

/// Expects that no fourth corner lies in the circle of a neighbouring triangle.
void expect_delaunay(const test::Loops<LatticePoint>& loops, const Collar& collar) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> opposite;
  for (const auto& t : collar.triangles())
    for (std::size_t k = 0; k < 3; ++k) opposite[{t[k], t[(k + 1) % 3]}] = t[(k + 2) % 3];
  for (const auto& [edge, c] : opposite) {
    const auto other = opposite.find({edge.second, edge.first});
    if (other == opposite.end()) continue;
    const auto& p = loops.points;
    EXPECT_FALSE(in_circle(p[edge.first], p[edge.second], p[c], p[other->second]));
  }
}

TEST(Collar, OfARingOfAnyShape) {
  Random random(20261123);
  int zipped = 0;
  for (int round = 0; round < 200; ++round) {
    SCOPED_TRACE(round);
    const auto between = [&](double low, double high) {
      return low + (high - low) * static_cast<double>(random() % 1000) / 1000;
    };
    const int corners = 3 + static_cast<int>(random() % 40), inner = 3 + static_cast<int>(random() % 30);
    test::Loops<LatticePoint> loops;
    loops.add(star(corners, [&](int) { return between(6e6, 8e6); }));
    const double size = corners < 5 ? 1e6 : 2e6;
    loops.add(clockwise(star(inner, [&](int) { return between(0.7 * size, size); })));
    Collar collar;
    ASSERT_TRUE(collar.build(loops.points, loops.begin, 1, {}));
    EXPECT_EQ(collar.regions(), 1u);
    zipped += collar.zipped();
    expect_covered(loops, collar);
    expect_delaunay(loops, collar);
  }
  EXPECT_GT(zipped, 150);
}

// The rim lies in one arm of a long bent shape: no zip goes around it.
TEST(Collar, WhereTheZipJams) {
  test::Loops<LatticePoint> loops;
  loops.add(
      {{0, 0}, {8000, 0}, {8000, 8000}, {7000, 8000}, {7000, 1000}, {1000, 1000}, {1000, 8000}, {0, 8000}});
  loops.add(clockwise({{7400, 7000}, {7600, 7000}, {7600, 7500}, {7400, 7500}}));
  Collar collar;
  ASSERT_TRUE(collar.build(loops.points, loops.begin, 1, {}));
  EXPECT_FALSE(collar.zipped());
  expect_covered(loops, collar);
  expect_delaunay(loops, collar);
}

TEST(Collar, OfSeveralLoopsAndOfNoRim) {
  test::Loops<LatticePoint> loops;
  loops.add({{0, 0}, {8000, 0}, {8000, 8000}, {0, 8000}});
  loops.add(clockwise({{500, 500}, {1500, 500}, {1500, 1500}, {500, 1500}}));
  loops.add(clockwise({{4000, 4000}, {6000, 4000}, {6000, 6000}, {4000, 6000}}));
  Collar collar;
  ASSERT_TRUE(collar.build(loops.points, loops.begin, 2, {}));
  expect_covered(loops, collar);
  test::Loops<LatticePoint> alone;
  alone.add({{0, 0}, {8000, 0}, {8000, 8000}, {0, 8000}});
  ASSERT_TRUE(collar.build(alone.points, alone.begin, 1, {}));
  EXPECT_EQ(collar.triangles().size(), 2u);
}

}  // namespace
}  // namespace fracture
