#include "common/bvh/triangle_distance.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "common/base/random.hpp"
#include "common/bvh/surface_tree.hpp"

namespace fracture::test {
namespace {

using Corners = std::array<Vec3d, 3>;

TEST(DistanceOfSegments, KnowsEndsMiddlesAndParallels) {
  EXPECT_DOUBLE_EQ(distance_of_segments({-1, 0, 0}, {1, 0, 0}, {0, -1, 2}, {0, 1, 2}), 2);
  EXPECT_DOUBLE_EQ(distance_of_segments({-1, 0, 0}, {1, 0, 0}, {0, 3, 0}, {0, 7, 0}), 3);
  EXPECT_DOUBLE_EQ(distance_of_segments({0, 0, 0}, {1, 0, 0}, {4, 4, 0}, {5, 9, 0}), 5);
  EXPECT_DOUBLE_EQ(distance_of_segments({0, 0, 0}, {4, 0, 0}, {1, 3, 0}, {9, 3, 0}), 3) << "side by side";
  EXPECT_DOUBLE_EQ(distance_of_segments({0, 0, 0}, {1, 0, 0}, {9, 6, 0}, {4, 4, 0}), 5);
  EXPECT_DOUBLE_EQ(distance_of_segments({0, 0, 0}, {4, 0, 0}, {7, 0, 0}, {9, 0, 0}), 3) << "in one line";
  EXPECT_DOUBLE_EQ(distance_of_segments({0, 0, 0}, {4, 0, 0}, {2, 3, 0}, {2, 3, 0}), 3) << "a point";
  EXPECT_DOUBLE_EQ(distance_of_segments({2, 3, 0}, {2, 3, 0}, {0, 0, 0}, {4, 0, 0}), 3);
  EXPECT_DOUBLE_EQ(distance_of_segments({0, 0, 0}, {0, 0, 0}, {3, 4, 0}, {3, 4, 0}), 5) << "two points";
}

TEST(AreWithin, WhereOnePiercesTheOtherFarFromCornersAndEdges) {
  const Corners flat{{{-9, -9, 0}, {9, -9, 0}, {0, 9, 0}}}, spike{{{0, 0, -5}, {0.1, 0, 5}, {0, 0.1, 5}}};
  EXPECT_TRUE(are_within(flat, spike, 0.01));
  EXPECT_TRUE(are_within(spike, flat, 0.01));
  const Corners beside{{{9, 9, -5}, {9.1, 9, 5}, {9, 9.1, 5}}};
  EXPECT_FALSE(are_within(flat, beside, 0.01));
}

TEST(DistanceOfTriangles, IsZeroWhereTheyCross) {
  const Corners flat{{{-9, -9, 0}, {9, -9, 0}, {0, 9, 0}}}, through{{{0, 0, -5}, {0.1, 0, 5}, {0, 0.1, 5}}};
  EXPECT_EQ(distance_of_triangles(flat, through, 1), 0);
  EXPECT_EQ(distance_of_triangles(through, flat, 1), 0);
}

TEST(AreWithin, AgreesWithPlacesOfBoth) {
  Random random(3);
  const auto place = [&](double x) -> Vec3d {
    return {x + random.uniform(), random.uniform(), random.uniform()};
  };
  int apart = 0;
  for (int n = 0; n < 300; ++n) {
    const Corners s{place(0), place(0), place(0)}, t{place(0.7), place(0.7), place(0.7)};
    constexpr int kParts = 60;
    double least = HUGE_VAL;
    for (int i = 0; i <= kParts; ++i)
      for (int j = 0; i + j <= kParts; ++j) {
        const double u = 1.0 * i / kParts, v = 1.0 * j / kParts;
        const Vec3d p = u * s[0] + v * s[1] + (1 - u - v) * s[2];
        least = std::fmin(least, distance_to_triangle(p, t[0], t[1], t[2]));
      }
    // Every point of the triangles has a sampled point closer than this.
    const double between = 1.8 / kParts;
    EXPECT_TRUE(are_within(s, t, least + 1e-9)) << n;
    const double distance = distance_of_triangles(s, t, 9);
    EXPECT_LE(distance, least + 1e-9) << n;
    EXPECT_GE(distance, least - between) << n;
    EXPECT_TRUE(are_within(s, t, distance + 1e-9)) << n;
    EXPECT_EQ(distance_of_triangles(s, t, 0.5 * distance), 0.5 * distance) << n;
    if (least < 2 * between) continue;
    EXPECT_FALSE(are_within(s, t, least - between)) << n;
    ++apart;
  }
  EXPECT_GT(apart, 50);
}

}  // namespace
}  // namespace fracture::test
