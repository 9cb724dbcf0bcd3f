// Pictures in memory: decodes textures (PNG, JPEG), writes PNG, and does the little that contact sheets need.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/base/error.hpp"

namespace fracture::render {

using Color = std::array<std::uint8_t, 4>;  ///< red, green, blue, alpha; sRGB unless stated otherwise

/// Rows from the top, pixels from the left, no padding.
struct Picture {
  int width = 0, height = 0;
  std::vector<Color> pixels;

  Picture() = default;
  Picture(int w, int h, Color fill = {0, 0, 0, 255})
      : width(w), height(h), pixels(static_cast<std::size_t>(w) * static_cast<std::size_t>(h), fill) {}
  Color& at(int x, int y) {
    return pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                  static_cast<std::size_t>(x)];
  }
  const Color& at(int x, int y) const {
    return pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                  static_cast<std::size_t>(x)];
  }
};

inline constexpr int kMaxPictureSide = 16384;  ///< pixels; for decoded textures and written pictures

/// Decodes PNG or JPEG; grey and palette become RGBA. kBadImage with the reason, kTooLarge beyond
/// kMaxPictureSide.
Expected<Picture> decode_picture(std::span<const std::uint8_t> bytes);

/// Returns kBadParameter if the path is a device, a pipe, a socket, or a file that is not empty and not a PNG. A picture would
/// replace it. Returns kFileAccess if the folder cannot be written to, or if the path is a folder.
Expected<void> may_write_png(const std::string& path);

/// Writes an 8-bit RGB PNG (alpha is dropped), completely or not at all. kBadImage, and the errors of may_write_png().
Expected<void> write_png(const Picture& picture, const std::string& path);

/// Copies `from` into `to` with its upper left corner at (x, y). Anything outside is cut off.
void paste(Picture& to, const Picture& from, int x, int y);

/// Averages blocks of factor × factor pixels in linear light. The sides must be divisible by the factor.
Picture downsample(const Picture& picture, int factor);

}  // namespace fracture::render
