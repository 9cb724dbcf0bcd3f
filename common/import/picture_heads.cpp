#include "common/import/picture_heads.hpp"

#include <algorithm>
#include <cstring>
#include <string_view>

#include "common/base/pacer.hpp"
#include "common/base/polled_search.hpp"

namespace fracture {
namespace {

std::uint64_t byte_at(std::string_view bytes, std::size_t at) {
  return static_cast<unsigned char>(bytes[at]);
}
std::uint64_t short_at(std::string_view bytes, std::size_t at) {
  return byte_at(bytes, at) << 8 | byte_at(bytes, at + 1);
}

/// Bytes with which files of a kind begin. Each is looked for as a whole, because its first byte alone may fill a file.
constexpr std::string_view kPngMagic = "\x89PNG\r\n\x1a\n", kJpegMagic = "\xff\xd8\xff";

/// PNG specification, 11.2.2: the size is in the first chunk.
std::uint64_t pixels_of_png(std::string_view png) {
  if (png.size() < 24) return 0;
  const auto side = [&](std::size_t at) { return short_at(png, at) << 16 | short_at(png, at + 2); };
  return side(16) * side(20);
}

/// ITU-T T.81, B.1 and B.2.2: skip segments up to the frame header. `steps`: number of segments that may still be skipped in
/// the whole file. Other data can look like a head at each sixth byte, each with many segments.
std::uint64_t pixels_of_jpeg(std::string_view jpeg, std::uint64_t& steps, Pacer& pacer) {
  constexpr int kMostSegments = 1000;
  std::size_t at = 2;
  for (int segment = 0; segment < kMostSegments && steps > 0 && at + 9 <= jpeg.size(); ++segment, --steps) {
    pacer.step();
    if (byte_at(jpeg, at) != 0xff) return 0;
    const std::uint64_t marker = byte_at(jpeg, at + 1);
    const bool frame = marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
    if (frame) return short_at(jpeg, at + 5) * short_at(jpeg, at + 7);
    at += 2 + static_cast<std::size_t>(short_at(jpeg, at + 2));
  }
  return 0;
}

/// The maximum of pixels_of(rest), where rest begins at any occurrence of the magic bytes.
template <class PixelsOf>
std::uint64_t largest(std::string_view bytes, std::string_view magic, const Execution& execution,
                      const PixelsOf& pixels_of) {
  std::uint64_t most = 0;
  PolledSearch heads(bytes, magic, execution);
  for (std::size_t at = heads.find(0); at != PolledSearch::kNone; at = heads.find(at + 1))
    most = std::max(most, pixels_of(bytes.substr(at)));
  return most;
}

}  // namespace

std::uint64_t largest_picture(std::span<const std::byte> bytes, const Execution& execution) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  constexpr std::uint64_t kMostSteps = 1'000'000;
  std::uint64_t steps = kMostSteps;
  Pacer pacer(execution);
  const auto of_jpeg = [&](std::string_view jpeg) { return pixels_of_jpeg(jpeg, steps, pacer); };
  return std::max(largest(text, kPngMagic, execution, pixels_of_png),
                  largest(text, kJpegMagic, execution, of_jpeg));
}

}  // namespace fracture
