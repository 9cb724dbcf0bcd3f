// Small images for tests, as files.
#pragma once

#include <stb/stb_image_write.h>

#include <array>
#include <cstdint>
#include <vector>

namespace fracture::test {

/// A PNG. `pixel(x, y)` returns its red, green, blue and opacity.
template <class Pixel>
std::vector<std::uint8_t> png(int width, int height, const Pixel& pixel) {
  std::vector<std::uint8_t> rgba, file;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const std::array<int, 4> value = pixel(x, y);
      rgba.insert(rgba.end(), value.begin(), value.end());
    }
  const auto append = [](void* to, void* data, int size) {
    const auto* at = static_cast<const std::uint8_t*>(data);
    static_cast<std::vector<std::uint8_t>*>(to)->insert(static_cast<std::vector<std::uint8_t>*>(to)->end(),
                                                        at, at + size);
  };
  stbi_write_png_to_func(append, &file, width, height, 4, rgba.data(), 4 * width);
  return file;
}

}  // namespace fracture::test
