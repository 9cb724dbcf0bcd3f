#include "common/gltf/image_bytes.hpp"

#include <algorithm>
#include <span>
#include <string_view>

namespace fracture {
namespace {

using Bytes = std::span<const std::uint8_t>;

constexpr std::uint8_t kSignature[8] = {0x89, 'P', 'N', 'G', 0x0d, 0x0a, 0x1a, 0x0a};

std::size_t big_endian(Bytes bytes) {
  return std::size_t{bytes[0]} << 24 | std::size_t{bytes[1]} << 16 | std::size_t{bytes[2]} << 8 | bytes[3];
}

/// Whether glTF readers must ignore the chunk. Chunks: PNG specification, 11.3.2 and 11.3.4.3.
bool to_be_ignored(std::string_view type, Bytes data) {
  if (type == "iCCP") return true;
  if (type == "gAMA") return data.size() != 4 || big_endian(data) != 45455;
  if (type == "pHYs") return data.size() != 9 || big_endian(data) != big_endian(data.subspan(4));
  if (type != "cHRM") return false;
  // White point and primaries of sRGB in units of 1/100,000 (PNG, 4.3).
  constexpr std::size_t kSrgb[8] = {31270, 32900, 64000, 33000, 30000, 60000, 15000, 6000};
  if (data.size() != 32) return true;
  for (std::size_t k = 0; k < 8; ++k)
    if (big_endian(data.subspan(4 * k)) != kSrgb[k]) return true;
  return false;
}

}  // namespace

std::vector<Bytes> image_pieces(Bytes bytes, Pacer& pacer) {
  std::vector<Bytes> pieces;
  std::size_t at = 8, kept = 0;  // [kept, at) is a piece
  if (bytes.size() >= at && std::equal(kSignature, kSignature + 8, bytes.begin()))
    while (bytes.size() - at >= 12) {  // length, type, data, checksum
      pacer.step();
      const std::size_t length = big_endian(bytes.subspan(at));
      if (length > bytes.size() - at - 12) break;
      const std::string_view type(reinterpret_cast<const char*>(&bytes[at + 4]), 4);
      if (type == "IDAT") break;  // chunks to ignore come before the pixels
      const std::size_t next = at + 12 + length;
      if (to_be_ignored(type, bytes.subspan(at + 8, length))) {
        if (at > kept) pieces.push_back(bytes.subspan(kept, at - kept));
        kept = next;
      }
      at = next;
    }
  if (bytes.size() > kept) pieces.push_back(bytes.subspan(kept));
  return pieces;
}

}  // namespace fracture
