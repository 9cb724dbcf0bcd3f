#include "common/base/srgb.hpp"

#include <gtest/gtest.h>

namespace fracture {
namespace {

TEST(Srgb, IsStraightNearBlackAndACurveAbove) {
  // IEC 61966-2-1, by hand: 0.04045 / 12.92 = 0.0031308, and ((0.5 + 0.055) / 1.055)^2.4 = 0.526066^2.4 = 0.214041.
  EXPECT_EQ(linear_of_srgb(0), 0);
  EXPECT_NEAR(linear_of_srgb(0.04045), 0.0031308, 1e-7);
  EXPECT_NEAR(linear_of_srgb(0.5), 0.214041, 1e-6);
  EXPECT_NEAR(linear_of_srgb(1), 1, 1e-15);
  EXPECT_EQ(srgb_of_linear(0), 0);
  EXPECT_NEAR(srgb_of_linear(0.001), 0.01292, 1e-12);
  EXPECT_NEAR(srgb_of_linear(0.214041), 0.5, 1e-6);
  EXPECT_NEAR(srgb_of_linear(1), 1, 1e-15);
}

TEST(Srgb, TheTwoDirectionsAreInverse) {
  for (int byte = 0; byte < 256; ++byte)
    EXPECT_NEAR(srgb_of_linear(linear_of_srgb(byte / 255.0)), byte / 255.0, 1e-7) << byte;
}

}  // namespace
}  // namespace fracture
