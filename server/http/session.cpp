#include "server/http/session.hpp"

#include <spdlog/spdlog.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <ctime>
#include <random>
#include <stop_token>
#include <string>
#include <utility>

#include "common/base/random.hpp"

namespace fracture::http {
namespace {

using std::chrono::steady_clock;
using error_code = boost::system::error_code;
namespace bhttp = beast::http;

/// A request body may be wrapped in this many bytes of chunk headers for each byte, on top of a fixed
/// allowance: one byte chunks ("1\r\nx\r\n", 6 bytes) pass, an endless chunk extension does not.
constexpr std::uint64_t kMaxWireFactor = 8;
constexpr std::uint64_t kWireAllowance = 1u << 20;

/// After an answer that refuses a request, what the client still sends is read and thrown away for a while:
/// closing a socket with unread data makes the kernel send a reset that can destroy the answer before the
/// client has read it.
constexpr std::chrono::seconds kLingerIdle{2}, kLingerTotal{10};

std::string new_request_id() {
  static std::atomic<std::uint64_t> next{[] {
    std::random_device device;
    return (static_cast<std::uint64_t>(device()) << 32) | device();
  }()};
  constexpr char kDigits[] = "0123456789abcdef";
  std::uint64_t value = Random(next.fetch_add(1))();
  std::string id(16, '0');
  for (char& c : id) {
    c = kDigits[value & 15];
    value >>= 4;
  }
  return id;
}

/// The client's own id when it is harmless to log and to send back.
std::string request_id(const RequestHead& head) {
  const std::string given = head.field("x-request-id");
  const auto harmless = [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '-' ||
           c == '_' || c == '.';
  };
  if (given.empty() || given.size() > 64 || !std::all_of(given.begin(), given.end(), harmless))
    return new_request_id();
  return given;
}

/// IMF-fixdate (RFC 9110, section 5.6.7).
std::string http_date() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  char text[40];
  return std::string(text, std::strftime(text, sizeof text, "%a, %d %b %Y %H:%M:%S GMT", &utc));
}

/// Where the pool hands a finished answer back to the session. Shared, since either side may outlive the
/// other.
struct Exchange {
  Request request;
  Response response;
  bool done = false;
};

class Session final : public std::enable_shared_from_this<Session>, public Drainable {
 public:
  Session(tcp::socket socket, Listener listener, Api& api, Connections& connections,
          Connections::Verdict verdict, std::string address)
      : socket_(std::move(socket)),
        timer_(socket_.get_executor()),
        job_done_(socket_.get_executor()),
        listener_(listener),
        api_(api),
        connections_(connections),
        verdict_(verdict),
        address_(std::move(address)) {}

  ~Session() override {
    if (busy_) connections_.in_progress.fetch_sub(1);
    connections_.remove(address_);
    connections_.forget(weak_from_this());
  }

  void start() {
    asio::co_spawn(
        socket_.get_executor(), [self = shared_from_this()] { return self->run(); },
        [self = shared_from_this()](std::exception_ptr failure) {
          if (!failure) return;
          try {
            std::rethrow_exception(failure);
          } catch (const std::exception& e) {
            spdlog::error("a session ended by an exception: {}", e.what());
          } catch (...) {
            spdlog::error("a session ended by an unknown exception");
          }
        });
  }

  void close_when_idle() override {
    asio::post(socket_.get_executor(), [self = shared_from_this()] {
      self->closing_ = true;
      if (!self->busy_) self->abort_io();
      self->job_done_.cancel();  // a stream of events ends
    });
  }

  void cancel_job() override {
    asio::post(socket_.get_executor(), [self = shared_from_this()] { self->stop_.request_stop(); });
  }

 private:
  enum class Read { kDone, kClosed, kTimeout };

  bool closing() const { return closing_ || connections_.stopping; }

  void abort_io() {
    error_code ignored;
    socket_.cancel(ignored);
  }

  /// From now on every operation on the socket ends at `when` with timed_out_ set. A later call replaces it.
  void set_deadline(steady_clock::time_point when) {
    const std::uint64_t generation = ++deadline_generation_;
    timed_out_ = false;
    timer_.expires_at(when);
    timer_.async_wait([weak = weak_from_this(), generation](error_code ec) {
      const auto self = weak.lock();
      if (ec || !self || generation != self->deadline_generation_) return;
      self->timed_out_ = true;
      self->abort_io();
    });
  }
  void clear_deadline() {
    ++deadline_generation_;
    timer_.cancel();
  }

