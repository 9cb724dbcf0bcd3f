#include "common/bvh/triangle_crossing.hpp"

#include <gtest/gtest.h>

namespace fracture {
namespace {

bool crosses(const std::array<Vec3d, 3>& s, const std::array<Vec3d, 3>& t, double tolerance) {
  return cross_each_other(PlaneTriangle(s), PlaneTriangle(t), tolerance);
}

TEST(TrianglesCross, WhereAnEdgePiercesTheInside) {
  const std::array<Vec3d, 3> floor{Vec3d{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  EXPECT_TRUE(crosses(floor, {Vec3d{0.2, 0.2, -1}, {0.2, 0.2, 1}, {2, 2, 0}}, 1e-9));
  EXPECT_TRUE(crosses({Vec3d{0.2, 0.2, -1}, {0.2, 0.2, 1}, {2, 2, 0}}, floor, 1e-9));
  EXPECT_FALSE(crosses(floor, {Vec3d{0.2, 0.2, 0}, {0.2, 0.2, 1}, {2, 2, 1}}, 1e-9)) << "touches";
  EXPECT_FALSE(crosses(floor, {Vec3d{0, 0, 0}, {1, 0, 0}, {0, 1, 1}}, 1e-9)) << "shares an edge";
  EXPECT_FALSE(crosses(floor, {Vec3d{0.9, 0.9, -1}, {0.9, 0.9, 1}, {2, 2, 0}}, 1e-9)) << "beside it";
  EXPECT_FALSE(crosses(floor, {Vec3d{0.2, 0.2, -1e-10}, {0.2, 0.2, 1}, {2, 2, 1}}, 1e-9))
      << "by less than the tolerance";
  EXPECT_FALSE(crosses(floor, {Vec3d{0, 0, 1}, {1, 1, 1}, {2, 2, 1}}, 1e-9)) << "flat";
}

}  // namespace
}  // namespace fracture
