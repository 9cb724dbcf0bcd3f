// SHA-256 (OpenSSL): mesh digests, cache keys, fragment ids and the hashes that determinism tests compare.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace fracture {

struct Digest {
  std::array<std::uint8_t, 32> bytes{};
  std::string hex() const;  ///< 64 lower-case hex digits
  friend auto operator<=>(const Digest&, const Digest&) = default;
};

Digest sha256(std::span<const std::byte> data);
Digest sha256(std::string_view data);

/// RFC 4648, section 4: how HTTP writes digests down (RFC 9530).
std::string base64(std::span<const std::uint8_t> bytes);

}  // namespace fracture
