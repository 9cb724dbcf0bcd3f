// Decodes images: PNG and JPEG with libstb, whose decoders give the same pixels on every machine, WebP (webp.hpp) and KTX2
// (ktx2.hpp).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

namespace fracture {

/// Rows from the top. A pixel is sRGB red, green and blue, and linear opacity.
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

/// Number of pixels that decode_image() returns; nothing for formats and encodings that it does not decode. Reads only the
/// header.
std::optional<std::uint64_t> pixel_count(std::span<const std::uint8_t> image);

/// Why pixel_count() returns nothing, after "because it ".
const char* why_unread(std::span<const std::uint8_t> image);

/// Decodes an image. Returns nothing if it is damaged, in another format, or contains more data than its
/// pixels need (a PNG that inflates to more than its rows, or a JPEG with more than 64 scans). Throws
/// std::bad_alloc.
std::optional<Pixels> decode_image(std::span<const std::uint8_t> image);

}  // namespace fracture
