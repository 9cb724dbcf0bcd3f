#include "common/gltf/cut_detail.hpp"

#include <gtest/gtest.h>
#include <stb/stb_image.h>

#include <cmath>

#include "common/gltf/png.hpp"

namespace fracture {
namespace {

using Pixel = std::array<std::uint8_t, 3>;

std::vector<Pixel> decoded(const std::vector<std::uint8_t>& png, int& width, int& height) {
  int channels = 0;
  stbi_uc* data =
      stbi_load_from_memory(png.data(), static_cast<int>(png.size()), &width, &height, &channels, 3);
  EXPECT_NE(data, nullptr) << stbi_failure_reason();
  EXPECT_EQ(channels, 3);
  std::vector<Pixel> pixels;
  for (int k = 0; data != nullptr && k < width * height; ++k)
    pixels.push_back({data[3 * k], data[3 * k + 1], data[3 * k + 2]});
  stbi_image_free(data);
  return pixels;
}

TEST(Png, IsReadBackAsItWas) {
  std::vector<Pixel> pixels;
  for (int k = 0; k < 7 * 5; ++k)
    pixels.push_back({static_cast<std::uint8_t>(k * 37), static_cast<std::uint8_t>(255 - k), 0});
  int width = 0, height = 0;
  EXPECT_EQ(decoded(write_png(pixels, 7, 5), width, height), pixels);
  EXPECT_EQ(width, 7);
  EXPECT_EQ(height, 5);
}

TEST(CutDetail, NormalsAreUnitPointOutwardsAndRepeat) {
  for (const CutDetail detail :
       {CutDetail::kStone, CutDetail::kConcrete, CutDetail::kWood, CutDetail::kBrick}) {
    SCOPED_TRACE(kCutDetailNames[static_cast<std::size_t>(detail)]);
    int width = 0, height = 0;
    const std::vector<Pixel> pixels = decoded(detail_maps(detail).normal, width, height);
    ASSERT_EQ(pixels.size(), std::size_t{kDetailSide} * kDetailSide);
    double bend = 0, seam = 0, inner = 0, mean[2] = {};
    for (std::uint32_t y = 0; y < kDetailSide; ++y)
      for (std::uint32_t x = 0; x < kDetailSide; ++x) {
        const auto normal = [&](std::uint32_t column) {
          const Pixel& p = pixels[std::size_t{y} * kDetailSide + column];
          return std::array{p[0] / 127.5 - 1, p[1] / 127.5 - 1, p[2] / 127.5 - 1};
        };
        const auto n = normal(x);
        ASSERT_NEAR(n[0] * n[0] + n[1] * n[1] + n[2] * n[2], 1, 0.03);
        ASSERT_GT(n[2], 0);
        bend = std::max(bend, std::hypot(n[0], n[1]));
        mean[0] += n[0];
        mean[1] += n[1];
        if (x == 0) {
          seam += std::fabs(normal(kDetailSide - 1)[0] - n[0]);
          inner += std::fabs(normal(kDetailSide / 2 - 1)[0] - normal(kDetailSide / 2)[0]);
        }
      }
    EXPECT_GT(bend, 0.15) << "it is seen";
    EXPECT_LT(std::fabs(mean[0]) + std::fabs(mean[1]), 0.02 * kDetailSide * kDetailSide);
    EXPECT_LT(seam, 2 * inner + 1) << "no seam where it repeats";
  }
}

TEST(CutDetail, KindsDifferAndRoughnessIsGreen) {
  EXPECT_NE(detail_maps(CutDetail::kStone).normal, detail_maps(CutDetail::kBrick).normal);
  int width = 0, height = 0;
  for (const Pixel& p : decoded(detail_maps(CutDetail::kStone).roughness, width, height)) {
    ASSERT_EQ(p[0], 0);
    ASSERT_GT(p[1], 100);
    ASSERT_EQ(p[2], 0);
  }
}

}  // namespace
}  // namespace fracture
