#include "common/rough/core_lattice.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "tests/rough/loops.hpp"
#include "tests/support/poll_gaps.hpp"

namespace fracture {
namespace {

double distance(const Vec2d& p, const Vec2d& a, const Vec2d& b) {
  const double ex = b.x - a.x, ey = b.y - a.y, dx = p.x - a.x, dy = p.y - a.y;
  const double t = std::clamp((dx * ex + dy * ey) / (ex * ex + ey * ey), 0.0, 1.0);
  return std::hypot(dx - t * ex, dy - t * ey);
}

double distance(const Vec2d& p, const test::Loops<Vec2d>& loops) {
  double least = HUGE_VAL;
  for (std::size_t l = 0; l + 1 < loops.begin.size(); ++l)
    for (std::uint32_t k = loops.begin[l]; k < loops.begin[l + 1]; ++k)
      least = std::min(least, distance(p, loops.points[k],
                                       loops.points[k + 1 < loops.begin[l + 1] ? k + 1 : loops.begin[l]]));
  return least;
}

double area(const CoreLattice& core) {
  double twice = 0;
  for (const auto& t : core.triangles()) {
    const Vec2d &a = core.points()[t[0]], &b = core.points()[t[1]], &c = core.points()[t[2]];
    const double area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    EXPECT_GT(area, 0);
    twice += area;
  }
  return twice / 2;
}

/// Expects that the rim consists of the edges that only one triangle uses, reversed, in loops that pass no
/// point twice.
void expect_simple_rim(const CoreLattice& core) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> balance;
  for (const auto& t : core.triangles())
    for (std::size_t k = 0; k < 3; ++k) {
      ++balance[{t[k], t[(k + 1) % 3]}];
      --balance[{t[(k + 1) % 3], t[k]}];
    }
  std::set<std::uint32_t> seen;
  for (std::size_t l = 0; l + 1 < core.rim_begin().size(); ++l)
    for (std::uint32_t k = core.rim_begin()[l]; k < core.rim_begin()[l + 1]; ++k) {
      const std::uint32_t from = core.rim()[k],
                          to = core.rim()[k + 1 < core.rim_begin()[l + 1] ? k + 1 : core.rim_begin()[l]];
      EXPECT_TRUE(seen.insert(from).second) << "a pinch";
      ++balance[{from, to}];
      --balance[{to, from}];
    }
  for (const auto& [edge, sum] : balance) EXPECT_EQ(sum, 0);
}

TEST(CoreLattice, FillsASquareUpToAMargin) {
  test::Loops<Vec2d> loops;
  loops.add({{0, 0}, {1, 0}, {1, 1}, {0, 1}});
  CoreLattice core;
  core.build(loops.points, loops.begin, 0.05, 1);
  expect_simple_rim(core);
  EXPECT_EQ(core.rim_begin().size(), 2u);
  for (const Vec2d& p : core.points()) EXPECT_GE(distance(p, loops), 0.6 * 0.05 - 1e-12);
  const double covered = area(core);
  EXPECT_LT(covered, (1 - 0.06) * (1 - 0.06));
  EXPECT_GT(covered, (1 - 0.2) * (1 - 0.2)) << "two lengths from each side at most";
}

TEST(CoreLattice, GoesAroundHolesAndInlets) {
  test::Loops<Vec2d> loops;
  // A square with an extremely thin inlet from the right, and a hole.
  loops.add({{0, 0}, {1, 0}, {1, 0.5}, {0.6, 0.501}, {1, 0.502}, {1, 1}, {0, 1}});
  loops.add({{0.2, 0.2}, {0.2, 0.35}, {0.35, 0.35}, {0.35, 0.2}});
  CoreLattice core;
  core.build(loops.points, loops.begin, 0.03, 0.97);
  expect_simple_rim(core);
  EXPECT_EQ(core.rim_begin().size(), 3u) << "around the outside and around the hole";
  for (const Vec2d& p : core.points()) EXPECT_GE(distance(p, loops), 0.6 * 0.03 - 1e-12);
  for (const auto& t : core.triangles())
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec2d &a = core.points()[t[k]], &b = core.points()[t[(k + 1) % 3]];
      EXPECT_NEAR(std::hypot(b.x - a.x, b.y - a.y), 0.03, 1e-12);
      EXPECT_GT(distance({(a.x + b.x) / 2, (a.y + b.y) / 2}, loops), 0.1 * 0.03) << "crosses a loop";
    }
}

TEST(CoreLattice, LeavesNarrowAndEmptyLoopsAlone) {
  CoreLattice core;
  test::Loops<Vec2d> narrow;
  narrow.add({{0, 0}, {1, 0}, {1, 0.05}, {0, 0.05}});
  core.build(narrow.points, narrow.begin, 0.1, 0.05);
  EXPECT_TRUE(core.triangles().empty());
  EXPECT_EQ(core.rim_begin().size(), 1u);
  test::Loops<Vec2d> rim;  // a rim of zero width around a large box
  rim.add({{0, 0}, {1, 0}, {1, 1}, {0, 1}});
  rim.add({{1e-6, 1e-6}, {1e-6, 1 - 1e-6}, {1 - 1e-6, 1 - 1e-6}, {1 - 1e-6, 1e-6}});
  core.build(rim.points, rim.begin, 1e-3, 4e-6);
  EXPECT_TRUE(core.triangles().empty());
}

TEST(CoreLattice, CanBeInterruptedWhileItLooksAtAMillionPoints) {
  test::Loops<Vec2d> loops;
  loops.add({{0, 0}, {1, 0}, {1, 1}, {0, 1}});
  CoreLattice core;
  const test::Polled built = test::polled(
      [&](const Execution& execution) { core.build(loops.points, loops.begin, 1e-3, 1, execution); });
  EXPECT_LT(built.longest_ms, test::kMostPollGapMs);
  EXPECT_GT(core.triangles().size(), 2'000'000u);
}

}  // namespace
}  // namespace fracture
