// The framing guard: parses the header of a request strictly, before any lenient parser reads it. If two
// programs disagree about where a request ends, requests can be smuggled (RFC 9112, section 11.2). So
// everything ambiguous is refused:
//
// - obs-fold, bare CR or LF, and white space before a colon,
// - no Host field in HTTP/1.1, or several Host fields,
// - Content-Length together with Transfer-Encoding, several Content-Length fields, or one that is not only
//   digits,
// - transfer codings other than `chunked`, and `chunked` in HTTP/1.0,
// - targets that are not in origin-form, and paths with an escaped '/'.
//
// This file uses no network and no Boost, so that it can be tested and fuzzed on its own.
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
      false;  ///< Half-Close: yes: the client closes its side of the connection but still reads

  bool has_body() const { return chunked || content_length.value_or(0) > 0; }
  /// Returns the value of the field with this name (case-insensitive), or an empty string. Repeated fields
  /// are joined by ", ".
  std::string field(std::string_view name) const;
};

/// Returns the size of the header up to and including the empty line, or nothing if it is incomplete. Refuses
/// a header as soon as no continuation can make it valid, so that the client is answered at once and not
/// after a timeout. `searched` stores how far earlier calls have searched; start with 0.
OrProblem<std::optional<std::size_t>> find_head_end(std::string_view received, std::size_t& searched,
                                                    const HttpLimits& limits);

/// Parses a header. `head` must end with the empty line.
OrProblem<RequestHead> parse_head(std::string_view head, const HttpLimits& limits);

/// Decodes percent-encoding. Returns nothing if malformed. In queries and forms, `+` is a space
/// (Plus::kIsSpace).
enum class Plus { kIsPlus, kIsSpace };
std::optional<std::string> percent_decode(std::string_view text, Plus plus);

/// Returns the decoded name=value pairs of a query, or nothing if an escape is malformed.
std::optional<std::vector<std::pair<std::string, std::string>>> parse_query(std::string_view query);

bool equals_ignoring_case(std::string_view a, std::string_view b);

}  // namespace fracture::http
