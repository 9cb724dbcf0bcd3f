// Compares the hull with its definition: it is closed, and no point of the input lies outside any face.
#include "common/physics/convex_hull.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>
#include <set>
#include <string>

#include "tests/support/figures.hpp"
#include "tests/support/poll_gaps.hpp"

namespace fracture::test {
namespace {

using Points = std::vector<Vec3f>;

/// The largest distance of a point outside a face, in units of the box's longest side.
double farthest_outside(const Points& points, const ConvexHullBuilder::Triangles& triangles) {
  Box box;
  for (const Vec3f& p : points) box.add(to_double(p));
  double farthest = 0;
  for (const auto& t : triangles) {
    const Vec3d a = to_double(points[t[0]]), b = to_double(points[t[1]]), c = to_double(points[t[2]]);
    const Vec3d n = cross(b - a, c - a);
    if (length(n) < 1e-4 * box.longest_side() * box.longest_side()) continue;  // only rounding
    for (const Vec3f& p : points) farthest = std::max(farthest, dot(n, to_double(p) - a) / length(n));
  }
  return farthest / box.longest_side();
}

Mesh mesh_of(const Points& points, const ConvexHullBuilder::Triangles& triangles) {
  Mesh mesh;
  mesh.positions = points;
  mesh.triangles = triangles;
  return mesh;
}

std::set<std::uint32_t> corners(const ConvexHullBuilder::Triangles& triangles) {
  std::set<std::uint32_t> out;
  for (const auto& t : triangles) out.insert(t.begin(), t.end());
  return out;
}

struct Family {
  std::string name;
  Points points;
};

std::vector<Family> families() {
  std::vector<Family> out;
  std::mt19937 random(7);
  const auto unit = [&random] { return static_cast<float>(random() % 100001) / 100000.0f; };
  for (const int n : {4, 5, 20, 300, 3000}) {
    Points box, ball, disc, dented;
    for (int k = 0; k < n; ++k) {
      const Vec3f p{unit(), unit(), unit()};
      const Vec3d v = to_double(p) - Vec3d{0.5, 0.5, 0.5};
      const double l = length(v) + 1e-9;
      box.push_back(p);
      ball.push_back({static_cast<float>(v.x / l), static_cast<float>(v.y / l), static_cast<float>(v.z / l)});
      disc.push_back({p.x, 0.001f * p.y, p.z});
      dented.push_back({100 + p.x, std::round(8 * p.y), std::round(8 * p.z)});
    }
    out.push_back({"box " + std::to_string(n), box});
    out.push_back({"ball " + std::to_string(n), ball});
    out.push_back({"disc " + std::to_string(n), disc});
    out.push_back({"on planes " + std::to_string(n), dented});
    ball.insert(ball.end(), ball.begin(), ball.end());
    out.push_back({"twice " + std::to_string(n), ball});
  }
  return out;
}

TEST(ConvexHull, IsClosedAndNothingLiesOutside) {
  ConvexHullBuilder builder;
  for (const Family& f : families()) {
    const auto& triangles = builder.build(f.points, 1u << 20);
    ASSERT_FALSE(triangles.empty()) << f.name;
    EXPECT_FALSE(builder.stopped_early());
    EXPECT_EQ(open_directed_edges(mesh_of(f.points, triangles)), 0u) << f.name;
    EXPECT_EQ(triangles.size(), 2 * corners(triangles).size() - 4) << f.name;  // Euler: one sphere
    EXPECT_LE(farthest_outside(f.points, triangles), 2e-5) << f.name;
  }
}

TEST(ConvexHull, EveryCornerSticksOutOfTheHullOfTheOthers) {
  ConvexHullBuilder builder;
  std::vector<Family> all = families();
  Points grid, prism;
  for (int k = 0; k < 125; ++k)
    grid.push_back({static_cast<float>(k % 5), static_cast<float>(k / 5 % 5), static_cast<float>(k / 25)});
  // Rings at four heights, with points along the sides and in the lids. The first lid is swept first.
  for (int k = 0; k < 72; ++k) {
    const double turn = 6.283185307179586 * (k / 4) / 18;
    for (const double r : {1.0, 0.5})
      prism.push_back({static_cast<float>(k % 4), static_cast<float>(r * std::cos(turn)),
                       static_cast<float>(r * std::sin(turn))});
  }
  all.push_back({"grid", grid});
  all.push_back({"prism", prism});
  int compared = 0;
  for (const Family& f : all) {
    if (f.points.size() < 5 || f.points.size() > 300 || f.name.starts_with("twice")) continue;
    const std::set<std::uint32_t> hull = corners(builder.build(f.points, 1000));
    ASSERT_GE(hull.size(), 4u) << f.name;
    for (const std::uint32_t corner : hull) {
      Points others = f.points;
      others.erase(others.begin() + corner);
      ConvexHullBuilder::Triangles triangles = builder.build(others, 1000);
      others.push_back(f.points[corner]);
      if (triangles.empty()) continue;
      EXPECT_GT(farthest_outside(others, triangles), 1e-9) << f.name << ", " << corner;
      ++compared;
    }
    // A prism whose sides and lids have additional points. Only its two outer rings are corners.
    if (f.name == "prism") {
      EXPECT_EQ(hull.size(), 36u);
    }
  }
  EXPECT_GT(compared, 300);
}

// A convex body has V >= A r / 3 and r >= w / sqrt(12) for its inscribed ball and smallest width (Steinhagen
// 1922). So a layer of tolerance x w on all of it is at most 3 sqrt(12) = 10.4 times the volume's tolerance.
TEST(ConvexHull, WithAToleranceLittleIsLeftOutHoweverThinTheBody) {
  ConvexHullBuilder builder;
  for (const Family& f : families())
    for (const double tolerance : {0.002, 0.01}) {
      SCOPED_TRACE(f.name);
      const ConvexHullBuilder::Triangles whole = builder.build(f.points, 1u << 20);
      const auto& triangles = builder.build(f.points, 1u << 20, {}, {}, tolerance);
      ASSERT_FALSE(triangles.empty());
      EXPECT_FALSE(builder.stopped_early());
      EXPECT_EQ(open_directed_edges(mesh_of(f.points, triangles)), 0u);
      EXPECT_EQ(triangles.size(), 2 * corners(triangles).size() - 4);
      EXPECT_LE(triangles.size(), whole.size());
      EXPECT_GE(volume_of(mesh_of(f.points, triangles)),
                (1 - 10.4 * tolerance) * volume_of(mesh_of(f.points, whole)));
    }
}

TEST(ConvexHull, WithAToleranceABallHasAsManyCornersAsItsBendNeeds) {
  Points ball;
  for (const Family& f : families())
    if (f.name.starts_with("ball") && f.points.size() > ball.size()) ball = f.points;
  ConvexHullBuilder builder;
  const std::size_t all = corners(builder.build(ball, 1u << 20)).size();
  ASSERT_GT(all, 300u) << "the largest family";
  // If the ball rises above a face by the tolerance, each of its corners has a third of a cap's area.
  const std::size_t few = corners(builder.build(ball, 1u << 20, {}, {}, 0.05)).size();
  EXPECT_LT(few, all / 2);
  EXPECT_GT(few, 20u);
}

using Surface = std::vector<std::array<std::uint32_t, 3>>;

/// A surface with the points as its corners.
class BodyOf {
 public:
  BodyOf(const Points& points, const Surface& surface) : corner_of_(points.size()) {
    for (const auto& t : surface) indices_.insert(indices_.end(), t.begin(), t.end());
    std::iota(corner_of_.begin(), corner_of_.end(), 0u);
  }
  BodySurface surface() const { return {indices_, corner_of_}; }

