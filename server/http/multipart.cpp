#include "server/http/multipart.hpp"

#include <algorithm>

#include "common/base/polled_search.hpp"
#include "common/base/text.hpp"
#include "common/base/words.hpp"
#include "server/http/request_head.hpp"

namespace fracture::http {
namespace {

/// Returns the parameter `name` of a field value such as `form-data; name="mesh"; filename="a.glb"`, quoted
/// or not.
std::optional<std::string> parameter_of(std::string_view value, std::string_view name) {
  std::size_t at = value.find(';');
  while (at < value.size()) {
    ++at;
    while (at < value.size() && (value[at] == ' ' || value[at] == '\t')) ++at;
    const std::size_t equals = value.find('=', at);
    if (equals == std::string_view::npos) return std::nullopt;
    const std::string_view key = trimmed(value.substr(at, equals - at));
    std::string text;
    at = equals + 1;
    if (at < value.size() && value[at] == '"') {
      for (++at; at < value.size() && value[at] != '"'; ++at) {
        if (value[at] == '\\' && at + 1 < value.size()) ++at;
        text += value[at];
      }
      if (at >= value.size()) return std::nullopt;  // the quote is not closed
      at = value.find(';', at);
    } else {
      const std::size_t end = std::min(value.find(';', at), value.size());
      text = trimmed(value.substr(at, end - at));
      at = end;
    }
    if (equals_ignoring_case(key, name)) return text;
  }
  return std::nullopt;
}

tl::unexpected<Problem> malformed_form(std::string detail) {
  return refuse(HttpProblem::kMalformedMultipart, std::move(detail));
}

OrProblem<FormPart> parse_part(std::string_view text) {
  FormPart part;
  const bool no_header = text.substr(0, 2) == "\r\n";
  const std::size_t end = no_header ? 0 : text.substr(0, kMaxPartHeader).find("\r\n\r\n");
  if (end == std::string_view::npos)
    return malformed_form("A part has no header, or its header has more than 4096 bytes.");
  part.body = text.substr(end + (no_header ? 2 : 4));
  bool form_data = false;
  for (std::string_view block = text.substr(0, end); !block.empty();) {
    const std::string_view line = block.substr(0, block.find("\r\n"));
    block.remove_prefix(std::min(block.size(), line.size() + 2));
    const std::size_t colon = line.find(':');
    if (colon == std::string_view::npos) return malformed_form("A part's header line has no colon.");
    const std::string_view value = trimmed(line.substr(colon + 1));
    if (equals_ignoring_case(line.substr(0, colon), "content-disposition")) {
      if (media_type_of(value) != "form-data")
        return malformed_form("A part's Content-Disposition is not form-data.");
      const std::optional<std::string> name = parameter_of(value, "name");
      if (!name) return malformed_form("A part has no name.");
      part.name = *name;
      part.filename = parameter_of(value, "filename");
      form_data = true;
    } else if (equals_ignoring_case(line.substr(0, colon), "content-type")) {
      part.content_type = media_type_of(value);
    }
  }
  if (!form_data) return malformed_form("A part has no Content-Disposition.");
  return part;
}

}  // namespace

std::string media_type_of(std::string_view content_type) {
  std::string type(trimmed(content_type.substr(0, content_type.find(';'))));
  for (char& c : type)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c + 32);
  return type;
}

std::optional<std::string> multipart_boundary(std::string_view content_type) {
  if (media_type_of(content_type) != "multipart/form-data") return std::nullopt;
  std::optional<std::string> boundary = parameter_of(content_type, "boundary");
  if (!boundary || boundary->empty() || boundary->size() > 70) return std::nullopt;
  return boundary;
}

OrProblem<std::vector<FormPart>> parse_multipart(std::string_view body, std::string_view boundary,
                                                 const Execution& execution) {
  // RFC 2046, section 5.1.1: [preamble CRLF] --B CRLF part CRLF --B CRLF part CRLF --B-- [CRLF epilogue]
  const std::string delimiter = "\r\n--" + std::string(boundary);
  PolledSearch delimiters(body, delimiter, execution);
  std::size_t at = 0;
  if (body.substr(0, delimiter.size() - 2) == std::string_view(delimiter).substr(2)) {
    at = delimiter.size() - 2;
  } else {
    at = delimiters.find(0, kMaxAround + 1);
    if (at == PolledSearch::kNone)
      return malformed_form("The first " + grouped(std::min(body.size(), kMaxAround)) +
                            " bytes of the body do not contain the boundary that Content-Type names.");
    at += delimiter.size();
  }
  std::vector<FormPart> parts;
  for (;;) {
    if (body.substr(at, 2) == "--") {
      const std::size_t epilogue = body.size() - at - 2;
      if (epilogue > kMaxAround)
        return malformed_form("The form has " + grouped(epilogue) +
                              " bytes after its last boundary; the limit is " + grouped(kMaxAround) + ".");
      return parts;
    }
    while (at < body.size() && (body[at] == ' ' || body[at] == '\t')) ++at;  // transport padding
    if (body.substr(at, 2) != "\r\n")
      return malformed_form("A boundary line has other characters after the boundary.");
    at += 2;
    const std::size_t end = delimiters.find(at);
    if (end == PolledSearch::kNone)
      return malformed_form("The closing boundary is missing: the body was cut off.");
    if (parts.size() == kMaxParts)
      return malformed_form("There are more than " + std::to_string(kMaxParts) + " parts.");
    OrProblem<FormPart> part = parse_part(body.substr(at, end - at));
    if (!part) return tl::unexpected<Problem>(std::move(part.error()));
    parts.push_back(std::move(*part));
    at = end + delimiter.size();
  }
}

}  // namespace fracture::http
