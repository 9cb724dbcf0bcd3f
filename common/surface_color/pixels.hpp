// Images as pixels: PNG and JPEG, by libstb, whose decoders give the same pixels on every machine.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

namespace fracture {

/// Rows from the top; a pixel is sRGB red, green, blue and linear opacity.
class Pixels {
 public:
  /// `values`: 4 * width * height bytes, from malloc.
  Pixels(std::uint32_t width, std::uint32_t height, std::uint8_t* values)
      : width_(width), height_(height), values_(values) {}

  std::uint32_t width() const { return width_; }
  std::uint32_t height() const { return height_; }
  std::array<std::uint8_t, 4> at(std::uint32_t x, std::uint32_t y) const {
    const std::uint8_t* p = values_.get() + 4 * (std::size_t{y} * width_ + x);
    return {p[0], p[1], p[2], p[3]};
  }

 private:
  struct Free {
    void operator()(std::uint8_t* values) const;
  };
  std::uint32_t width_, height_;
  std::unique_ptr<std::uint8_t[], Free> values_;
};

/// How many pixels a PNG or JPEG says it has; nothing for what is neither. Reads its head alone.
std::optional<std::uint64_t> pixel_count(std::span<const std::uint8_t> image);

/// Nothing for an image that is damaged, of another kind, or holds more than its pixels are worth (a PNG that inflates
/// to more than its rows, a JPEG of more than 64 scans). Throws std::bad_alloc.
std::optional<Pixels> decode_image(std::span<const std::uint8_t> image);

}  // namespace fracture