  void set_busy(bool busy) {
    if (busy == busy_) return;
    busy_ = busy;
    if (busy)
      connections_.in_progress.fetch_add(1);
    else
      connections_.in_progress.fetch_sub(1);
  }

  asio::awaitable<void> run() {
    error_code ignored;
    socket_.set_option(tcp::no_delay(true), ignored);
    if (verdict_ != Connections::Verdict::kWelcome) {
      co_await turn_away();
      co_return;
    }
    for (;;) {
      set_busy(false);
      closed_ = false;
      id_ = new_request_id();
      OrProblem<std::optional<RequestHead>> head = co_await read_head();
      const steady_clock::time_point start = steady_clock::now();
      if (!head) {
        const Response response = Response::problem(head.error(), id_);
        co_await refuse_and_close(response, "?", "?", start);
        co_return;
      }
      if (!*head) co_return;  // closed or idle between requests

      Exchange& exchange = new_exchange();
      exchange.request.head = std::move(**head);
      const RequestHead& request_head = exchange.request.head;
      id_ = exchange.request.id = request_id(request_head);

      OrProblem<Admission> admission = api_.admit(listener_, request_head);
      if (!admission) {
        const Response response = Response::problem(admission.error(), id_);
        co_await refuse_and_close(response, request_head.method, request_head.path, start);
        co_return;
      }
      exchange.request.admission = std::move(*admission);

      std::optional<Problem> body_problem = co_await read_body(exchange.request);
      if (body_problem) {
        exchange.request.reservation = {};
        const Response response = Response::problem(*body_problem, id_);
        co_await refuse_and_close(response, request_head.method, request_head.path, start);
        co_return;
      }
      if (closed_) co_return;

      co_await compute();
      const bool keep = request_head.keep_alive && !closing();
      const bool written = co_await write(exchange_->response, keep, exchange_->request.admission.head_only);
      log(request_head.method, request_head.path, exchange_->response, start);
      if (!written) co_return;
      if (!keep) {
        co_await linger();
        co_return;
      }
      exchange_.reset();  // an idle connection keeps no result alive
    }
  }

  Exchange& new_exchange() {
    exchange_ = std::make_shared<Exchange>();
    return *exchange_;
  }

  void log(std::string_view method, std::string_view path, const Response& response,
           steady_clock::time_point start) const {
    const std::chrono::duration<double, std::milli> took = steady_clock::now() - start;
    // The path is percent-decoded: whatever is not plain is masked, so that no client writes lines into the
    // log.
    std::string shown(path.substr(0, 100));
    for (char& c : shown)
      if (static_cast<unsigned char>(c) <= 0x20 || static_cast<unsigned char>(c) >= 0x7f) c = '?';
    const auto level = listener_ == Listener::kAdmin ? spdlog::level::debug : spdlog::level::info;
    spdlog::log(level, "{} {} {} {} {} bytes {:.1f} ms", id_, method, shown, response.status,
                response.body.size(), took.count());
  }

  /// Reads until a whole header is there. Nothing: the client closed or stayed idle without having sent a
  /// byte.
  asio::awaitable<OrProblem<std::optional<RequestHead>>> read_head() {
    using Result = OrProblem<std::optional<RequestHead>>;
    std::size_t searched = 0;
    bool started = buffer_.size() > 0;
    set_deadline(steady_clock::now() + (started ? api_.limits().header_timeout : api_.limits().idle));
    if (started) set_busy(true);
    for (;;) {
      const std::string_view received(static_cast<const char*>(buffer_.cdata().data()), buffer_.size());
      OrProblem<std::optional<std::size_t>> end = find_head_end(received, searched, api_.limits());
      if (!end) co_return tl::unexpected<Problem>(std::move(end.error()));
      if (*end) {
        clear_deadline();
        OrProblem<RequestHead> head = parse_head(received.substr(0, **end), api_.limits());
        if (!head) co_return tl::unexpected<Problem>(std::move(head.error()));
        head_size_ = **end;
        co_return Result(std::optional<RequestHead>(std::move(*head)));
      }
      if (closing() && !started) co_return Result(std::nullopt);
      error_code ec;
      const std::size_t room = std::min<std::size_t>(16u << 10, kReadBuffer - buffer_.size());
      const std::size_t n = co_await socket_.async_read_some(buffer_.prepare(room),
                                                             asio::redirect_error(asio::use_awaitable, ec));
      buffer_.commit(n);
      if (ec) {
        if (timed_out_ && started)
          co_return refuse(HttpProblem::kRequestTimeout,
                           "The header was not complete within " +
                               std::to_string(api_.limits().header_timeout.count()) + " ms.");
        co_return Result(std::nullopt);
      }
      if (!started) {
        started = true;
        set_busy(true);
        set_deadline(steady_clock::now() + api_.limits().header_timeout);
      }
    }
  }

