#include "common/hollow/triangle_tree.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "common/base/random.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::hollow_detail {
namespace {

std::vector<Corners> triangles_of(const Mesh& mesh) {
  std::vector<Corners> triangles;
  for (const auto& t : mesh.triangles)
    triangles.push_back(
        {to_double(mesh.positions[t[0]]), to_double(mesh.positions[t[1]]), to_double(mesh.positions[t[2]])});
  return triangles;
}

TEST(SquaredDistance, ToEachRegionOfATriangle) {
  const Corners t{Vec3d{0, 0, 0}, Vec3d{4, 0, 0}, Vec3d{0, 4, 0}};
  EXPECT_EQ(squared_distance({1, 1, 3}, t), 9);     // the plane
  EXPECT_EQ(squared_distance({-3, -4, 0}, t), 25);  // corners
  EXPECT_EQ(squared_distance({7, -4, 0}, t), 25);
  EXPECT_EQ(squared_distance({-3, 8, 0}, t), 25);
  EXPECT_EQ(squared_distance({2, -3, 4}, t), 25);  // sides
  EXPECT_EQ(squared_distance({-3, 2, 4}, t), 25);
  EXPECT_DOUBLE_EQ(squared_distance({4, 4, 0}, t), 8);
}

TEST(SquaredDistance, ToATriangleWithoutAreaIsThatToItsCorners) {
  const Corners point{Vec3d{1, 2, 3}, Vec3d{1, 2, 3}, Vec3d{1, 2, 3}};
  EXPECT_EQ(squared_distance({1, 2, 8}, point), 25);
}

TEST(TriangleTree, FindsWhatLookingAtAllFinds) {
  const std::vector<Corners> triangles = triangles_of(test::torus(24, 12));
  const TriangleTree tree(triangles);
  Random random(7);
  for (int k = 0; k < 500; ++k) {
    const auto coordinate = [&] { return 4 * random.uniform() - 2; };
    const Vec3d p{coordinate(), coordinate(), coordinate()};
    double least = HUGE_VAL;
    for (const Corners& t : triangles) least = std::fmin(least, squared_distance(p, t));
    ASSERT_EQ(tree.distance(p), std::sqrt(least));
    EXPECT_FALSE(tree.within(p, 0.999 * std::sqrt(least)));
    EXPECT_TRUE(tree.within(p, 1.001 * std::sqrt(least)));
  }
}

TEST(TriangleTree, WindsOnceAroundWhatIsInside) {
  const TriangleTree tree(triangles_of(test::torus(24, 12)));
  Pacer pacer(kUninterrupted);
  EXPECT_NEAR(tree.winding({1, 0, 0}, pacer), 1, 1e-9);
  EXPECT_NEAR(tree.winding({0, 0, 0}, pacer), 0, 1e-9);
  EXPECT_NEAR(tree.winding({9, 3, 1}, pacer), 0, 1e-9);
  EXPECT_EQ(TriangleTree({}).distance({0, 0, 0}), HUGE_VAL);
}

}  // namespace
}  // namespace fracture::hollow_detail
