// multipart/form-data (RFC 7578): a body taken apart without copying it.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/http/problem.hpp"

namespace fracture::http {

struct FormPart {
  std::string name;
  std::optional<std::string> filename;
  std::string content_type;  ///< without parameters, lower case; empty when absent
  std::string_view body;     ///< a view into the whole body
};

/// The boundary of a Content-Type value whose media type is multipart/form-data; nothing for every other
/// value or when the boundary is missing or malformed (RFC 2046: 1 to 70 characters).
std::optional<std::string> multipart_boundary(std::string_view content_type);

/// At most kMaxParts parts with at most kMaxPartHeader bytes of header each, and at most kMaxAround bytes
/// before the first and behind the last boundary, which nobody reads (RFC 2046, section 5.1.1). Refusals:
/// kMalformedMultipart.
inline constexpr std::size_t kMaxAround = 4096;
inline constexpr std::size_t kMaxParts = 256;
inline constexpr std::size_t kMaxPartHeader = 4096;
OrProblem<std::vector<FormPart>> parse_multipart(std::string_view body, std::string_view boundary);

/// "model/obj; charset=utf-8" -> "model/obj"
std::string media_type_of(std::string_view content_type);

}  // namespace fracture::http
