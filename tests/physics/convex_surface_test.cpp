// Hulls of points with a surface: if the surface is convex, it is the hull; otherwise, the surface is not taken.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <random>
#include <tuple>
#include <utility>
#include <vector>

#include "common/physics/convex_hull.hpp"
#include "tests/physics/hull_checks.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/poll_gaps.hpp"

namespace fracture::test {
namespace {

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

}  // namespace
}  // namespace fracture::test
