// The keys that the servers of a farm share, to ensure that an entry in a cache tier was written by one of them. The
// signature is HMAC-SHA256 (RFC 2104) over the tier, the entry's key, the algorithm version and the stored bytes. It is
// checked before anything else, so that no decoder processes bytes from an untrusted source.
//
//   offset  bytes
//        0      4  "FRS1"
//        4     32  HMAC-SHA256 of "fracture cache entry\n<tier>\n<key>\n<algorithm>\n", followed by the bytes
//       36      …  the bytes
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/execution.hpp"

namespace fracture {

/// The attributes that a signature covers in addition to the bytes. So an entry that was moved to another key or tier, or
/// that has another algorithm version, is not accepted.
struct SignedAs {
  std::string_view tier;  ///< "redis" or "disk"
  std::string_view key;
  int algorithm = 0;
};

/// Immutable: safe to use from any thread.
class FarmKeys {
 public:
  static constexpr std::size_t kMinCharacters = 32, kMaxKeys = 2, kHead = 36;

  /// Reads one or two keys, each on a line of at least 32 characters (`openssl rand -hex 32`). The first key signs, and both
  /// are accepted, so that a farm can change its key without losing its entries. Empty lines and lines that begin with '#'
  /// are skipped. Errors: kFileAccess, kBadParameter. The error names the file and the line, but never contains a key.
  static Expected<FarmKeys> load(const std::string& path);
  static Expected<FarmKeys> parse(std::string_view text);

  bool empty() const { return keys_.empty(); }

  using Bytes = std::span<const std::uint8_t>;
  /// Returns the head to store before the bytes, which may be given in parts. Requires a key.
  std::string head(const SignedAs& as, std::initializer_list<Bytes> bytes) const;
  /// Returns the bytes after the head; nothing if no key has signed them for this tier, key and version.
  /// Throws Interrupted.
  std::optional<Bytes> open(const SignedAs& as, Bytes stored,
                            const Execution& execution = kUninterrupted) const;

 private:
  std::vector<std::string> keys_;
};

}  // namespace fracture
