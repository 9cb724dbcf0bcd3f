// SHA-256 (OpenSSL), for mesh digests, cache keys, fragment ids, and the hashes that determinism tests
// compare.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/execution.hpp"

namespace fracture {

struct Digest {
  std::array<std::uint8_t, 32> bytes{};
  std::string hex() const;  ///< 64 lower-case hex digits
  friend auto operator<=>(const Digest&, const Digest&) = default;
};

Digest sha256(std::span<const std::byte> data);
Digest sha256(std::string_view data);
/// With polls, for data that may have gigabytes. Throws Interrupted.
Digest sha256(std::span<const std::byte> data, const Execution& execution);

/// The algorithms of RFC 9530.
enum class DigestAlgorithm { kSha256, kSha512 };
/// Computes 32 or 64 bytes, with polls. Throws Interrupted.
std::vector<std::uint8_t> digest_bytes(DigestAlgorithm algorithm, std::span<const std::byte> data,
                                       const Execution& execution);

/// Encodes as in RFC 4648, section 4, which HTTP uses for digests (RFC 9530).
std::string base64(std::span<const std::uint8_t> bytes);

}  // namespace fracture
