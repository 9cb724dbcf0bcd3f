#include "server/cache/entry.hpp"

#include <xxhash.h>

#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <memory>

#include "common/base/pacer.hpp"

namespace fracture {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr char kEntryMagic[4] = {'F', 'R', 'C', 'E'};
constexpr std::uint32_t kVersion = 1;
constexpr std::size_t kChecksumAt = 24;

using Checksum = std::array<char, 16>;

Checksum checksum(std::string_view before, std::string_view after, std::span<const std::uint8_t> payload,
                  const Execution& execution) {
  const std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state(XXH3_createState(), &XXH3_freeState);
  XXH3_128bits_reset(state.get());
  XXH3_128bits_update(state.get(), before.data(), before.size());
  XXH3_128bits_update(state.get(), after.data(), after.size());
  each_piece(execution, payload, [&state](std::span<const std::uint8_t> piece) {
    XXH3_128bits_update(state.get(), piece.data(), piece.size());
  });
  XXH128_canonical_t canonical;
  XXH128_canonicalFromHash(&canonical, XXH3_128bits_digest(state.get()));
  Checksum sum;
  static_assert(sizeof sum == sizeof canonical);
  std::memcpy(sum.data(), &canonical, sizeof sum);
  return sum;
}

template <class Number>
void put(std::string& out, Number number) {
  char bytes[sizeof number];
  std::memcpy(bytes, &number, sizeof number);
  out.append(bytes, sizeof number);
}

template <class Number>
Number get(std::span<const std::uint8_t> bytes, std::size_t at) {
  Number number;
  std::memcpy(&number, bytes.data() + at, sizeof number);
  return number;
}

}  // namespace

std::string encode_entry_head(const CacheEntry& entry) {
  std::string head(kEntryMagic, sizeof kEntryMagic);
  put(head, kVersion);
  put(head, static_cast<std::uint32_t>(entry.key.size()));
  put(head, static_cast<std::uint32_t>(entry.metadata.size()));
  put(head, static_cast<std::uint64_t>(entry.payload.size()));
  const std::string before = head;
  head.resize(kEntryHeader);
  head += entry.key;
  head += entry.metadata;
  const Checksum sum =
      checksum(before, std::string_view(head).substr(kEntryHeader), entry.payload, kUninterrupted);
  std::memcpy(head.data() + kChecksumAt, sum.data(), sum.size());
  return head;
}

std::optional<std::uint64_t> size_of_entry(std::span<const std::uint8_t> header) {
  if (header.size() < kEntryHeader || std::memcmp(header.data(), kEntryMagic, sizeof kEntryMagic) != 0 ||
      get<std::uint32_t>(header, 4) != kVersion)
    return std::nullopt;
  const std::uint64_t before = kEntryHeader + std::uint64_t{get<std::uint32_t>(header, 8)} +
                               get<std::uint32_t>(header, 12),
                      payload = get<std::uint64_t>(header, 16);
  if (payload > std::numeric_limits<std::uint64_t>::max() - before) return std::nullopt;
  return before + payload;
}

std::optional<CacheEntry> decode_entry(std::span<const std::uint8_t> bytes, std::string_view key,
                                       const Execution& execution) {
  if (size_of_entry(bytes) != bytes.size()) return std::nullopt;
  const std::uint64_t key_size = get<std::uint32_t>(bytes, 8), metadata_size = get<std::uint32_t>(bytes, 12),
                      payload_size = get<std::uint64_t>(bytes, 16);
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  CacheEntry entry{text.substr(kEntryHeader, key_size), text.substr(kEntryHeader + key_size, metadata_size),
                   bytes.last(payload_size)};
  if (entry.key != key) return std::nullopt;
  const Checksum sum =
      checksum(text.substr(0, kChecksumAt), text.substr(kEntryHeader, key_size + metadata_size),
               entry.payload, execution);
  if (std::memcmp(bytes.data() + kChecksumAt, sum.data(), sum.size()) != 0) return std::nullopt;
  return entry;
}

}  // namespace fracture