  /// Reads the body into request.body. The header that the guard has approved goes through Beast's parser
  /// too: two opinions that must agree. Sets closed_ when the client went away.
  asio::awaitable<std::optional<Problem>> read_body(Request& request) {
    bhttp::request_parser<bhttp::string_body> parser;
    parser.header_limit(static_cast<std::uint32_t>(api_.limits().max_header + 1));
    parser.body_limit(request.admission.max_body);
    error_code ec;
    const std::size_t used = parser.put(asio::buffer(buffer_.cdata().data(), head_size_), ec);
    if (ec == bhttp::error::body_limit)
      co_return Problem(HttpProblem::kBodyTooLarge, body_limit_text(request.admission));
    if ((ec && ec != bhttp::error::need_more) || !parser.is_header_done() || used != head_size_)
      co_return Problem(HttpProblem::kMalformedRequest,
                        "The header was not understood (" + ec.message() + ").");
    buffer_.consume(head_size_);
    if (parser.is_done()) co_return std::nullopt;

    request.reservation = MemoryBudget::Reservation(api_.bodies());
    if (!request.reservation.grow_to(request.head.content_length.value_or(0))) co_return api_.no_memory();

    if (request.head.expects_continue && buffer_.size() == 0) {
      static constexpr std::string_view kContinue = "HTTP/1.1 100 Continue\r\n\r\n";
      set_deadline(steady_clock::now() + api_.limits().write_stall);
      co_await asio::async_write(socket_, asio::buffer(kContinue.data(), kContinue.size()),
                                 asio::redirect_error(asio::use_awaitable, ec));
      if (ec) {
        closed_ = true;
        co_return std::nullopt;
      }
    }

    const HttpLimits& limits = api_.limits();
    const steady_clock::time_point start = steady_clock::now();
    std::uint64_t wire = 0;
    const std::uint64_t max_wire = kMaxWireFactor * request.admission.max_body + kWireAllowance;
    while (!parser.is_done()) {
      const std::uint64_t received = parser.get().body().size();
      const auto earned =
          std::chrono::milliseconds(1000 * received / std::max<std::uint64_t>(1, limits.body_rate));
      // What a fast start has earned is not to be spent on one long silence.
      set_deadline(std::min(start + limits.body_grace + earned, steady_clock::now() + limits.write_stall));
      const std::size_t n = co_await bhttp::async_read_some(socket_, buffer_, parser,
                                                            asio::redirect_error(asio::use_awaitable, ec));
      wire += n;
      if (!request.reservation.grow_to(parser.get().body().size())) co_return api_.no_memory();
      if (ec == bhttp::error::body_limit)
        co_return Problem(HttpProblem::kBodyTooLarge, body_limit_text(request.admission));
      if (timed_out_)
        co_return Problem(
            HttpProblem::kRequestTimeout,
            "The body arrived slower than " + std::to_string(limits.body_rate) + " bytes a second.");
      if (ec == bhttp::error::buffer_overflow || wire > max_wire)
        co_return Problem(HttpProblem::kHeaderTooLarge,
                          "The body has oversized chunk extensions or trailer fields.");
      if (ec == bhttp::error::partial_message || ec == bhttp::error::end_of_stream || ec == asio::error::eof)
        co_return Problem(HttpProblem::kMalformedRequest,
                          "The connection was half-closed before the body was complete.");
      if (ec && ec.category() == bhttp::make_error_code(bhttp::error::bad_chunk).category())
        co_return Problem(HttpProblem::kMalformedRequest,
                          "The chunked body is malformed (" + ec.message() + ").");
      if (ec) {
        closed_ = true;
        co_return std::nullopt;
      }
    }
    clear_deadline();
    request.body = std::move(parser.get().body());
    if (request.head.method == "POST" &&
        request.body.empty())  // only chunked bodies are found empty this late
      co_return Problem(Error{ErrorCode::kEmptyBody, "The body is empty.", "mesh"});
    co_return std::nullopt;
  }

