#include "common/gltf/png.hpp"

#include <zlib.h>

#include <string_view>

#include "common/base/error.hpp"

namespace fracture {
namespace {

void append_number(std::vector<std::uint8_t>& out, std::uint32_t value) {
  for (const int shift : {24, 16, 8, 0}) out.push_back(static_cast<std::uint8_t>(value >> shift));
}

void append_chunk(std::vector<std::uint8_t>& out, std::string_view type, std::span<const std::uint8_t> data) {
  append_number(out, static_cast<std::uint32_t>(data.size()));
  const std::size_t checked = out.size();
  out.insert(out.end(), type.begin(), type.end());
  out.insert(out.end(), data.begin(), data.end());
  append_number(out, static_cast<std::uint32_t>(
                         ::crc32(0, out.data() + checked, static_cast<uInt>(out.size() - checked))));
}

}  // namespace

std::vector<std::uint8_t> write_png(std::span<const std::array<std::uint8_t, 3>> pixels, std::uint32_t width,
                                    std::uint32_t height) {
  constexpr std::uint8_t kDifferenceToTheLeft = 1;
  std::vector<std::uint8_t> rows;
  rows.reserve(std::size_t{height} * (1 + 3 * std::size_t{width}));
  for (std::uint32_t y = 0; y < height; ++y) {
    rows.push_back(kDifferenceToTheLeft);
    std::array<std::uint8_t, 3> left{};
    for (std::uint32_t x = 0; x < width; ++x) {
      const std::array<std::uint8_t, 3>& pixel = pixels[std::size_t{y} * width + x];
      for (std::size_t k = 0; k < 3; ++k) rows.push_back(static_cast<std::uint8_t>(pixel[k] - left[k]));
      left = pixel;
    }
  }
  uLongf size = ::compressBound(static_cast<uLong>(rows.size()));
  std::vector<std::uint8_t> packed(size);
  if (::compress2(packed.data(), &size, rows.data(), static_cast<uLong>(rows.size()), 9) != Z_OK)
    throw InternalError("zlib could not compress an image");
  packed.resize(size);

  std::vector<std::uint8_t> out{0x89, 'P', 'N', 'G', 0x0d, 0x0a, 0x1a, 0x0a}, head;
  append_number(head, width);
  append_number(head, height);
  for (const int value : {8, 2, 0, 0, 0}) head.push_back(static_cast<std::uint8_t>(value));  // 8 bits, RGB
  append_chunk(out, "IHDR", head);
  append_chunk(out, "IDAT", packed);
  append_chunk(out, "IEND", {});
  return out;
}

}  // namespace fracture
