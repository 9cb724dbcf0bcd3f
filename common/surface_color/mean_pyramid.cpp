#include "common/surface_color/mean_pyramid.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/srgb.hpp"

namespace fracture {
namespace {

std::array<std::uint16_t, 256> linear_table() {
  std::array<std::uint16_t, 256> table{};
  for (std::size_t k = 0; k < table.size(); ++k) {
    const double s = static_cast<double>(k) / 255.0;
    // No value is so close to a half that the last bits of pow(), which differ between C libraries, could
    // matter.
    table[k] = static_cast<std::uint16_t>(std::nearbyint(linear_of_srgb(s) * 65535));
  }
  return table;
}

}  // namespace

std::uint16_t linear_light(std::uint8_t srgb) {
  static const std::array<std::uint16_t, 256> table = linear_table();
  return table[srgb];
}

MeanPyramid::MeanPyramid(Pixels pixels, bool weigh_opacity)
    : image_(std::move(pixels)), weigh_opacity_(weigh_opacity) {
  while ((width() - 1) >> means_.size() > 0 || (height() - 1) >> means_.size() > 0)
    means_.push_back(half_of(means_.size()));
}

MeanPyramid::Texel MeanPyramid::at(std::size_t level, std::uint32_t x, std::uint32_t y) const {
  if (level > 0) {
    const Level& mean = means_[level - 1];
    return mean.texels[std::size_t{y} * mean.width + x];
  }
  const auto [red, green, blue, opacity] = image_.at(x, y);
  return {{linear_light(red), linear_light(green), linear_light(blue)},
          static_cast<std::uint16_t>(weigh_opacity_ ? opacity + 1 : 256)};
}

MeanPyramid::Level MeanPyramid::half_of(std::size_t level) const {
  const std::uint32_t w = ((width() - 1) >> level) + 1, h = ((height() - 1) >> level) + 1;
  // Texels at the right and bottom may represent fewer pixels.
  const auto pixels = [&](std::uint32_t at, std::uint32_t all) {
    return std::uint64_t{std::min(all - (at << level), 1u << level)};
  };
  Level half{(w + 1) / 2, (h + 1) / 2, {}};
  half.texels.reserve(std::size_t{half.width} * half.height);
  for (std::uint32_t y = 0; y < half.height; ++y)
    for (std::uint32_t x = 0; x < half.width; ++x) {
      std::uint64_t sum[3] = {}, weights = 0, count = 0;
      for (std::uint32_t row = 2 * y; row < std::min(2 * y + 2, h); ++row)
        for (std::uint32_t column = 2 * x; column < std::min(2 * x + 2, w); ++column) {
          const Texel texel = at(level, column, row);
          const std::uint64_t here = pixels(column, width()) * pixels(row, height()),
                              weight = here * texel.weight;
          for (int k = 0; k < 3; ++k) sum[k] += weight * texel.color[k];
          weights += weight;
          count += here;
        }
      Texel& mean = half.texels.emplace_back();
      for (int k = 0; k < 3; ++k)
        mean.color[k] = static_cast<std::uint16_t>((sum[k] + weights / 2) / weights);
      mean.weight = static_cast<std::uint16_t>(std::max<std::uint64_t>(1, (weights + count / 2) / count));
    }
  return half;
}

}  // namespace fracture
