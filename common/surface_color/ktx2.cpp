#include "common/surface_color/ktx2.hpp"

#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <new>
#include <string_view>
#include <vector>

namespace fracture {
namespace {

using Bytes = std::span<const std::uint8_t>;

constexpr std::string_view kMagic("\xabKTX 20\xbb\r\n\x1a\n", 12);
constexpr std::size_t kHeader = 80, kLevelEntry = 24;
constexpr std::uint64_t kMostPixels = 1u << 20;
constexpr std::size_t kBlock = 16;  // bytes of a UASTC block of 4 x 4 pixels

enum Supercompression : std::uint32_t { kNone = 0, kBasisLz = 1, kZstandard = 2, kZlib = 3 };
enum ColorModel : std::uint8_t { kEtc1s = 163, kUastc = 166 };  // Khronos Data Format Specification

/// Reads at most 8 little-endian bytes; zero beyond the end.
std::uint64_t number_at(Bytes bytes, std::size_t at, std::size_t size) {
  std::uint64_t value = 0;
  for (std::size_t k = size; k-- > 0;) value = value << 8 | (at + k < bytes.size() ? bytes[at + k] : 0);
  return value;
}

struct Ktx2Head {
  std::uint32_t format, width, height, depth, layers, faces, levels, supercompression;
  std::uint8_t model;
};

std::optional<Ktx2Head> ktx2_head_of(Bytes file) {
  if (!is_ktx2(file) || file.size() < kHeader) return std::nullopt;
  const auto word = [&](std::size_t at) { return static_cast<std::uint32_t>(number_at(file, at, 4)); };
  Ktx2Head head{word(12), word(20), word(24), word(28), word(32), word(36), std::max(word(40), 1u),
                word(44), 0};
  // The colour model is the first byte after the head of the first descriptor block.
  head.model = static_cast<std::uint8_t>(number_at(file, std::size_t{word(48)} + 12, 1));
  if (head.width == 0 || head.levels > 32 || kHeader + head.levels * kLevelEntry > file.size())
    return std::nullopt;
  head.height = std::max(head.height, 1u);
  return head;
}

/// Channels of an 8-bit format in the file, in their order; empty: another format. The numbers are VkFormat's.
std::string_view channels_of(std::uint32_t format) {
  switch (format) {
    case 23:
    case 29:
      return "rgb";
    case 30:
    case 36:
      return "bgr";
    case 37:
    case 43:
      return "rgba";
    case 44:
    case 50:
      return "bgra";
    default:
      return {};
  }
}

bool is_uastc(const Ktx2Head& head) { return head.format == 0 && head.model == kUastc; }

std::uint32_t side(std::uint32_t size, std::uint32_t level) { return std::max(size >> level, 1u); }
std::uint64_t pixels_of(const Ktx2Head& head, std::uint32_t level) {
  return std::uint64_t{side(head.width, level)} * side(head.height, level);
}

/// The level to read.
std::uint32_t level_of(const Ktx2Head& head) {
  std::uint32_t level = 0;
  if (is_uastc(head)) return head.levels - 1;
  while (level + 1 < head.levels && pixels_of(head, level) > kMostPixels) ++level;
  return level;
}

/// The bytes of a level, which must be `size`; nothing if the file is damaged.
std::optional<std::vector<std::uint8_t>> level_bytes(Bytes file, const Ktx2Head& head, std::uint32_t level,
                                                     std::size_t size) {
  const std::size_t entry = kHeader + level * kLevelEntry;
  const std::uint64_t at = number_at(file, entry, 8), length = number_at(file, entry + 8, 8);
  if (at > file.size() || length > file.size() - at) return std::nullopt;
  const Bytes stored = file.subspan(static_cast<std::size_t>(at), static_cast<std::size_t>(length));
  std::vector<std::uint8_t> bytes(size);
  switch (head.supercompression) {
    case kNone:
      if (stored.size() != size) return std::nullopt;
      std::copy(stored.begin(), stored.end(), bytes.begin());
      return bytes;
    case kZstandard:
      if (ZSTD_decompress(bytes.data(), size, stored.data(), stored.size()) != size) return std::nullopt;
      return bytes;
    default: {
      uLongf made = size;
      if (uncompress(bytes.data(), &made, stored.data(), stored.size()) != Z_OK || made != size)
        return std::nullopt;
      return bytes;
    }
  }
}

/// The smallest level of a UASTC texture: one block. Nothing if the file is damaged.
std::optional<std::vector<std::uint8_t>> last_block(Bytes file, const Ktx2Head& head) {
  return level_bytes(file, head, head.levels - 1, kBlock);
}

/// Why the encoding is not read; null if it is.
const char* objection_to(Bytes file, const Ktx2Head& head) {
  if (head.depth > 1 || head.layers > 1 || head.faces != 1) return "is a KTX2 texture with several images";
  if (head.supercompression == kBasisLz || (head.format == 0 && head.model == kEtc1s))
    return "is a KTX2 texture in BasisLZ (ETC1S), which only graphics libraries decode";
  if (head.supercompression > kZlib) return "is a KTX2 texture in an unknown compression";
  if (!is_uastc(head))
    return channels_of(head.format).empty()
               ? "is a KTX2 texture in a format that only graphics libraries decode"
               : nullptr;
  if ((std::max(head.width, head.height) >> (head.levels - 1)) > 1)
    return "is a KTX2 texture in UASTC without a mip level of 1 x 1";
  constexpr std::uint8_t kModeOfOneColor = 0x17, kModeMask = 0x1f;
  const auto block = last_block(file, head);
  return block && ((*block)[0] & kModeMask) != kModeOfOneColor
             ? "is a KTX2 texture in UASTC whose smallest level is not a single colour"
             : nullptr;
}

Pixels empty_pixels(std::uint32_t width, std::uint32_t height, std::uint8_t*& values) {
  values = static_cast<std::uint8_t*>(std::malloc(std::size_t{4} * width * height));
  if (values == nullptr) throw std::bad_alloc();
  return {width, height, values};
}

}  // namespace

bool is_ktx2(Bytes image) {
  return image.size() >= kMagic.size() && std::memcmp(image.data(), kMagic.data(), kMagic.size()) == 0;
}

std::optional<std::uint64_t> ktx2_pixel_count(Bytes ktx2) {
  const std::optional<Ktx2Head> head = ktx2_head_of(ktx2);
  if (!head || objection_to(ktx2, *head) != nullptr) return std::nullopt;
  return pixels_of(*head, level_of(*head));
}

const char* why_ktx2_is_unread(Bytes ktx2) {
  const std::optional<Ktx2Head> head = ktx2_head_of(ktx2);
  return head ? objection_to(ktx2, *head) : nullptr;
}

std::optional<Pixels> decode_ktx2(Bytes ktx2) {
  const std::optional<Ktx2Head> head = ktx2_head_of(ktx2);
  if (!head || objection_to(ktx2, *head) != nullptr) return std::nullopt;
  const std::uint32_t level = level_of(*head), width = side(head->width, level),
                      height = side(head->height, level);
  std::uint8_t* values = nullptr;
  if (is_uastc(*head)) {
    const auto block = last_block(ktx2, *head);
    if (!block) return std::nullopt;
    constexpr int kModeBits = 5;
    Pixels pixels = empty_pixels(1, 1, values);
    const std::uint64_t color = number_at(*block, 0, 8) >> kModeBits;
    for (std::size_t k = 0; k < 4; ++k) values[k] = static_cast<std::uint8_t>(color >> (8 * k));
    return pixels;
  }
  const std::string_view channels = channels_of(head->format);
  const std::size_t count = std::size_t{width} * height;
  if (count > kMostPixels * 16) return std::nullopt;
  const auto bytes = level_bytes(ktx2, *head, level, channels.size() * count);
  if (!bytes) return std::nullopt;
  Pixels pixels = empty_pixels(width, height, values);
  for (std::size_t p = 0; p < count; ++p) {
    values[4 * p + 3] = 255;
    for (std::size_t k = 0; k < channels.size(); ++k)
      values[4 * p + std::string_view("rgba").find(channels[k])] = (*bytes)[channels.size() * p + k];
  }
  return pixels;
}

}  // namespace fracture
