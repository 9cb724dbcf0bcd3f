// The framing guard: reads the header of a request strictly, before any lenient parser sees it. Two programs
// that disagree about where a request ends is how requests are smuggled (RFC 9112, section 11.2), so
// everything ambiguous is refused here: no obs-fold, no bare CR or LF, no white space before a colon, exactly
// one Host, Content-Length or Transfer-Encoding but never both, one Content-Length of digits only, `chunked`
// as the only transfer coding and only in HTTP/1.1, origin-form targets only, no escaped '/' in a path.
//
// No network and no Boost here: bytes in, a value out, so that it can be tested and fuzzed alone.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/http/limits.hpp"
#include "server/http/problem.hpp"

namespace fracture::http {

struct RequestHead {
  std::string method;
  std::string path;   ///< percent-decoded; begins with '/'
  std::string query;  ///< still encoded, without the '?'
  int minor_version = 1;
  std::vector<std::pair<std::string, std::string>> fields;  ///< in order; names as sent, values trimmed
  std::optional<std::uint64_t> content_length;
  bool chunked = false;
  bool keep_alive = true;
  bool expects_continue = false;
  bool half_closes =
      false;  ///< Half-Close: yes: its client closes its side of the connection and still reads

  bool has_body() const { return chunked || content_length.value_or(0) > 0; }
  /// The value of the only field of this name (case-insensitive); empty when absent. Repeated fields are
  /// joined by ", ".
  std::string field(std::string_view name) const;
};

/// Bytes up to and including the empty line, when they are all there: nothing yet, or a refusal as soon as no
/// continuation can be well-formed (so that a malformed header is answered at once and not after a timeout).
/// `searched` remembers how far earlier calls looked; start with 0.
OrProblem<std::optional<std::size_t>> find_head_end(std::string_view received, std::size_t& searched,
                                                    const HttpLimits& limits);

/// `head` ends with the empty line.
OrProblem<RequestHead> parse_head(std::string_view head, const HttpLimits& limits);

/// Percent-decoding; nothing when malformed. `plus_is_space` for queries and forms.
enum class Plus { kIsPlus, kIsSpace };
std::optional<std::string> percent_decode(std::string_view text, Plus plus);

/// name=value pairs of a query, decoded; nothing when an escape is malformed.
std::optional<std::vector<std::pair<std::string, std::string>>> parse_query(std::string_view query);

bool equals_ignoring_case(std::string_view a, std::string_view b);

}  // namespace fracture::http