  static std::string body_limit_text(const Admission& admission) {
    return "The body is larger than the limit of " + std::to_string(admission.max_body) + " bytes.";
  }

  /// Fills exchange_->response.
  asio::awaitable<void> compute() {
    const std::shared_ptr<Exchange> exchange = exchange_;
    stop_ = std::stop_source();
    job_done_.expires_at(steady_clock::time_point::max());
    api_.start(std::shared_ptr<Request>(exchange, &exchange->request), stop_.get_token(),
               [self = shared_from_this(), exchange](Response response) {
                 asio::dispatch(self->socket_.get_executor(),
                                [self, exchange, response = std::move(response)]() mutable {
                                  exchange->response = std::move(response);
                                  exchange->done = true;
                                  self->job_done_.cancel();
                                });
               });
    if (exchange->done) co_return;
    watch_for_reset();
    while (!exchange->done) {
      error_code ignored;
      co_await job_done_.async_wait(asio::redirect_error(asio::use_awaitable, ignored));
    }
    abort_io();  // ends the wait for a reset
  }

  /// A reset (not a half-close: that client still reads) means nobody wants the answer any more.
  void watch_for_reset() {
    socket_.async_wait(tcp::socket::wait_error, [weak = weak_from_this()](error_code ec) {
      const auto self = weak.lock();
      if (ec || !self || !self->is_reset()) return;
      self->stop_.request_stop();
      self->job_done_.cancel();
    });
  }

  /// The pending error of the socket: set by a reset, not by urgent data, which wakes the same wait.
  bool is_reset() {
    int error = 0;
    socklen_t size = sizeof error;
    return ::getsockopt(socket_.native_handle(), SOL_SOCKET, SO_ERROR, &error, &size) == 0 && error != 0;
  }

  /// Status line and the fields that every answer has.
  template <class Body>
  bhttp::response<Body> begin_message(const Response& response, bool keep_alive) const {
    bhttp::response<Body> message;
    message.version(11);
    message.result(static_cast<unsigned>(response.status));
    message.set(bhttp::field::server, "fracture-server/" FRACTURE_VERSION);
    if (!response.content_type.empty()) message.set(bhttp::field::content_type, response.content_type);
    message.set(bhttp::field::date, http_date());
    message.set("X-Request-Id", id_);
    message.set("X-Content-Type-Options", "nosniff");
    for (const auto& [name, value] : response.headers) message.insert(name, value);
    message.keep_alive(keep_alive);
    return message;
  }

  /// False when the client is gone or took nothing for too long.
  asio::awaitable<bool> write(const Response& response, bool keep_alive, bool head_only) {
    if (response.stream) co_return co_await write_stream(response, keep_alive, head_only);
    auto message = begin_message<bhttp::span_body<const std::uint8_t>>(response, keep_alive);
    message.body() = beast::span<const std::uint8_t>(response.body.data(), response.body.size());
    if (response.status != 304) message.content_length(response.body.size());

    bhttp::response_serializer<bhttp::span_body<const std::uint8_t>> serializer(message);
    serializer.split(head_only);
    while (head_only ? !serializer.is_header_done() : !serializer.is_done()) {
      set_deadline(steady_clock::now() + api_.limits().write_stall);
      error_code ec;
      co_await bhttp::async_write_some(socket_, serializer, asio::redirect_error(asio::use_awaitable, ec));
      if (ec) {
        clear_deadline();
        co_return false;
      }
    }
    clear_deadline();
    co_return true;
  }

