// The offset that is subtracted from positions far from the origin.
#include "common/import/file_positions.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace fracture::test {
namespace {

Box box_of(const Vec3d& low, const Vec3d& high) {
  Box box;
  box.add(low);
  box.add(high);
  return box;
}

TEST(FilePositions, NearTheOriginThereIsNoOffset) {
  EXPECT_EQ(offset_for(Box{}), Vec3d{});
  EXPECT_EQ(offset_for(box_of({1, 2, 3}, {1, 2, 3})), Vec3d{}) << "a point has no extent";
  EXPECT_EQ(offset_for(box_of({-1, -1, -1}, {1, 1, 1})), Vec3d{});
  EXPECT_EQ(offset_for(box_of({1e6, 0, 0}, {3e6, 1, 1})), Vec3d{}) << "far, but as large";
  // Floats of 2^k to 2^(k + 1) are 2^(k - 23) apart, so rounding moves them by at most 2^(k - 24). For a side of 1, this is a
  // millionth between k = 4 (9.5e-7) and k = 5 (1.9e-6).
  EXPECT_EQ(offset_for(box_of({30, 0, 0}, {31, 1, 1})), Vec3d{});
  EXPECT_EQ(offset_for(box_of({32, 0, 0}, {33, 1, 1})), (Vec3d{32, 0, 0}));
}

TEST(FilePositions, TheOffsetIsTheRoundedCentre) {
  // A side of 3 m: multiples of 4 m. The centre is (500001.5, -31, 4649777.5).
  EXPECT_EQ(offset_for(box_of({500000, -32, 4649776}, {500003, -30, 4649779})),
            (Vec3d{500000, -32, 4649776}));
  EXPECT_FALSE(std::signbit(offset_for(box_of({-1e6, -1, -1}, {-1e6 + 1, 0, 0})).y)) << "never -0";
}

TEST(FilePositions, EveryOffsetIsAFloatAndLeavesExactPositions) {
  for (const double side : {1e-9, 1e-3, 1.0, 1000.0, 12345.678})
    for (const double far : {1e3, 500000.7, 4649776.3, 1e9, 1e15, 3e30}) {
      const Vec3d low{far, -far, 0.1 * far};
      const Vec3d offset = offset_for(box_of(low, low + Vec3d{side, side, side}));
      for (int axis = 0; axis < 3; ++axis) {
        EXPECT_EQ(offset[axis], static_cast<double>(static_cast<float>(offset[axis]))) << side << ' ' << far;
        if (offset == Vec3d{}) continue;
        // At most half a step from the centre, so the rest is small whatever the distance was.
        const double step = std::fmax(2 * side, std::ldexp(far, -22));
        EXPECT_LE(std::fabs(low[axis] + side / 2 - offset[axis]), step) << side << ' ' << far;
      }
    }
}

TEST(FilePositions, OnlyPositionsInUseDetermineTheOffset) {
  FilePositions positions;
  positions.add({500000.25, 0, 0});
  positions.add({500001.25, 0, 0});
  positions.add({0, 0, 0});
  positions.add({HUGE_VAL, 0, 0});
  positions.use(0);
  positions.use(1);
  EXPECT_EQ(positions.offset(), (Vec3d{500000, 0, 0}));
  const std::vector<Vec3f> floats = positions.rounded(positions.offset());
  EXPECT_EQ(floats[0], (Vec3f{0.25f, 0, 0}));
  EXPECT_EQ(floats[1], (Vec3f{1.25f, 0, 0}));
  EXPECT_EQ(floats[3], Vec3f{}) << "it does not fit";
  EXPECT_EQ(positions.rounded({})[0], (Vec3f{500000.25f, 0, 0}));
}

TEST(FilePositions, WithoutAnOffsetEveryBitIsKept) {
  FilePositions positions;
  positions.add({-0.0, 0.1, 1e-50});
  const Vec3f p = positions.rounded({})[0];
  EXPECT_TRUE(std::signbit(p.x));
  EXPECT_EQ(p, (Vec3f{0, 0.1f, 0}));
}

TEST(FilePositions, FitsAreNumbersUpToTheLargestFloat) {
  EXPECT_TRUE(FilePositions::fits({3.4028234e38, -3.4028234e38, 0}));
  for (const double bad : {3.5e38, -3.5e38, HUGE_VAL, std::nan("")})
    EXPECT_FALSE(FilePositions::fits({0, bad, 0})) << bad;
}

}  // namespace
}  // namespace fracture::test
