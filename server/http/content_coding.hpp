// Content-Encoding of request bodies and of answers (RFC 9110, section 8.4; RFC 8878 for zstd).
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/execution.hpp"
#include "server/http/problem.hpp"
#include "server/service/memory_budget.hpp"

namespace fracture::http {

enum class ContentCoding { kIdentity, kGzip, kZstd };

/// Parses a Content-Encoding field: empty or `identity`, `gzip` or `x-gzip`, or `zstd`. Any other coding and
/// lists of codings are refused with 415 and an Accept-Encoding field that lists the supported ones.
OrProblem<ContentCoding> content_coding(std::string_view field);

/// Returns the decoded size that the body announces, in the last bytes of gzip or in the first frame of zstd.
/// This is only a hint: it may be wrong, and it is 0 if the body announces none. It is limited to what so
/// many bytes can decode to.
std::uint64_t announced_size(std::string_view body, ContentCoding coding);

/// Decodes `body` in place, in two passes. The first pass only counts, so that a refused body costs no
/// memory. A body is refused if it decodes to more than `limit` (413) or is damaged (400). It is not decoded
/// if it is larger than `expected` or if the budget has no room; the flags of Decoding say so. Several gzip
/// members or zstd frames may follow one another; other trailing data counts as damage. The zstd window is at
/// most 8 MiB (RFC 9659). Throws Interrupted.
struct Decoding {
  std::optional<Problem> problem{};
  bool no_room = false;  ///< the budget is exhausted
  bool larger = false;   ///< than expected; nothing was decoded
};
Decoding decode_body(std::string& body, ContentCoding coding, std::uint64_t limit,
                     MemoryBudget::Reservation& reservation, const Execution& execution,
                     std::uint64_t expected = std::numeric_limits<std::uint64_t>::max());

/// Returns "identity", "gzip" or "zstd".
std::string_view name_of(ContentCoding coding);

/// Qualities of the codings in an Accept-Encoding field (RFC 9110, section 12.5.3).
struct CodingWishes {
  int identity = 1000, gzip = 0, zstd = 0;  ///< qualities in thousandths; 0: not acceptable
  bool identity_named = false;              ///< if false, identity is the last choice

  bool accepts(ContentCoding coding) const;
  /// Returns the preferred coding. On a tie, zstd comes before gzip. Returns nothing if all are excluded.
  std::optional<ContentCoding> best() const;
};
CodingWishes coding_wishes(std::string_view accept_encoding);

/// Compresses at a fast level (gzip 1, zstd 3). With the same version of the libraries, the output is always
/// the same. Throws Interrupted.
std::vector<std::uint8_t> encode_body(std::span<const std::uint8_t> body, ContentCoding coding,
                                      const Execution& execution);

}  // namespace fracture::http
