// The keys that the servers of one farm share, so that what they find in a tier is what one of them put
// there: HMAC-SHA256 (RFC 2104) over the tier, the entry's key, the algorithm version and the bytes as they
// are stored. It is checked before anything else is done with those bytes: no decoder sees what a stranger
// wrote.
//
//   offset  bytes
//        0      4  "FRS1"
//        4     32  HMAC-SHA256 of "fracture cache entry\n<tier>\n<key>\n<algorithm>\n" and the bytes
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

namespace fracture {

/// What a signature is about, beside the bytes: an entry moved elsewhere, or of another version, is none.
struct SignedAs {
  std::string_view tier;  ///< "redis" or "disk"
  std::string_view key;
  int algorithm = 0;
};

/// Immutable: safe to use from any thread.
class FarmKeys {
 public:
  static constexpr std::size_t kMinCharacters = 32, kMaxKeys = 2, kHead = 36;

  /// One or two lines of at least 32 characters (`openssl rand -hex 32`): the first signs, both are taken, so
  /// that a farm changes its key without losing what it has. Empty lines and those that begin with '#' are
  /// skipped. kFileAccess, kBadParameter: the error names file and line, never a key.
  static Expected<FarmKeys> load(const std::string& path);
  static Expected<FarmKeys> parse(std::string_view text);

  bool empty() const { return keys_.empty(); }

  using Bytes = std::span<const std::uint8_t>;
  /// What stands before the bytes, which may come in parts. Needs a key.
  std::string head(const SignedAs& as, std::initializer_list<Bytes> bytes) const;
  /// The bytes behind their head; nothing where none of the keys has signed them as this.
  std::optional<Bytes> open(const SignedAs& as, Bytes stored) const;

 private:
  std::vector<std::string> keys_;
};

}  // namespace fracture
