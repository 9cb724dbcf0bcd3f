// Hulls from collision geometry of the source.
#include "common/physics/given_hulls.hpp"

#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <set>

#include "tests/physics/bent_shapes.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::test {
namespace {

GivenHull given(const Mesh& mesh, bool convex) {
  return {"UCX_a", std::make_shared<const std::vector<std::uint32_t>>(1, 0u), convex, mesh.positions,
          mesh.triangles};
}

std::set<std::array<float, 3>> corner_set(const std::vector<Vec3f>& points) {
  std::set<std::array<float, 3>> result;
  for (const Vec3f& p : points) result.insert({p.x, p.y, p.z});
  return result;
}

/// An L of three unit cubes in a row of two, 0.5 thick: its volume is 1.5, and that of its hull 1.75.
Mesh bent() {
  return grid_solid({{{0, 1, 2}, {0, 1, 2}, {0, 0.5}}}, [](int i, int j, int) { return i == 0 || j == 0; });
}

TEST(GivenHulls, HaveTheCornersOfTheGeometryUnmoved) {
  const Mesh cube = box({1, 2, 3}, {2, 4, 6});
  const FragmentHulls made = make_given_hulls(given(cube, true), 1.5, {});
  ASSERT_EQ(made.hulls.size(), 1u);
  EXPECT_EQ(corner_set(made.hulls[0].points), corner_set(cube.positions));
  EXPECT_EQ(made.hulls[0].triangles.size(), 12u);
  EXPECT_DOUBLE_EQ(made.volume, 6);
}

TEST(GivenHulls, ConnectedPiecesHaveAHullEach) {
  const Mesh two = joined({box({0, 0, 0}, {1, 1, 1}), box({3, 0, 0}, {4, 1, 1})});
  const FragmentHulls made = make_given_hulls(given(two, true), 1.5, {});
  ASSERT_EQ(made.hulls.size(), 2u);
  EXPECT_DOUBLE_EQ(made.volume, 2);
  for (const Vec3f& p : made.hulls[1].points) EXPECT_GE(p.x, 3);
}

TEST(GivenHulls, BentGeometryIsAHullOnlyIfTheHullIsMeant) {
  const FragmentHulls made = make_given_hulls(given(bent(), true), 1.1, {});
  ASSERT_EQ(made.hulls.size(), 1u);
  EXPECT_NEAR(made.volume, 1.75, 1e-6);
  EXPECT_TRUE(make_given_hulls(given(bent(), false), 1.1, {}).hulls.empty()) << "1.75 / 1.5 = 1.17";
  EXPECT_EQ(make_given_hulls(given(bent(), false), 1.2, {}).hulls.size(), 1u);
}

TEST(GivenHulls, FlatGeometryHasNone) {
  Mesh flat;
  flat.positions = {{0, 0, 0}, {1, 0, 0}, {1, 0, 1}, {0, 0, 1}};
  flat.triangles = {{0, 2, 1}, {0, 3, 2}};
  for (const bool convex : {true, false})
    EXPECT_TRUE(make_given_hulls(given(flat, convex), 1.5, {}).hulls.empty());
}

}  // namespace
}  // namespace fracture::test
