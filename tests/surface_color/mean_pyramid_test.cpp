#include "common/surface_color/mean_pyramid.hpp"

#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "tests/surface_color/pictures.hpp"

namespace fracture {
namespace {

using test::png;

Pixels decoded(const std::vector<std::uint8_t>& image) { return std::move(decode_image(image).value()); }

TEST(Pixels, ADamagedOrForeignImageGivesNothing) {
  const std::vector<std::uint8_t> good = png(3, 2, [](int x, int y) { return std::array{x, y, 7, 255}; });
  EXPECT_EQ(pixel_count(good), 6u);
  const Pixels pixels = decoded(good);
  EXPECT_EQ(pixels.width(), 3u);
  EXPECT_EQ(pixels.at(1, 1), (std::array<std::uint8_t, 4>{1, 1, 7, 255}));
  EXPECT_FALSE(decode_image(std::span(good).first(good.size() / 2)));
  // Formats that libstb could also read, with parsers that are not needed here.
  const std::string gif("GIF89a\x01\0\x01\0\0\0\0;", 14),
      hdr = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n....";
  for (const std::string& foreign : {gif, hdr, std::string("RIFF"), std::string()}) {
    const std::vector<std::uint8_t> bytes(foreign.begin(), foreign.end());
    EXPECT_FALSE(pixel_count(bytes)) << foreign;
    EXPECT_FALSE(decode_image(bytes)) << foreign;
  }
}

TEST(Pixels, APngThatInflatesToMoreThanItsRowsIsNotRead) {
  std::vector<std::uint8_t> bomb = png(512, 512, [](int, int) { return std::array{0, 0, 0, 255}; });
  ASSERT_TRUE(decode_image(bomb));
  bomb[18] = bomb[22] = 0;  // 512 becomes 0: the low bytes state one pixel
  bomb[19] = bomb[23] = 1;
  EXPECT_EQ(pixel_count(bomb), 1u);
  EXPECT_FALSE(decode_image(bomb));
}

// IEC 61966-2-1: the ends, the linear part, and half the light at 188.
TEST(MeanPyramid, LightIsLinear) {
  EXPECT_EQ(linear_light(0), 0);
  EXPECT_EQ(linear_light(255), 65535);
  EXPECT_EQ(linear_light(10), 199);  // 10 / 255 / 12.92 * 65535
  EXPECT_NEAR(linear_light(188) / 65535.0, 0.5, 0.005);
}

TEST(MeanPyramid, EachLevelIsTheMeanOfTheOneBelow) {
  const MeanPyramid pyramid(decoded(png(4, 4,
                                        [](int x, int) {
                                          const int v = x < 2 ? 255 : 0;
                                          return std::array{v, v, v, 255};
                                        })),
                            false);
  ASSERT_EQ(pyramid.levels(), 3u);
  EXPECT_EQ(pyramid.over(1, 1, 1).color, (LinearColor{65535, 65535, 65535}));
  EXPECT_EQ(pyramid.over(1, 2, 3).color, (LinearColor{0, 0, 0}));
  EXPECT_EQ(pyramid.over(2, 3, 0).color, (LinearColor{32768, 32768, 32768})) << "of light, not of bytes";
}

TEST(MeanPyramid, SidesThatAreNoPowersOfTwoCountWhole) {
  const MeanPyramid pyramid(decoded(png(5, 3,
                                        [](int x, int y) {
                                          const int v = x == 4 && y == 2 ? 255 : 0;
                                          return std::array{v, 0, 0, 255};
                                        })),
                            false);
  ASSERT_EQ(pyramid.levels(), 4u);
  EXPECT_EQ(pyramid.over(1, 4, 2).color[0], 65535);
  EXPECT_NEAR(pyramid.over(3, 0, 0).color[0], 65535 / 15, 1) << "one of fifteen";
}

TEST(MeanPyramid, WhatIsTransparentCountsLittleWhereOpacityCounts) {
  const std::vector<std::uint8_t> image = png(2, 1, [](int x, int) {
    return x == 0 ? std::array{255, 0, 0, 255} : std::array{0, 255, 0, 0};
  });
  EXPECT_NEAR(MeanPyramid(decoded(image), true).over(1, 0, 0).color[0], 65535, 300);
  EXPECT_NEAR(MeanPyramid(decoded(image), false).over(1, 0, 0).color[0], 32768, 1);
}

}  // namespace
}  // namespace fracture
