#include "common/exchange/connection_pool.hpp"

#include <openssl/ssl.h>
#include <openssl/x509.h>

#include <algorithm>
#include <boost/asio/ssl/host_name_verification.hpp>
#include <boost/asio/ssl/stream.hpp>

#include "common/exchange/tls.hpp"

namespace fracture::protocol {
namespace {

namespace http = beast::http;
using boost::system::error_code;

constexpr auto kForever = std::chrono::hours(24);

Exchange::Outcome outcome_of(const error_code& error, const Interruption& interruption) {
  if (interruption.requested) return Exchange::Outcome::kInterrupted;
  if (error == beast::error::timeout) return Exchange::Outcome::kTimedOut;
  if (error == http::error::body_limit || error == http::error::header_limit)
    return Exchange::Outcome::kTooLarge;
  return Exchange::Outcome::kBroken;
}

/// Sends the request, then reads the answer. A server that refuses a large upload may answer and close before
/// it has read everything; its answer is still read.
template <class Stream, class Request, class Parser>
asio::awaitable<error_code> ask(Stream& stream, const Request& request, beast::flat_buffer& buffer,
                                Parser& parser) {
  error_code error;
  co_await http::async_write(stream, request, asio::redirect_error(asio::use_awaitable, error));
  if (error && error != asio::error::broken_pipe && error != asio::error::connection_reset) co_return error;
  error = {};
  co_await http::async_read(stream, buffer, parser, asio::redirect_error(asio::use_awaitable, error));
  co_return error;
}

}  // namespace

struct ConnectionPool::Connection {
  explicit Connection(asio::io_context& io) : stream(io) {}
  beast::tcp_stream stream;
  std::unique_ptr<asio::ssl::stream<beast::tcp_stream&>> tls;  ///< over the stream, if it is HTTPS
  beast::flat_buffer buffer;
  std::chrono::steady_clock::time_point used;
};

ConnectionPool::ConnectionPool(asio::io_context& io, ConnectionSettings settings)
    : io_(io), settings_(std::move(settings)) {}

ConnectionPool::~ConnectionPool() = default;

void ConnectionPool::close_idle() { idle_.clear(); }

asio::awaitable<void> ConnectionPool::pause(Milliseconds time, Interruption& interruption) {
  if (interruption.requested) co_return;
  asio::steady_timer timer(io_, time);
  interruption.wake = [&timer] { timer.cancel(); };
  error_code ignored;
  co_await timer.async_wait(asio::redirect_error(asio::use_awaitable, ignored));
  interruption.wake = nullptr;
}

ConnectionPool::ConnectionPtr ConnectionPool::take_idle() {
  const auto oldest = std::chrono::steady_clock::now() - settings_.idle;
  std::erase_if(idle_, [&](const ConnectionPtr& connection) { return connection->used < oldest; });
  if (idle_.empty()) return nullptr;
  ConnectionPtr connection = std::move(idle_.back());
  idle_.pop_back();
  return connection;
}

asio::awaitable<Exchange> ConnectionPool::exchange(const HttpRequest& request, Interruption& interruption) {
  while (busy_ >= std::max<std::size_t>(1, settings_.connections) && !interruption.requested) {
    asio::steady_timer turn(io_, kForever);
    waiting_.push_back(&turn);
    interruption.wake = [&turn] { turn.cancel(); };
    error_code ignored;
    co_await turn.async_wait(asio::redirect_error(asio::use_awaitable, ignored));
    interruption.wake = nullptr;
    std::erase(waiting_, &turn);
  }
  ++busy_;
  ConnectionPtr connection = take_idle();
  const bool kept = connection != nullptr;
  Exchange result = co_await attempt(request, connection, interruption);
  // RFC 9112, 9.3.1: a server may close an idle connection at any time, so the request may not be at fault.
  if (kept && result.outcome == Exchange::Outcome::kBroken && !result.began) {
    connection.reset();
    idle_.clear();  // the others are as old
    result = co_await attempt(request, connection, interruption);
  }
  if (connection) {
    connection->used = std::chrono::steady_clock::now();
    idle_.push_back(std::move(connection));
  }
  --busy_;
  if (!waiting_.empty()) waiting_.front()->cancel();
  co_return result;
}

asio::awaitable<bool> ConnectionPool::connect(Connection& connection, Exchange& exchange) {
  error_code error;
  std::vector<tcp::endpoint> endpoints;
  const auto address = asio::ip::make_address(settings_.host, error);
  if (!error) {
    endpoints.emplace_back(address, settings_.port);
  } else {
    tcp::resolver resolver(io_);
    const std::string port = std::to_string(settings_.port);  // g++ 12 would destroy a temporary twice
    const auto found = co_await resolver.async_resolve(settings_.host, port,
                                                       asio::redirect_error(asio::use_awaitable, error));
    if (error || found.empty()) {
      exchange.outcome = Exchange::Outcome::kNoServer;
      exchange.detail = "The name " + settings_.host + " cannot be resolved: " + error.message() + ".";
      co_return false;
    }
    for (const auto& entry : found) endpoints.push_back(entry.endpoint());
  }
  connection.stream.expires_after(settings_.connect_timeout);
  co_await connection.stream.async_connect(endpoints, asio::redirect_error(asio::use_awaitable, error));
  if (error) {
    exchange.outcome =
        error == beast::error::timeout ? Exchange::Outcome::kTimedOut : Exchange::Outcome::kNoServer;
    exchange.detail = settings_.authority() + " does not answer: " + error.message() + ".";
    co_return false;
  }
  ++made_;
  connection.stream.socket().set_option(tcp::no_delay(true), error);
  if (settings_.tls) co_return co_await shake_hands(connection, exchange);
  co_return true;
}

asio::awaitable<bool> ConnectionPool::shake_hands(Connection& connection, Exchange& exchange) {
  auto tls =
      std::make_unique<asio::ssl::stream<beast::tcp_stream&>>(connection.stream, settings_.tls->context);
  error_code error;
  asio::ip::make_address(settings_.host, error);
  const bool name = error.failed();
  // RFC 6066, section 3: only names, so that one address may have several servers.
  if (name) SSL_set_tlsext_host_name(tls->native_handle(), settings_.host.c_str());
  tls->set_verify_callback(asio::ssl::host_name_verification(settings_.host), error);
  connection.stream.expires_after(settings_.connect_timeout);
  co_await tls->async_handshake(asio::ssl::stream_base::client,
                                asio::redirect_error(asio::use_awaitable, error));
  if (!error) {
    connection.tls = std::move(tls);
    co_return true;
  }
  const long verified = SSL_get_verify_result(tls->native_handle());
  exchange.outcome =
      error == beast::error::timeout ? Exchange::Outcome::kTimedOut : Exchange::Outcome::kNoServer;
  exchange.detail = verified != X509_V_OK
                        ? "The certificate of " + settings_.authority() +
                              " was rejected: " + X509_verify_cert_error_string(verified) + "."
                        : settings_.authority() + " failed the TLS handshake: " + error.message() + ".";
  co_return false;
}

asio::awaitable<Exchange> ConnectionPool::attempt(const HttpRequest& request, ConnectionPtr& connection,
                                                  Interruption& interruption) {
  Exchange exchange;
  if (interruption.requested) {
    connection.reset();
    co_return exchange;
  }
  const bool fresh = !connection;
  if (fresh) connection = std::make_unique<Connection>(io_);
  interruption.wake = [stream = &connection->stream] { stream->cancel(); };
  if (fresh && !co_await connect(*connection, exchange)) {
    interruption.wake = nullptr;
    if (interruption.requested) exchange.outcome = Exchange::Outcome::kInterrupted;
    connection.reset();
    co_return exchange;
  }

  http::request<http::span_body<const char>> message;
  message.method_string(request.method);
  message.target(request.target);
  message.version(11);
  message.set(http::field::host, settings_.authority());
  message.set(http::field::user_agent, "fracture-client");
  if (!settings_.token.empty()) message.set(http::field::authorization, "Bearer " + settings_.token);
  if (!request.content_type.empty()) message.set(http::field::content_type, request.content_type);
  for (const auto& [name, value] : request.fields) message.set(name, value);
  if (request.body) message.body() = {request.body->data(), request.body->size()};
  message.prepare_payload();

  const Milliseconds time =
      request.answer_timeout.count() > 0 ? request.answer_timeout : settings_.answer_timeout;
  connection->stream.expires_after(time);
  http::response_parser<http::string_body> parser;
  parser.body_limit(settings_.max_answer_bytes);
  error_code error;
  if (connection->tls)
    error = co_await ask(*connection->tls, message, connection->buffer, parser);
  else
    error = co_await ask(connection->stream, message, connection->buffer, parser);
  interruption.wake = nullptr;
  exchange.began = parser.got_some() || connection->buffer.size() > 0;
  if (error) {
    exchange.outcome = outcome_of(error, interruption);
    exchange.detail =
        exchange.outcome == Exchange::Outcome::kTooLarge
            ? "The response is larger than " + std::to_string(settings_.max_answer_bytes) + " bytes."
            : "The connection broke during " + std::string(request.method) + " " +
                  request.target.substr(0, 40) + ": " + error.message() + ".";
    if (exchange.outcome == Exchange::Outcome::kTimedOut)
      exchange.detail = "No complete response arrived within " + std::to_string(time.count()) + " ms.";
    connection.reset();  // makes the server stop computing
    co_return exchange;
  }
  auto response = parser.release();
  const auto text = [&](http::field field) { return std::string(response[field]); };
  exchange.outcome = Exchange::Outcome::kAnswered;
  exchange.status = static_cast<int>(response.result_int());
  exchange.repr_digest = std::string(response["Repr-Digest"]);
  exchange.server_timing = std::string(response["Server-Timing"]);
  exchange.retry_after = text(http::field::retry_after);
  exchange.content_location = text(http::field::content_location);
  exchange.content_type = text(http::field::content_type);
  if (!response.keep_alive() || connection->buffer.size() > 0) connection.reset();
  exchange.body = std::move(response.body());
  co_return exchange;
}

}  // namespace fracture::protocol
