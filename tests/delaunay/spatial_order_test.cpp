#include "common/delaunay/spatial_order.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "tests/delaunay/point_families.hpp"

namespace fracture {
namespace {

TEST(SpatialOrder, IsAPermutationForEveryFamily) {
  for (const test::PointFamily& family : test::point_families())
    for (const std::uint32_t n : {0u, 1u, 2u, 63u, 1000u}) {
      const std::vector<Vec3d> points = family.make(n, 7);
      std::vector<std::uint32_t> order = spatial_order(points);
      std::sort(order.begin(), order.end());
      ASSERT_EQ(order.size(), points.size()) << family.name;
      for (std::uint32_t i = 0; i < order.size(); ++i) ASSERT_EQ(order[i], i) << family.name;
    }
}

TEST(SpatialOrder, TakesPointsThatAreHardlyApart) {
  for (const double apart : {0.0, 0x1.0p-1074, 0x1.0p-1060, 0x1.0p-1000}) {
    const std::vector<Vec3d> points{{0, 0, 0}, {apart, 0, 0}, {0, apart, 0}, {apart, apart, apart}};
    std::vector<std::uint32_t> order = spatial_order(points);
    std::sort(order.begin(), order.end());
    EXPECT_EQ(order, (std::vector<std::uint32_t>{0, 1, 2, 3})) << apart;
  }
}

}  // namespace
}  // namespace fracture
