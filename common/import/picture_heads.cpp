#include "common/import/picture_heads.hpp"

#include <algorithm>
#include <cstring>
#include <string_view>

namespace fracture {
namespace {

std::uint64_t byte_at(std::string_view bytes, std::size_t at) {
  return static_cast<unsigned char>(bytes[at]);
}
std::uint64_t short_at(std::string_view bytes, std::size_t at) {
  return byte_at(bytes, at) << 8 | byte_at(bytes, at + 1);
}

/// PNG specification, 11.2.2: the size is in the first chunk.
std::uint64_t pixels_of_png(std::string_view png) {
  constexpr std::string_view kMagic = "\x89PNG\r\n\x1a\n";
  if (png.size() < 24 || !png.starts_with(kMagic)) return 0;
  const auto side = [&](std::size_t at) { return short_at(png, at) << 16 | short_at(png, at + 2); };
  return side(16) * side(20);
}

/// ITU-T T.81, B.1 and B.2.2: skip segments up to the frame header. `steps`: number of segments that may still be skipped in
/// the whole file. Other data can look like a head at each sixth byte, each with many segments.
std::uint64_t pixels_of_jpeg(std::string_view jpeg, std::uint64_t& steps) {
  if (!jpeg.starts_with("\xff\xd8\xff")) return 0;
  constexpr int kMostSegments = 1000;
  std::size_t at = 2;
  for (int segment = 0; segment < kMostSegments && steps > 0 && at + 9 <= jpeg.size(); ++segment, --steps) {
    if (byte_at(jpeg, at) != 0xff) return 0;
    const std::uint64_t marker = byte_at(jpeg, at + 1);
    const bool frame = marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
    if (frame) return short_at(jpeg, at + 5) * short_at(jpeg, at + 7);
    at += 2 + static_cast<std::size_t>(short_at(jpeg, at + 2));
  }
  return 0;
}

/// The maximum of pixels_of(rest), where rest begins at any occurrence of the byte.
template <class PixelsOf>
std::uint64_t largest(std::string_view bytes, char first, const PixelsOf& pixels_of) {
  std::uint64_t most = 0;
  for (std::size_t at = bytes.find(first); at != bytes.npos; at = bytes.find(first, at + 1))
    most = std::max(most, pixels_of(bytes.substr(at)));
  return most;
}

}  // namespace

std::uint64_t largest_picture(std::span<const std::byte> bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  constexpr std::uint64_t kMostSteps = 1'000'000;
  std::uint64_t steps = kMostSteps;
  const auto of_jpeg = [&steps](std::string_view jpeg) { return pixels_of_jpeg(jpeg, steps); };
  return std::max(largest(text, '\x89', pixels_of_png), largest(text, '\xff', of_jpeg));
}

}  // namespace fracture
