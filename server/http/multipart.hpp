// Parses multipart/form-data (RFC 7578) without copying the body.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/execution.hpp"
#include "server/http/problem.hpp"

namespace fracture::http {

struct FormPart {
  std::string name;
  std::optional<std::string> filename;
  std::string content_type;  ///< without parameters, in lower case; empty if absent
  std::string_view body;     ///< a view into the whole body
};

/// Returns the boundary in a Content-Type of multipart/form-data. Returns nothing for other media types, and
/// if the boundary is missing or malformed (RFC 2046: 1 to 70 characters).
std::optional<std::string> multipart_boundary(std::string_view content_type);

/// Limits: kMaxParts parts, and kMaxPartHeader bytes in the header of each part. Up to kMaxAround bytes before
/// the first boundary and after the last one are ignored (RFC 2046, section 5.1.1). Refusals are
/// kMalformedMultipart. `boundary`: from multipart_boundary(). The time is linear in the body, whatever it
/// contains. The search for the first boundary ends after kMaxAround bytes. Polls once per kBytesBetweenPolls.
/// Throws Interrupted.
inline constexpr std::size_t kMaxAround = 4096;
inline constexpr std::size_t kMaxParts = 256;
inline constexpr std::size_t kMaxPartHeader = 4096;
OrProblem<std::vector<FormPart>> parse_multipart(std::string_view body, std::string_view boundary,
                                                 const Execution& execution = kUninterrupted);

/// Returns the media type without parameters: "model/obj; charset=utf-8" -> "model/obj".
std::string media_type_of(std::string_view content_type);

}  // namespace fracture::http
