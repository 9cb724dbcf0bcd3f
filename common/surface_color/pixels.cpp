#include "common/surface_color/pixels.hpp"

#include <stb/stb_image.h>
#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <new>
#include <string_view>

#include "common/surface_color/ktx2.hpp"
#include "common/surface_color/webp.hpp"

namespace fracture {
namespace {

using Bytes = std::span<const std::uint8_t>;

constexpr std::string_view kPng = "\x89PNG\r\n\x1a\n", kJpeg = "\xff\xd8\xff";

bool begins_with(Bytes image, std::string_view magic) {
  return image.size() >= magic.size() && std::memcmp(image.data(), magic.data(), magic.size()) == 0;
}

struct Head {
  std::uint64_t width, height;
  bool png, wide;  ///< wide: 16 bits per channel
  std::uint64_t pixels() const { return width * height; }
};

std::optional<Head> head_of(Bytes image) {
  const bool png = begins_with(image, kPng);
  if (!png && !begins_with(image, kJpeg)) return std::nullopt;
  if (image.size() > static_cast<std::size_t>(std::numeric_limits<int>::max())) return std::nullopt;
  int width = 0, height = 0, channels = 0;
  const int size = static_cast<int>(image.size());
  if (stbi_info_from_memory(image.data(), size, &width, &height, &channels) == 0) return std::nullopt;
  if (width < 1 || height < 1) return std::nullopt;
  return Head{static_cast<std::uint64_t>(width), static_cast<std::uint64_t>(height), png,
              stbi_is_16_bit_from_memory(image.data(), size) != 0};
}

std::uint32_t big_endian(const std::uint8_t* p) {
  return std::uint32_t{p[0]} << 24 | std::uint32_t{p[1]} << 16 | std::uint32_t{p[2]} << 8 | p[3];
}

/// Whether the pixels of a PNG inflate to at most `most` bytes, because libstb inflates everything. Like
/// libstb, stops without an error at damaged data.
bool inflates_within(Bytes png, std::uint64_t most) {
  z_stream stream{};
  if (inflateInit(&stream) != Z_OK) throw std::bad_alloc();
  std::uint8_t out[16384];
  std::uint64_t sum = 0;
  int state = Z_OK;
  for (std::size_t at = kPng.size(); png.size() - at >= 12 && state == Z_OK && sum <= most;) {
    const std::size_t length = big_endian(&png[at]);
    if (length > png.size() - at - 12) break;
    if (std::memcmp(&png[at + 4], "IDAT", 4) == 0) {
      stream.next_in = const_cast<std::uint8_t*>(&png[at + 8]);  // zlib only reads it
      stream.avail_in = static_cast<uInt>(length);
      while (stream.avail_in > 0 && state == Z_OK && sum <= most) {
        stream.next_out = out;
        stream.avail_out = sizeof out;
        state = inflate(&stream, Z_NO_FLUSH);
        sum += sizeof out - stream.avail_out;
      }
    }
    at += 12 + length;
  }
  inflateEnd(&stream);
  return sum <= most;
}

/// Whether a JPEG has few scans. Each pass over a JPEG costs as much as the first.
bool has_few_scans(Bytes jpeg) {
  constexpr std::string_view kScan = "\xff\xda";
  constexpr int kMost = 64;
  const std::string_view text(reinterpret_cast<const char*>(jpeg.data()), jpeg.size());
  int scans = 0;
  for (std::size_t at = text.find(kScan); at != text.npos && scans <= kMost; at = text.find(kScan, at + 2))
    ++scans;
  return scans <= kMost;
}

bool is_worth_its_pixels(Bytes image, const Head& head) {
  if (!head.png) return has_few_scans(image);
  // Each row has one byte for the filter, and up to four channels. Interlaced images have shorter but more
  // rows.
  const std::uint64_t row = head.width * (head.wide ? 8 : 4) + 1;
  return inflates_within(image, 2 * row * head.height + 1024);
}

/// Throws std::bad_alloc if libstb would lack memory, because libstb does not always report it.
void require_memory(Bytes image, const Head& head) {
  const std::uint64_t for_each = !head.png ? 14 : head.wide ? 20 : 9;  // rows or coefficients, and result
  ::operator delete(
      ::operator new(static_cast<std::size_t>(for_each * head.pixels() + image.size() + (64 << 10))));
}

}  // namespace

void Pixels::Free::operator()(std::uint8_t* values) const { stbi_image_free(values); }

const char* why_unread(Bytes image) {
  const bool known =
      begins_with(image, kPng) || begins_with(image, kJpeg) || is_webp(image) || is_ktx2(image);
  if (!known) return "is neither PNG, JPEG, WebP nor KTX2";
  const char* const reason = is_ktx2(image) ? why_ktx2_is_unread(image) : nullptr;
  return reason ? reason : "has a damaged header, or is an animation";
}

std::optional<std::uint64_t> pixel_count(Bytes image) {
  if (is_webp(image)) return webp_pixel_count(image);
  if (is_ktx2(image)) return ktx2_pixel_count(image);
  const std::optional<Head> head = head_of(image);
  if (!head) return std::nullopt;
  return head->pixels();
}

std::optional<Pixels> decode_image(Bytes image) {
  if (is_webp(image)) return decode_webp(image);
  if (is_ktx2(image)) return decode_ktx2(image);
  const std::optional<Head> head = head_of(image);
  if (!head || !is_worth_its_pixels(image, *head)) return std::nullopt;
  require_memory(image, *head);
  int width = 0, height = 0, channels = 0;
  stbi_uc* values =
      stbi_load_from_memory(image.data(), static_cast<int>(image.size()), &width, &height, &channels, 4);
  if (values != nullptr)
    return Pixels(static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height), values);
  if (const char* reason = stbi_failure_reason(); reason != nullptr && std::string_view(reason) == "outofmem")
    throw std::bad_alloc();
  return std::nullopt;
}

}  // namespace fracture
