// Fuzz target: the bytes of a connection. The framing guard reads a header; if it accepts the header, Beast's
// parser reads the request as in a session. Different opinions about where the request ends are a finding.
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http.hpp>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "server/http/request_head.hpp"
#include "server/http/request_id.hpp"

namespace {

void require(bool condition) {
  if (!condition) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace fracture::http;
  namespace bhttp = boost::beast::http;
  const std::string_view received(reinterpret_cast<const char*>(data), size);
  HttpLimits limits;
  limits.max_header = 4096;
  limits.max_uri = 1024;
  limits.max_body = 4096;

  std::size_t searched = 0, searched_in_steps = 0;
  const auto end = find_head_end(received, searched, limits);
  // The result is the same however the bytes are cut into packets.
  auto in_steps = find_head_end(received.substr(0, size / 2), searched_in_steps, limits);
  if (in_steps && !*in_steps) in_steps = find_head_end(received, searched_in_steps, limits);
  require(in_steps.has_value() == end.has_value());
  if (!end) {
    require(!end.error().detail.empty());
    return 0;
  }
  require(*in_steps == *end);
  if (!*end) return 0;

  const auto head = parse_head(received.substr(0, **end), limits);
  if (!head) {
    require(head.error().type->status >= 400 && !head.error().detail.empty());
    return 0;
  }
  require(!head->path.empty() && head->path.front() == '/');
  require(!(head->chunked && head->content_length));
  (void)request_id(*head);
  (void)trace_context(*head);
  (void)parse_query(head->query);

  bhttp::request_parser<bhttp::string_body> parser;
  parser.header_limit(static_cast<std::uint32_t>(limits.max_header + 1));
  parser.body_limit(limits.max_body);
  boost::system::error_code ec;
  const std::size_t used = parser.put(boost::asio::buffer(received.data(), **end), ec);
  if ((ec && ec != bhttp::error::need_more) || !parser.is_header_done() || used != **end) return 0;  // a 400
  require(parser.chunked() == head->chunked);
  if (!head->chunked) require(parser.content_length().value_or(0) == head->content_length.value_or(0));
  require(parser.get().method_string() == head->method);
  require(parser.is_done() == !head->has_body());

  // The body is read in pieces.
  std::string_view rest = received.substr(**end);
  while (!parser.is_done() && !rest.empty()) {
    const std::size_t n = parser.put(boost::asio::buffer(rest.data(), rest.size()), ec);
    if (ec && ec != bhttp::error::need_more) return 0;
    if (n == 0) return 0;  // it waits for more bytes than there are
    rest.remove_prefix(n);
    require(parser.get().body().size() <= limits.max_body);
  }
  return 0;
}
