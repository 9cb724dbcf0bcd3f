#include "server/http/request_body.hpp"

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>

namespace fracture::http {
namespace {

using Clock = TimedSocket::Clock;
namespace bhttp = beast::http;
using Parser = bhttp::request_parser<bhttp::string_body>;

/// Limits the framing overhead of a chunked body: bytes on the wire per byte of content, plus a fixed
/// allowance. Chunks of three bytes ("3\r\nabc\r\n", 8 bytes) always pass; smaller chunks and extensions only
/// pass until the allowance is used up.
constexpr std::uint64_t kMaxWireFactor = 3;
constexpr std::uint64_t kWireAllowance = 1u << 20;

/// Minimum size of one read.
constexpr std::size_t kPiece = 16u << 10;
/// Number of chunks, or parts of chunks, parsed in one turn: 0.1 ms.
constexpr int kPartsInTurn = 200;

/// Maximum bytes of a chunked body that are kept in one string.
constexpr std::size_t kBodyPiece = 256u << 10;

/// Explains an error of the parser or the socket. Returns nothing if the client is gone.
std::optional<Problem> explain(error_code ec, const Admission& admission) {
  if (ec == bhttp::error::body_limit) return body_too_large(admission, {});
  if (ec == bhttp::error::buffer_overflow)
    return Problem(HttpProblem::kHeaderTooLarge,
                   "The body has oversized chunk extensions or trailer fields.");
  if (ec == bhttp::error::partial_message || ec == bhttp::error::end_of_stream || ec == asio::error::eof)
    return Problem(HttpProblem::kMalformedRequest,
                   "The client closed its sending side before the body was complete.");
  if (ec.category() == bhttp::make_error_code(bhttp::error::bad_chunk).category())
    return Problem(HttpProblem::kMalformedRequest, "The chunked body is malformed (" + ec.message() + ").");
  return std::nullopt;
}

}  // namespace

asio::awaitable<BodyOutcome> read_body(TimedSocket& connection, beast::flat_buffer& buffer,
                                       std::size_t head_size, Api& api, Request& request,
                                       const std::string& address) {
  const HttpLimits& limits = api.limits();
  const Admission& admission = request.admission;
  BodyOutcome outcome;
  const auto refused = [&outcome](Problem problem) {
    outcome.problem = std::move(problem);
    return std::move(outcome);
  };

  Parser parser;
  parser.header_limit(static_cast<std::uint32_t>(limits.max_header + 1));
  parser.body_limit(admission.max_body);
  error_code ec;
  const std::size_t used = parser.put(asio::buffer(buffer.cdata().data(), head_size), ec);
  if (ec == bhttp::error::body_limit) co_return refused(body_too_large(admission, {}));
  if ((ec && ec != bhttp::error::need_more) || !parser.is_header_done() || used != head_size)
    co_return refused(
        Problem(HttpProblem::kMalformedRequest, "The header cannot be parsed (" + ec.message() + ")."));
  buffer.consume(head_size);
  request.reservation = api.bodies().begin(address);  // also covers parameters of a request without a body
  if (parser.is_done()) co_return outcome;

  // The trailer section after the last chunk is read whole and ignored. Its number of fields is limited like
  // that of a header.
  auto refuse_long_trailer = [&buffer](std::uint64_t size, beast::string_view extensions, error_code& wrong) {
    if (size > 0) return;
    const auto* const end = static_cast<const char*>(buffer.cdata().data()) + buffer.size();
    const std::string_view rest(extensions.end(), static_cast<std::size_t>(end - extensions.end()));
    const std::string_view trailer = rest.substr(0, rest.find("\r\n\r\n"));
    if (static_cast<std::size_t>(std::count(trailer.begin(), trailer.end(), '\n')) > kMaxFields)
      wrong = bhttp::error::buffer_overflow;
  };
  parser.on_chunk_header(refuse_long_trailer);

  if (request.head.expects_continue && buffer.size() == 0) {
    static constexpr std::string_view kContinue = "HTTP/1.1 100 Continue\r\n\r\n";
    connection.set_deadline(Clock::now() + limits.write_stall);
    co_await asio::async_write(connection.socket(), asio::buffer(kContinue.data(), kContinue.size()),
                               asio::redirect_error(asio::use_awaitable, ec));
    if (ec) {
      outcome.closed = true;
      co_return outcome;
    }
  }

  const Clock::time_point start = Clock::now();
  const Clock::time_point end = start + limits.body_timeout;
  std::uint64_t in_pieces = 0;
  for (;;) {
    // The length of a chunked body is not known in advance. Collect it in pieces, because a growing string
    // would copy megabytes at once.
    if (std::string& body = parser.get().body(); request.head.chunked && body.size() >= kBodyPiece) {
      request.pieces.emplace_back().swap(body);
      body.reserve(kBodyPiece + kReadBuffer);
      in_pieces += request.pieces.back().size();
    }
    // Parse all received data at once, so that small chunks do not cost one turn of the event loop each.
    for (int parts = 0; !parser.is_done() && buffer.size() > 0; ++parts) {
      if (parts == kPartsInTurn) {
        parts = 0;
        co_await asio::post(connection.socket().get_executor(), asio::use_awaitable);
      }
      ec.clear();
      const std::size_t taken = parser.put(buffer.cdata(), ec);
      buffer.consume(taken);
      outcome.wire_bytes += taken;
      if (ec) break;
    }
    const std::uint64_t received = in_pieces + parser.get().body().size();
    if (!request.reservation.grow_to(received)) co_return refused(api.no_memory(request.reservation));
    if (ec && ec != bhttp::error::need_more) {
      outcome.problem = explain(ec, admission);
      outcome.closed = !outcome.problem;
      co_return outcome;
    }
    if (outcome.wire_bytes > kMaxWireFactor * received + kWireAllowance)
      co_return refused(Problem(HttpProblem::kHeaderTooLarge,
                                "The body's chunks are too small, or their extensions are too long: " +
                                    std::to_string(outcome.wire_bytes) + " bytes were sent for " +
                                    std::to_string(received) + " bytes of content."));
    if (parser.is_done()) break;
    const std::size_t room =
        std::min(std::max(kPiece, buffer.capacity() - buffer.size()), buffer.max_size() - buffer.size());
    if (room == 0)
      co_return refused(*explain(bhttp::make_error_code(bhttp::error::buffer_overflow), admission));

    const auto earned =
        std::chrono::milliseconds(1000 * received / std::max<std::uint64_t>(1, limits.body_rate));
    // Limit each single wait too: time earned by a fast start must not allow one long silence.
    const Clock::time_point late =
        std::min(start + limits.body_grace + earned, Clock::now() + limits.write_stall);
    connection.set_deadline(std::min(late, end));
    buffer.commit(co_await connection.socket().async_read_some(
        buffer.prepare(room), asio::redirect_error(asio::use_awaitable, ec)));
    if (connection.timed_out())
      co_return refused(Problem(
          HttpProblem::kRequestTimeout,
          late < end
              ? "The body arrived slower than " + std::to_string(limits.body_rate) + " bytes a second."
              : "The body was not complete within " + std::to_string(limits.body_timeout.count()) + " ms."));
    if (ec) {
      outcome.problem = explain(ec, admission);
      outcome.closed = !outcome.problem;
      co_return outcome;
    }
  }
  connection.clear_deadline();
  request.body = std::move(parser.get().body());
  const Carries carries = admission.route->carries;
  // Bodies with a Content-Length of 0 were refused earlier; this is only reached by empty chunked bodies.
  if ((carries == Carries::kMesh || carries == Carries::kMeshOrName) && request.body_bytes() == 0)
    co_return refused(to_problem(Error{ErrorCode::kEmptyBody, "The body is empty.", "mesh"}));
  co_return outcome;
}

}  // namespace fracture::http
