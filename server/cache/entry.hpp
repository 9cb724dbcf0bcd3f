// The format of entries in the cache tiers below memory. It ensures that a damaged entry is never used: one from a process
// that was killed while writing, one with a flipped bit, or one that belongs to another key or program.
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

#include "common/base/execution.hpp"

namespace fracture {

/// An entry. After decoding, its members are views into the decoded bytes.
struct CacheEntry {
  std::string_view key;
  std::string_view metadata;
  std::span<const std::uint8_t> payload;
};

inline constexpr std::size_t kEntryHeader = 40;

/// Returns whether `bytes` may be held while an entry is read.
using Room = std::function<bool(std::uint64_t bytes)>;

/// Returns the header, the key and the metadata as bytes. The payload must be written after them.
std::string encode_entry_head(const CacheEntry& entry);

/// Returns the size of a whole entry from its first kEntryHeader bytes; nothing if they are not a header.
std::optional<std::uint64_t> size_of_entry(std::span<const std::uint8_t> header);

/// Decodes an entry. Returns nothing if the bytes are not exactly one intact entry with this key. Never reads beyond
/// `bytes`, whatever sizes they contain. Throws Interrupted.
std::optional<CacheEntry> decode_entry(std::span<const std::uint8_t> bytes, std::string_view key,
                                       const Execution& execution = kUninterrupted);

}  // namespace fracture