  /// Chunks as the stream delivers them, until it ends or the server drains. An HTTP/1.0 client knows no
  /// chunks: its answer ends with the connection.
  asio::awaitable<bool> write_stream(const Response& response, bool keep_alive, bool head_only) {
    const bool chunked = exchange_->request.head.minor_version >= 1;
    auto message = begin_message<bhttp::empty_body>(response, keep_alive && chunked);
    message.chunked(chunked);
    bhttp::response_serializer<bhttp::empty_body> serializer(message);
    error_code ec;
    set_deadline(steady_clock::now() + api_.limits().write_stall);
    co_await bhttp::async_write_header(socket_, serializer, asio::redirect_error(asio::use_awaitable, ec));
    while (!ec && !head_only) {
      clear_deadline();
      struct Next {
        bool there = false;
        std::optional<std::string> bytes;
      };
      const auto next = std::make_shared<Next>();
      stop_ = std::stop_source();
      job_done_.expires_at(steady_clock::time_point::max());
      response.stream->next([weak = weak_from_this(), next](std::optional<std::string> bytes) {
        const auto self = weak.lock();
        if (!self) return;
        asio::dispatch(self->socket_.get_executor(), [weak, next, bytes = std::move(bytes)]() mutable {
          next->there = true;
          next->bytes = std::move(bytes);
          if (const auto session = weak.lock()) session->job_done_.cancel();
        });
      });
      if (!next->there) {
        watch_for_reset();
        while (!next->there && !closing() && !stop_.stop_requested())
          co_await job_done_.async_wait(asio::redirect_error(asio::use_awaitable, ec));
        abort_io();  // ends the wait for a reset
        ec = {};
      }
      if (stop_.stop_requested()) co_return false;
      const bool last = !next->there || !next->bytes;
      if (last && !chunked) break;
      set_deadline(steady_clock::now() + api_.limits().write_stall);
      if (last) {
        co_await asio::async_write(socket_, bhttp::make_chunk_last(),
                                   asio::redirect_error(asio::use_awaitable, ec));
        break;
      }
      const asio::const_buffer bytes(next->bytes->data(), next->bytes->size());
      if (chunked)
        co_await asio::async_write(socket_, bhttp::make_chunk(bytes),
                                   asio::redirect_error(asio::use_awaitable, ec));
      else
        co_await asio::async_write(socket_, bytes, asio::redirect_error(asio::use_awaitable, ec));
    }
    clear_deadline();
    co_return !ec && chunked;
  }

  asio::awaitable<void> refuse_and_close(const Response& response, std::string_view method,
                                         std::string_view path, steady_clock::time_point start) {
    const bool written = co_await write(response, false, method == "HEAD");
    log(method, path, response, start);
    if (written) co_await linger();
  }

  asio::awaitable<void> linger() {
    error_code ec;
    socket_.shutdown(tcp::socket::shutdown_send, ec);
    const steady_clock::time_point end = steady_clock::now() + kLingerTotal;
    std::array<char, 4096> rubbish;
    while (!ec) {
      set_deadline(std::min(end, steady_clock::now() + kLingerIdle));
      co_await socket_.async_read_some(asio::buffer(rubbish), asio::redirect_error(asio::use_awaitable, ec));
      if (steady_clock::now() >= end) break;
    }
    clear_deadline();
    socket_.close(ec);
  }

  asio::awaitable<void> turn_away() {
    id_ = new_request_id();
    const bool full = verdict_ == Connections::Verdict::kFull;
    const Problem problem =
        full ? Problem(HttpProblem::kOverloaded, "All connections of this server are in use.")
                   .with("Retry-After", "2")
             : Problem(HttpProblem::kTooManyConnections,
                       "This address has more connections open than the limit of " +
                           std::to_string(api_.limits().max_connections_per_address) + ".")
                   .with("Retry-After", "2");
    const Response response = Response::problem(problem, id_);
    co_await refuse_and_close(response, "?", "?", steady_clock::now());
  }

  tcp::socket socket_;
  asio::steady_timer timer_;
  asio::steady_timer job_done_;  // never expires: cancelled when the job is done
  beast::flat_buffer buffer_{kReadBuffer};
  const Listener listener_;
  Api& api_;
  Connections& connections_;
  const Connections::Verdict verdict_;
  const std::string address_;
  std::shared_ptr<Exchange> exchange_;
  std::stop_source stop_;
  std::string id_;
  std::size_t head_size_ = 0;
  std::uint64_t deadline_generation_ = 0;
  bool timed_out_ = false;
  bool busy_ = false;     // a request is in progress
  bool closing_ = false;  // drain: answer what is in progress, then close
  bool closed_ = false;   // the client is gone
};

}  // namespace

void start_session(tcp::socket socket, Listener listener, Api& api, Connections& connections,
                   Connections::Verdict verdict, const std::string& address) {
  const auto session =
      std::make_shared<Session>(std::move(socket), listener, api, connections, verdict, address);
  connections.enroll(session);
  session->start();
}

}  // namespace fracture::http