 private:
  std::vector<std::uint32_t> indices_, corner_of_;
};
ConvexHullBuilder::Triangles hull_of(const Points& points, const Surface& surface, std::uint32_t most = 255) {
  ConvexHullBuilder builder;
  return builder.build(points, most, {}, BodyOf(points, surface).surface());
}

/// A cube whose faces have an additional point in the middle, lifted by `lift`: convex, flat or dented.
std::pair<Points, Surface> cube_with_middles(float lift, int middles) {
  Points points;
  for (int k = 0; k < 8; ++k)
    points.push_back({static_cast<float>(k & 1), static_cast<float>(k >> 1 & 1), static_cast<float>(k >> 2)});
  constexpr std::array<std::array<std::uint32_t, 4>, 6> kSides{
      {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
  Surface surface;
  for (int s = 0; s < 6; ++s) {
    const auto& side = kSides[static_cast<std::size_t>(s)];
    if (s >= middles) {
      surface.push_back({side[0], side[1], side[2]});
      surface.push_back({side[0], side[2], side[3]});
      continue;
    }
    const Vec3d middle = 0.25 * (to_double(points[side[0]]) + to_double(points[side[1]]) +
                                 to_double(points[side[2]]) + to_double(points[side[3]]));
    const Vec3d out = middle - Vec3d{0.5, 0.5, 0.5}, p = middle + 2 * lift * out;
    const auto apex = static_cast<std::uint32_t>(points.size());
    points.push_back({static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)});
    for (std::size_t k = 0; k < 4; ++k) surface.push_back({side[k], side[(k + 1) % 4], apex});
  }
  return {points, surface};
}

TEST(ConvexHull, OfAConvexSurfaceIsThatSurface) {
  for (const auto& [lift, middles] : {std::pair{0.1f, 6}, {0.0f, 0}, {1e-6f, 1}, {-1e-6f, 1}}) {
    const auto [points, surface] = cube_with_middles(lift, middles);
    EXPECT_EQ(hull_of(points, surface), surface) << lift;
  }
}

TEST(ConvexHull, OfASurfaceThatIsNotConvexLeavesOutWhatDoesNotStickOut) {
  for (const auto& [lift, middles, expected] :
       {std::tuple{0.0f, 6, 8u}, {-0.1f, 1, 8u}, {-0.001f, 6, 8u}, {-1e-4f, 1, 8u}}) {
    const auto [points, surface] = cube_with_middles(lift, middles);
    const auto triangles = hull_of(points, surface);
    EXPECT_EQ(corners(triangles).size(), expected) << lift << ", " << middles;
    EXPECT_EQ(open_directed_edges(mesh_of(points, triangles)), 0u);
  }
}

/// Rings of `sides` points around the z axis at these radii and heights, closed by fans to two points.
std::pair<Points, Surface> around_axis(std::uint32_t sides,
                                       const std::vector<std::pair<double, double>>& rings, double bottom,
                                       double top) {
  Points points;
  for (const auto& [radius, height] : rings)
    for (std::uint32_t k = 0; k < sides; ++k) {
      const double turn = 6.283185307179586 * k / sides;
      points.push_back({static_cast<float>(radius * std::cos(turn)),
                        static_cast<float>(radius * std::sin(turn)), static_cast<float>(height)});
    }
  const auto low = static_cast<std::uint32_t>(points.size()), high = low + 1;
  points.push_back({0, 0, static_cast<float>(bottom)});
  points.push_back({0, 0, static_cast<float>(top)});
  const auto last = static_cast<std::uint32_t>(rings.size() - 1) * sides;
  Surface surface;
  for (std::uint32_t k = 0; k < sides; ++k) {
    const std::uint32_t next = (k + 1) % sides;
    surface.push_back({next, k, low});
    surface.push_back({last + k, last + next, high});
    for (std::uint32_t r = 0; r < last; r += sides) {
      surface.push_back({r + k, r + next, r + sides + next});
      surface.push_back({r + k, r + sides + next, r + sides + k});
    }
  }
  return {points, surface};
}

TEST(ConvexHull, OfFineSurfacesKeepsWhatBendsByLessThanRounding) {
  std::vector<std::pair<double, double>> half_sphere;
  for (int r = 0; r < 200; ++r) half_sphere.push_back({std::cos(0.0078 * r), std::sin(0.0078 * r)});
  for (const auto& [points, surface] :
       {around_axis(2000, {{1, 0}, {1, 0.2}}, 0, 0.2), around_axis(2000, half_sphere, 0, 1),
        around_axis(5000, {{1, 0}}, -0.5, 0.5)}) {
    const auto triangles = hull_of(points, surface, 1u << 20);
    ASSERT_FALSE(triangles.empty());
    EXPECT_EQ(open_directed_edges(mesh_of(points, triangles)), 0u);
    EXPECT_LE(farthest_outside(points, triangles), 2e-5);
    EXPECT_NEAR(volume_of(mesh_of(points, triangles)), volume_of(mesh_of(points, surface)),
                1e-4 * volume_of(mesh_of(points, surface)));
  }
}

TEST(ConvexHull, IsNotDeceivedByANarrowStripInAValley) {
  // A house whose roof is a shallow valley: its bottom is 50 steps of the grid wide.
  const std::array<std::pair<float, float>, 6> outline{
      {{0, 0}, {1, 0}, {1, 1}, {0.50005f, 0.97f}, {0.49995f, 0.97f}, {0, 1}}};
  Points points;
  for (const float z : {0.0f, 1.0f})
    for (const auto& [x, y] : outline) points.push_back({x, y, z});
  Surface surface;
  for (std::uint32_t k = 0; k < 6; ++k) {
    const std::uint32_t next = (k + 1) % 6;
    surface.push_back({k, next, 6 + next});
    surface.push_back({k, 6 + next, 6 + k});
  }
  for (std::uint32_t k = 1; k < 5; ++k) {  // from a corner that sees all of the outline
    const std::uint32_t b = (1 + k) % 6, c = (2 + k) % 6;
    surface.push_back({1, c, b});
    surface.push_back({7, 6 + b, 6 + c});
  }
  const auto triangles = hull_of(points, surface);
  EXPECT_EQ(corners(triangles).size(), 8u);
  EXPECT_NEAR(volume_of(mesh_of(points, triangles)), 1, 1e-5);
}

TEST(ConvexHull, OfALargeSurfaceWithAHubCanBeInterruptedAnywhere) {
  const auto [points, ordered] = around_axis(200'000, {{1, 0}}, -0.5, 0.5);
  Surface shuffled = ordered;
  std::shuffle(shuffled.begin(), shuffled.end(), std::mt19937(5));
  for (const Surface& surface : {ordered, shuffled}) {
    const BodyOf body(points, surface);
    const Polled built = polled([&, &points = points](const Execution& execution) {
      EXPECT_FALSE(ConvexHullBuilder().build(points, 255, execution, body.surface()).empty());
    });
    EXPECT_LT(built.longest_ms, kMostPollGapMs);
    EXPECT_LT(static_cast<double>(built.polls) * 8192 / 200'000, 300) << "steps a point";
  }
}

TEST(ConvexHull, DoesNotTakeASurfaceThatIsNone) {
  ConvexHullBuilder builder;
  const auto [points, closed] = cube_with_middles(0.1f, 6);
  const auto expected = corners(builder.build(points, 255));
  Surface open = closed, turned = closed, degenerate = closed;
  open.pop_back();
  for (auto& t : turned) std::swap(t[1], t[2]);
  degenerate.back() = {degenerate.back()[0], degenerate.back()[0], degenerate.back()[2]};
  for (const Surface& surface : {open, turned, degenerate}) {
    const auto triangles = hull_of(points, surface);
    EXPECT_EQ(corners(triangles), expected);
    EXPECT_EQ(open_directed_edges(mesh_of(points, triangles)), 0u);
    EXPECT_GT(volume_of(mesh_of(points, triangles)), 1);
  }
}

TEST(ConvexHull, OfAGridIsItsEightCorners) {
  Points points;
  for (int x = 0; x <= 8; ++x)
    for (int y = 0; y <= 8; ++y)
      for (int z = 0; z <= 8; ++z)
        points.push_back({static_cast<float>(x), static_cast<float>(y), 3.0f * static_cast<float>(z)});
  ConvexHullBuilder builder;
  const auto triangles = builder.build(points, 255);
  EXPECT_EQ(triangles.size(), 12u);
  EXPECT_EQ(corners(triangles).size(), 8u);
  EXPECT_DOUBLE_EQ(volume_of(mesh_of(points, triangles)), 8 * 8 * 24);
}

TEST(ConvexHull, OfFlatPointsIsEmpty) {
  ConvexHullBuilder builder;
  Points line, plane;
  for (int k = 0; k < 50; ++k) {
    line.push_back({static_cast<float>(k), 2.0f * static_cast<float>(k), 1});
    plane.push_back(
        {static_cast<float>(k % 7), static_cast<float>(k / 7), static_cast<float>(k % 7 + k / 7)});
  }
  for (const Points& points : {Points{}, Points(3), Points(9, {1, 2, 3}), line, plane})
    EXPECT_TRUE(builder.build(points, 255).empty());
  plane.push_back({3, 3, 100});
  EXPECT_EQ(corners(builder.build(plane, 255)).count(50), 1u);
}

TEST(ConvexHull, StopsAtTheGivenNumberOfPointsWithoutLeavingASideOut) {
  ConvexHullBuilder builder;
  for (const Family& f : families()) {
    if (f.name != "ball 3000") continue;
    const auto all = builder.build(f.points, 1u << 20);
    for (const std::uint32_t most : {4u, 20u, 60u, 255u}) {
      const auto& some = builder.build(f.points, most);
      EXPECT_TRUE(builder.stopped_early());
      EXPECT_EQ(corners(some).size(), most);
      EXPECT_EQ(open_directed_edges(mesh_of(f.points, some)), 0u);
    }
    EXPECT_GT(volume_of(mesh_of(f.points, builder.build(f.points, 255))),
              0.95 * volume_of(mesh_of(f.points, all)));
  }
}

/// Points on a sphere, on two circles, on a spiral, and in a few small clumps at its ends. Either all of them
/// are extreme, or all are close together.
std::vector<Family> large_families(std::size_t n) {
  std::vector<Family> out(4);
  std::mt19937 random(3);
  const auto unit = [&random] { return static_cast<double>(random() % 1000003) / 1000003; };
  const auto add = [](Family& family, double x, double y, double z) {
    family.points.push_back({static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)});
  };
  out[0].name = "sphere";
  out[1].name = "two circles";
  out[2].name = "spiral";
  out[3].name = "clumps";
  for (std::size_t k = 0; k < n; ++k) {
    const double t = static_cast<double>(k) / static_cast<double>(n), z = 2 * unit() - 1,
                 turn = 6.28 * unit();
    const double r = std::sqrt(1 - z * z);
    add(out[0], r * std::cos(turn), r * std::sin(turn), z);
    add(out[1], std::cos(12.56 * t), std::sin(12.56 * t), k % 2 == 0 ? 0 : 1);
    add(out[2], (1 - t * t) * std::cos(200 * t), (1 - t * t) * std::sin(200 * t), t);
    const double end = k % 5 == 0 ? 1 : -1;
    add(out[3], end + 1e-3 * unit() * r, 1e-3 * z + end * end * 0.1 * static_cast<double>(k % 3),
        1e-3 * unit() + 0.2 * static_cast<double>(k % 2));
  }
  return out;
}

TEST(ConvexHull, OfManyPointsGrowsWithTheirNumberAndCanBeInterruptedAnywhere) {
  std::vector<std::vector<double>> polls(4);
  for (const std::size_t n : {25'000u, 100'000u}) {
    const std::vector<Family> families = large_families(n);
    for (std::size_t f = 0; f < families.size(); ++f) {
      std::vector<std::array<std::uint32_t, 3>> triangles;
      const Polled built = polled([&](const Execution& execution) {
        triangles = ConvexHullBuilder().build(families[f].points, 255, execution);
      });
      EXPECT_LT(built.longest_ms, kMostPollGapMs) << families[f].name;
      EXPECT_FALSE(triangles.empty());
      EXPECT_EQ(open_directed_edges(mesh_of(families[f].points, triangles)), 0u) << families[f].name;
      polls[f].push_back(static_cast<double>(built.polls));
    }
  }
  for (std::size_t f = 0; f < polls.size(); ++f) {
    EXPECT_LT(std::log(polls[f][1] / polls[f][0]) / std::log(4), 1.15) << f;
    EXPECT_LT(polls[f][1] * 8192 / 100'000, 200) << "steps a point, family " << f;
  }
}

}  // namespace
}  // namespace fracture::test
