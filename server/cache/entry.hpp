// How the tiers below memory write a value down, so that a damaged one is never taken for a good one: a
// process killed in mid-write, a flipped bit, a file of another key or of another program.
//
//   offset  bytes
//        0      4  "FRCE"
//        4      4  layout version, 1
//        8      4  k, bytes of the key
//       12      4  m, bytes of the metadata
//       16      8  p, bytes of the payload
//       24     16  XXH3 (128 bits, xxHash 0.8) of everything else, in order
//       40      k  key, then m bytes of metadata, then p bytes of payload, then the end
//
// Numbers are little-endian.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace fracture {

/// Views into the bytes that were decoded.
struct CacheEntry {
  std::string_view key;
  std::string_view metadata;
  std::span<const std::uint8_t> payload;
};

inline constexpr std::size_t kEntryHeader = 40;

/// Whether so many bytes may be held while an entry is read.
using Room = std::function<bool(std::uint64_t bytes)>;

/// Header, key and metadata; the payload has to be written behind it.
std::string encode_entry_head(const CacheEntry& entry);

/// How large the whole entry is by its first kEntryHeader bytes; nothing when they are no such header.
std::optional<std::uint64_t> size_of_entry(std::span<const std::uint8_t> header);

/// Nothing when the bytes are not exactly one intact entry of this key. Reads nothing beyond `bytes`,
/// whatever they say.
std::optional<CacheEntry> decode_entry(std::span<const std::uint8_t> bytes, std::string_view key);

}  // namespace fracture
