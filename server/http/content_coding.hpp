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

/// What a Content-Encoding field names: nothing or `identity`, `gzip` (also `x-gzip`), `zstd`. Refuses every
/// other and every list of codings with 415, whose Accept-Encoding says what would do.
OrProblem<ContentCoding> content_coding(std::string_view field);

/// How long the body says that it is when it is decoded: in the last bytes of gzip, in the first frame of
/// zstd. A hint: bodies may lie, or say nothing (0). Never more than so many bytes can decode to.
std::uint64_t announced_size(std::string_view body, ContentCoding coding);

/// Decodes `body` in place. Decodes twice: the first time it only counts, so that a body that unfolds beyond
/// `limit` (413) or beyond what was `expected`, is damaged (400) or finds no room in the budget (nothing) has
/// cost no memory. Members of a gzip file and frames of zstd may follow one another; whatever else follows is
/// damage. The window of zstd is at most 8 MiB (RFC 9659). Throws Interrupted.
struct Decoding {
  std::optional<Problem> problem{};
  bool no_room = false;  ///< the budget is exhausted
  bool larger = false;   ///< than expected: nothing was done
};
Decoding decode_body(std::string& body, ContentCoding coding, std::uint64_t limit,
                     MemoryBudget::Reservation& reservation, const Execution& execution,
                     std::uint64_t expected = std::numeric_limits<std::uint64_t>::max());

/// "identity", "gzip", "zstd".
std::string_view name_of(ContentCoding coding);

/// What an Accept-Encoding field (RFC 9110, section 12.5.3) says of each coding.
struct CodingWishes {
  int identity = 1000, gzip = 0, zstd = 0;  ///< qualities in thousandths; 0: not acceptable
  bool identity_named = false;              ///< otherwise it is what is sent when no other will do

  bool accepts(ContentCoding coding) const;
  /// The best liked one; of equals zstd, then gzip. Nothing when all are excluded.
  std::optional<ContentCoding> best() const;
};
CodingWishes coding_wishes(std::string_view accept_encoding);

/// Compressed rather quickly than well (gzip 1, zstd 3). The same bytes at each time, by one version of the
/// libraries. Throws Interrupted.
std::vector<std::uint8_t> encode_body(std::span<const std::uint8_t> body, ContentCoding coding,
                                      const Execution& execution);

}  // namespace fracture::http
