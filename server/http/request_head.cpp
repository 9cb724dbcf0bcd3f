#include "server/http/request_head.hpp"
#include "common/base/text.hpp"

#include <algorithm>
#include <charconv>

namespace fracture::http {
namespace {

/// Returns whether `c` is a tchar (RFC 9110, section 5.6.2).
bool is_token_char(char c) {
  if ((c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z')) return true;
  return std::string_view("!#$%&'*+-.^_`|~").find(c) != std::string_view::npos;
}

bool is_token(std::string_view s) { return !s.empty() && std::all_of(s.begin(), s.end(), is_token_char); }

/// Returns whether all characters are allowed in a field value: visible ones, spaces, tabs and bytes above
/// 0x7f.
bool is_field_value(std::string_view s) {
  return std::all_of(s.begin(), s.end(), [](char c) {
    const auto u = static_cast<unsigned char>(c);
    return u == '\t' || (u >= 0x20 && u != 0x7f);
  });
}

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; }

tl::unexpected<Problem> malformed_request(std::string detail) {
  return refuse(HttpProblem::kMalformedRequest, std::move(detail));
}

int hex_value(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

/// Returns whether the path contains an escaped '/'. Decoding it would split the path into other segments
/// than a proxy saw when it routed the request.
bool has_escaped_slash(std::string_view path) {
  for (std::size_t at = path.find("%2"); at != std::string_view::npos; at = path.find("%2", at + 1))
    if (at + 2 < path.size() && lower(path[at + 2]) == 'f') return true;
  return false;
}

OrProblem<bool> parse_request_line(std::string_view line, RequestHead& head, const HttpLimits& limits) {
  const std::size_t first = line.find(' '), last = line.rfind(' ');
  if (first == std::string_view::npos || first == last)
    return malformed_request("The request line must be 'METHOD /path HTTP/1.1'.");
  const std::string_view method = line.substr(0, first), target = line.substr(first + 1, last - first - 1),
                         version = line.substr(last + 1);
  if (!is_token(method)) return malformed_request("The method is not a valid HTTP token.");
  if (version.size() != 8 || version.substr(0, 5) != "HTTP/" || version[6] != '.' ||
      hex_value(version[5]) < 0 || hex_value(version[5]) > 9 || hex_value(version[7]) < 0 ||
      hex_value(version[7]) > 9)
    return malformed_request("The protocol must be written 'HTTP/1.1'.");
  if (version != "HTTP/1.1" && version != "HTTP/1.0")
    return refuse(HttpProblem::kVersionNotSupported,
                  "The request names a protocol version other than HTTP/1.1 and HTTP/1.0.");
  if (target.size() > limits.max_uri)
    return refuse(HttpProblem::kUriTooLong, "The request target has " + std::to_string(target.size()) +
                                                " bytes; the limit is " + std::to_string(limits.max_uri) +
                                                ".");
  if (target.empty() || target.front() != '/')
    return malformed_request(
        "The request target must be a path that begins with '/' (no absolute form, no '*').");
  for (const char c : target)
    if (static_cast<unsigned char>(c) <= 0x20 || static_cast<unsigned char>(c) >= 0x7f || c == '#')
      return malformed_request("The request target has a character that must be percent-encoded.");
  const std::size_t mark = target.find('?');
  if (has_escaped_slash(target.substr(0, mark)))
    return malformed_request(
        "The path has a '/' written as %2F: proxies and servers disagree about its meaning.");
  const std::optional<std::string> path = percent_decode(target.substr(0, mark), Plus::kIsPlus);
  if (!path || path->find('\0') != std::string::npos)
    return malformed_request(
        "The path has a malformed percent escape. Two hex digits must follow '%'; write %25 for a percent sign.");
  head.method = method;
  head.path = *path;
  if (mark != std::string_view::npos) head.query = target.substr(mark + 1);
  head.minor_version = version.back() - '0';
  return true;
}

OrProblem<bool> parse_fields(std::string_view block, RequestHead& head) {
  const auto parts = std::count_if(block.begin(), block.end(), [](char c) { return c == ',' || c == ';'; });
  if (static_cast<std::size_t>(parts) > kMaxMembers)
    return refuse(HttpProblem::kHeaderTooLarge, "The fields of the request header contain " +
                                                    std::to_string(parts) +
                                                    " list members and parameters in total; the limit is " +
                                                    std::to_string(kMaxMembers) + ".");
  while (!block.empty()) {
    const std::size_t end = block.find("\r\n");
    const std::string_view line = block.substr(0, end);
    block.remove_prefix(end + 2);
    if (line.front() == ' ' || line.front() == '\t')
      return malformed_request("A header field is folded over several lines; write it on one line.");
    const std::size_t colon = line.find(':');
    if (colon == std::string_view::npos || !is_token(line.substr(0, colon)))
      return malformed_request(
          "A header line must be 'name: value', with a token as the name and no space before the colon.");
    const std::string_view value = trimmed(line.substr(colon + 1));
    if (!is_field_value(value))
      return malformed_request("A header field has a control character in its value.");
    if (head.fields.size() == kMaxFields)
      return refuse(HttpProblem::kHeaderTooLarge,
                    "The request header has more than " + std::to_string(kMaxFields) + " fields.");
    head.fields.emplace_back(line.substr(0, colon), value);
  }
  return true;
}

OrProblem<bool> decide_framing(RequestHead& head) {
  std::size_t hosts = 0, lengths = 0, codings = 0;
  std::string_view length, coding, host;
  for (const auto& [name, value] : head.fields) {
    if (equals_ignoring_case(name, "host")) ++hosts, host = value;
    if (equals_ignoring_case(name, "content-length")) ++lengths, length = value;
    if (equals_ignoring_case(name, "transfer-encoding")) ++codings, coding = value;
  }
  if (hosts > 1 || (hosts == 0 && head.minor_version == 1))
    return malformed_request("A request needs exactly one Host field; this one has " + std::to_string(hosts) +
                             ".");
  if (host.find_first_of(" \t,/@") != std::string_view::npos)
    return malformed_request("The Host field is not 'host[:port]'.");
  if (codings > 0) {
    if (lengths > 0) return malformed_request("Content-Length and Transfer-Encoding were both given.");
    if (head.minor_version == 0) return malformed_request("Transfer-Encoding does not exist in HTTP/1.0.");
    if (codings > 1 || !equals_ignoring_case(coding, "chunked"))
      return refuse(HttpProblem::kNotImplemented,
                    "The only supported transfer coding is 'chunked', given once.");
    head.chunked = true;
  }
  if (lengths > 1) return malformed_request("Content-Length was given more than once.");
  if (lengths == 1) {
    std::uint64_t number = 0;
    const auto [end, error] = std::from_chars(length.data(), length.data() + length.size(), number);
    if (length.empty() || error == std::errc::invalid_argument || end != length.data() + length.size())
      return malformed_request("Content-Length must be a whole number in digits.");
    if (error == std::errc::result_out_of_range) number = UINT64_MAX;
    head.content_length = number;
  }

  const std::string connection = head.field("connection");
  bool close = head.minor_version == 0;  // persistence in HTTP/1.0 is too ambiguous
  for (std::size_t at = 0; at <= connection.size();) {
    const std::size_t comma = std::min(connection.find(',', at), connection.size());
    if (equals_ignoring_case(trimmed(std::string_view(connection).substr(at, comma - at)), "close"))
      close = true;
    at = comma + 1;
  }
  head.keep_alive = !close;

  const std::string expect = head.field("expect");
  if (!expect.empty()) {
    if (!equals_ignoring_case(expect, "100-continue"))
      return refuse(HttpProblem::kExpectationFailed, "The only supported expectation is '100-continue'.");
    head.expects_continue = head.minor_version == 1 && head.has_body();
  }

  const std::string half_close = head.field("half-close");
  if (!half_close.empty()) {
    if (!equals_ignoring_case(half_close, "yes"))
      return malformed_request("The only valid value of the Half-Close field is 'yes'.");
    head.half_closes = true;
  }
  return true;
}

}  // namespace

bool equals_ignoring_case(std::string_view a, std::string_view b) {
  return a.size() == b.size() &&
         std::equal(a.begin(), a.end(), b.begin(), [](char x, char y) { return lower(x) == lower(y); });
}

std::string RequestHead::field(std::string_view name) const {
  std::string joined;
  bool found = false;
  for (const auto& [key, value] : fields) {
    if (!equals_ignoring_case(key, name)) continue;
    if (found) joined += ", ";
    joined += value;
    found = true;
  }
  return joined;
}

OrProblem<std::optional<std::size_t>> find_head_end(std::string_view received, std::size_t& searched,
                                                    const HttpLimits& limits) {
  for (std::size_t i = searched; i < received.size() && i < limits.max_header; ++i) {
    const char c = received[i];
    if (c == '\0') return malformed_request("The header has a NUL byte.");
    if (c == '\n') {
      if (i == 0 || received[i - 1] != '\r') return malformed_request("A header line ends in LF without CR.");
      if (i == 1) return malformed_request("The request begins with an empty line.");
      if (i >= 3 && received[i - 2] == '\n') return std::optional<std::size_t>(i + 1);
    } else if (i > 0 && received[i - 1] == '\r') {
      return malformed_request("The header has a CR without LF.");
    }
    searched = i + 1;
  }
  if (received.size() >= limits.max_header) {
    if (received.substr(0, limits.max_header).find('\n') == std::string_view::npos)
      return refuse(HttpProblem::kUriTooLong,
                    "The request line is longer than " + std::to_string(limits.max_header) + " bytes.");
    return refuse(HttpProblem::kHeaderTooLarge,
                  "The request header is larger than " + std::to_string(limits.max_header) + " bytes.");
  }
  return std::optional<std::size_t>();
}

OrProblem<RequestHead> parse_head(std::string_view head, const HttpLimits& limits) {
  if (head.size() < 4 || head.substr(head.size() - 4) != "\r\n\r\n")
    return malformed_request("The header does not end with an empty line.");
  head.remove_suffix(2);  // so that each remaining line ends in CRLF
  const std::size_t end = head.find("\r\n");
  RequestHead result;
  if (auto line = parse_request_line(head.substr(0, end), result, limits); !line)
    return tl::unexpected<Problem>(std::move(line.error()));
  if (auto fields = parse_fields(head.substr(end + 2), result); !fields)
    return tl::unexpected<Problem>(std::move(fields.error()));
  if (auto framing = decide_framing(result); !framing)
    return tl::unexpected<Problem>(std::move(framing.error()));
  return result;
}

std::optional<std::string> percent_decode(std::string_view text, Plus plus) {
  std::string decoded;
  decoded.reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '%') {
      if (i + 2 >= text.size()) return std::nullopt;
      const int high = hex_value(text[i + 1]), low = hex_value(text[i + 2]);
      if (high < 0 || low < 0) return std::nullopt;
      decoded += static_cast<char>(16 * high + low);
      i += 2;
    } else {
      decoded += text[i] == '+' && plus == Plus::kIsSpace ? ' ' : text[i];
    }
  }
  return decoded;
}

std::optional<std::vector<std::pair<std::string, std::string>>> parse_query(std::string_view query) {
  std::vector<std::pair<std::string, std::string>> pairs;
  pairs.reserve(1 + static_cast<std::size_t>(std::count(query.begin(), query.end(), '&')));
  while (!query.empty()) {
    const std::string_view item = query.substr(0, query.find('&'));
    query.remove_prefix(std::min(query.size(), item.size() + 1));
    if (item.empty()) continue;
    const std::size_t equals = item.find('=');
    auto name = percent_decode(item.substr(0, equals), Plus::kIsSpace);
    auto value = percent_decode(
        equals == std::string_view::npos ? std::string_view() : item.substr(equals + 1), Plus::kIsSpace);
    if (!name || !value) return std::nullopt;
    pairs.emplace_back(std::move(*name), std::move(*value));
  }
  return pairs;
}

}  // namespace fracture::http
