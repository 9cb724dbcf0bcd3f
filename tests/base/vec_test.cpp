#include "common/base/vec.hpp"

#include <gtest/gtest.h>

namespace fracture {
namespace {

TEST(Box, IsEmptyUntilSomethingIsAdded) {
  Box box;
  EXPECT_TRUE(box.empty());
  EXPECT_EQ(box.size(), (Vec3d{0, 0, 0}));
  EXPECT_EQ(box.longest_side(), 0);
  box.add(Vec3d{1, 2, 3});
  EXPECT_FALSE(box.empty());
  EXPECT_EQ(box.size(), (Vec3d{0, 0, 0}));
  EXPECT_EQ(box.center(), (Vec3d{1, 2, 3}));
}

TEST(Box, AddingAnEmptyBoxChangesNothing) {
  Box box;
  box.add(Vec3d{1, 2, 3});
  const Box before = box;
  box.add(Box{});
  EXPECT_EQ(box.min, before.min);
  EXPECT_EQ(box.max, before.max);
}

TEST(Box, CoversWhatWasAdded) {
  Box box;
  for (const Vec3d& p : {Vec3d{0, 5, -1}, Vec3d{2, -3, 4}, Vec3d{1, 1, 1}}) box.add(p);
  EXPECT_EQ(box.min, (Vec3d{0, -3, -1}));
  EXPECT_EQ(box.max, (Vec3d{2, 5, 4}));
  EXPECT_EQ(box.longest_side(), 8);
}

TEST(Box, TouchingBoxesIntersect) {
  Box a, b, c;
  a.add(Vec3d{0, 0, 0});
  a.add(Vec3d{1, 1, 1});
  b.add(Vec3d{1, 1, 1});
  b.add(Vec3d{2, 2, 2});
  c.add(Vec3d{1.0000001, 0, 0});
  c.add(Vec3d{2, 2, 2});
  EXPECT_TRUE(a.intersects(b));
  EXPECT_TRUE(b.intersects(a));
  EXPECT_FALSE(a.intersects(c));
}

TEST(LexicographicLess, OrdersByXThenYThenZ) {
  EXPECT_TRUE(lexicographic_less({0, 9, 9}, {1, 0, 0}));
  EXPECT_TRUE(lexicographic_less({1, 0, 9}, {1, 1, 0}));
  EXPECT_TRUE(lexicographic_less({1, 1, 0}, {1, 1, 1}));
  EXPECT_FALSE(lexicographic_less({1, 1, 1}, {1, 1, 1}));
}

TEST(Cross, IsPerpendicularAndRightHanded) {
  EXPECT_EQ(cross({1, 0, 0}, {0, 1, 0}), (Vec3d{0, 0, 1}));
  const Vec3d a{1, 2, 3}, b{-2, 5, 7};
  EXPECT_EQ(dot(cross(a, b), a), 0);
  EXPECT_EQ(dot(cross(a, b), b), 0);
}

}  // namespace
}  // namespace fracture
