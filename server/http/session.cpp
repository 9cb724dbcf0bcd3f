#include "server/http/session.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "server/http/answer_writer.hpp"
#include "server/http/client_address.hpp"
#include "server/http/head_reader.hpp"
#include "server/http/proxied.hpp"
#include "server/http/request_body.hpp"
#include "server/http/request_id.hpp"
#include "server/http/request_notes.hpp"
#include "server/http/stream_writer.hpp"
#include "server/http/timed_socket.hpp"
#include "server/http/turn_wait.hpp"
#include "server/http/turned_away.hpp"
#include "server/http/work_wait.hpp"
#include "server/ops/log.hpp"

namespace fracture::http {
namespace {

using std::chrono::steady_clock;

/// Time left for a connection that only receives a refusal, or that has lost its place.
constexpr std::chrono::seconds kLastWords{2};

double milliseconds_since(steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(steady_clock::now() - start).count();
}

/// A request and its answer, which the pool passes to the session. Shared, because either side may outlive
/// the other.
struct Exchange {
  Request request;
  Response response;
  bool done = false;
};

class Session final : public std::enable_shared_from_this<Session>, public Drainable {
 public:
  Session(tcp::socket socket, const SessionContext& context, Connections::Arrival arrival,
          std::string address)
      : connection_(std::make_shared<TimedSocket>(std::move(socket))),
        work_(std::make_shared<WorkWait>(connection_, buffer_)),
        turn_(std::make_shared<TurnWait>(context.turns, executor())),
        context_(context),
        api_(context.api),
        connections_(context.connections),
        verdict_(arrival.verdict),
        place_(std::move(arrival.place)),
        address_(std::move(address)),
        client_(address_),
        proxied_(context.listener == Listener::kPublic && context.policy.proxies.contains(address_)) {}

  ~Session() override {
    if (busy_) connections_.in_progress.fetch_sub(1);
  }

  void start() {
    place_.enroll(shared_from_this());
    asio::co_spawn(
        executor(), [self = shared_from_this()] { return self->run(); },
        [self = shared_from_this()](std::exception_ptr failure) {
          if (!failure) return;
          try {
            std::rethrow_exception(failure);
          } catch (const std::exception& e) {
            spdlog::error("a session ended with an exception: {}", e.what());
          } catch (...) {
            spdlog::error("a session ended with an unknown exception");
          }
        });
  }

  void close_when_idle() override {
    asio::post(executor(), [self = shared_from_this()] {
      self->closing_ = true;
      if (!self->busy_) self->connection_->abort();
      self->work_->wake();  // ends an event stream
    });
  }

  void give_way(Leave how) override {
    asio::post(executor(), [self = shared_from_this(), how] {
      self->closing_ = true;
      if (how == Leave::kIfItWaits && !self->waiting_since()) return;
      self->giving_way_ = true;
      self->connection_->end_by(steady_clock::now() + kLastWords);
      self->work_->cancel();
      self->work_->wake();  // ends an event stream
      self->turn_->cancel();
      self->connection_->abort();
    });
  }

  void cancel_job() override {
    asio::post(executor(), [self = shared_from_this()] { self->work_->cancel(); });
  }

  void tokens_changed() override {  // an event stream checks its permission again
    asio::post(executor(), [self = shared_from_this()] { self->work_->wake(); });
  }

 private:
  asio::any_io_executor executor() { return connection_->socket().get_executor(); }
  bool closing() const { return closing_ || connections_.stopping; }

  void set_busy(bool busy) {
    if (busy == busy_) return;
    busy_ = busy;
    if (busy)
      connections_.in_progress.fetch_add(1);
    else
      connections_.in_progress.fetch_sub(1);
  }

  asio::awaitable<void> run() {
    if (verdict_ != Connections::Verdict::kWelcome) {
      begin_record(new_request_id());
      connection_->end_by(start_ + kLastWords);
      // A variable: g++ 12 destroys such a temporary twice.
      const Problem refusal = turned_away(verdict_, api_.limits());
      co_await refuse_and_close(refusal);
      co_return;
    }
    if (proxied_) {
      begin_record(new_request_id());
      std::optional<OrProblem<std::string>> client =
          co_await read_proxy_header(*connection_, buffer_, api_.limits());
      if (!client) co_return;
      if (!*client) {
        co_await refuse_and_close(client->error());
        co_return;
      }
      if (!(*client)->empty()) client_ = std::move(**client);
    }
    for (;;) {
      set_busy(false);
      set_waiting(true);
      exchange_ = std::make_shared<Exchange>();  // an idle connection must not keep a result alive
      begin_record(new_request_id());
      // Until the next request, the place counts for the proxy, or for the client in its PROXY header.
      if (proxied_) place_.belongs_to(client_key_, context_.policy.limit_of(client_));
      OrProblem<std::optional<RequestHead>> head = co_await read_head();
      start_ = steady_clock::now();
      if (!head) {
        co_await refuse_and_close(head.error());
        co_return;
      }
      if (!*head) co_return;  // closed, or idle for too long between requests
      set_waiting(true);      // for the body
      exchange_->request.head = std::move(**head);
      if (!co_await answer()) co_return;
    }
  }

  /// Handles one request, from its header in exchange_ to the last byte of its answer. Returns false if the
  /// connection must end.
  asio::awaitable<bool> answer() {
    Request& request = exchange_->request;
    const RequestHead& head = request.head;
    request.id = request_id(head);
    begin_record(request.id);
    note_request(record_, head);
    record_.address = forwarded_client(client_, head.field("forwarded"), context_.policy.proxies);
    client_key_ = request.address = client_of(record_.address);
    // A connection from a proxy counts for the client that the proxy names.
    if (proxied_ && !place_.belongs_to(client_key_, context_.policy.limit_of(record_.address))) {
      const Problem full = too_many_connections(api_.limits());
      co_await refuse_and_close(full);
      co_return false;
    }

    std::optional<Response> preflight;
    std::optional<Problem> refusal;
    if (context_.listener == Listener::kPublic) {
      policy_fields_ = context_.policy.cors.fields(head);
      preflight = context_.policy.cors.preflight(head);
      request.payer.flow.name = "address " + client_key_;
      if (!preflight) refusal = enter(head);
    }
    if (!turn_->at_once(request.payer.flow))
      if (!co_await turn()) co_return false;
    if (!refusal && !preflight && (context_.listener == Listener::kAdmin || context_.policy.accounts.open()))
      refusal = context_.policy.sites.refuse(head);
    if (refusal) {
      co_await refuse_and_close(*refusal);
      co_return false;
    }
    if (preflight) {
      connection_->clear_deadline();
      buffer_.consume(head_size_);
      exchange_->response = std::move(*preflight);
    } else {
      OrProblem<Admission> admission = api_.admit(context_.listener, head, request.payer);
      if (!admission) {
        co_await refuse_and_close(admission.error());
        co_return false;
      }
      request.admission = std::move(*admission);
      record_.route = request.admission.route->path;

      BodyOutcome body = co_await read_body(*connection_, buffer_, head_size_, api_, request, client_key_);
      record_.bytes_in = request.body_bytes();
      if (body.problem) {
        request.reservation = {};
        co_await refuse_and_close(*body.problem);
        co_return false;
      }
      if (body.closed) {
        Response none;
        none.status = 0;
        finish_record(none, false);
        co_return false;
      }
      if (!turn_->at_once(request.payer.flow))
        if (!co_await turn()) co_return false;
      set_waiting(false);
      const bool wanted = co_await compute();
      set_waiting(true);
      if (!wanted) {
        const Problem gone = client_closed();
        co_await refuse_and_close(gone);
        co_return false;
      }
      // The request may have waited for a job, so check again whether the token still permits reading.
      if (waited_ && head.method == "GET")
        if (const std::optional<Problem> revoked =
                refuse_by_now(context_.policy.accounts, head, request.payer.account)) {
          exchange_->response = {};  // frees the answer, which is not counted yet
          co_await refuse_and_close(*revoked);
          co_return false;
        }
      record_.queue_milliseconds = exchange_->response.queue_milliseconds;
    }

    // HTTP/1.0 has no chunks, so the end of the connection marks the end of a stream.
    const bool endless = exchange_->response.stream && head.minor_version < 1;
    const bool keep = head.keep_alive && !closing() && !endless;
    const bool written = co_await write(exchange_->response, keep, request.admission.head_only);
    finish_record(exchange_->response, written);
    if (written && !keep) co_await connection_->linger();
    co_return written&& keep;
  }

  /// Assigns the request to the account of its token. Returns the refusal, if any.
  std::optional<Problem> enter(const RequestHead& head) {
    OrProblem<AccountPointer> account = authenticate(context_.policy.accounts, head, api_.shows_page());
    if (!account) return std::move(account.error());
    if (!*account) return std::nullopt;
    tenants::Account& caller = **account;
    record_.client = caller.name();
    exchange_->request.payer = {*account, {"name " + caller.name(), caller.shares().weight}};
    std::optional<Problem> refusal = refuse_caller(caller, head);
    for (auto& field : caller.rate_fields()) policy_fields_.push_back(std::move(field));
    return refusal;
  }

  /// Waits for this client's turn. If it does not come in time, refuses the request and returns false.
  asio::awaitable<bool> turn() {
    set_waiting(false);  // not for the client
    const steady_clock::time_point end = steady_clock::now() + api_.limits().header_timeout;
    const bool came = co_await turn_->until_turn(exchange_->request.payer.flow, end);
    set_waiting(true);
    if (!came) {
      exchange_->request.reservation = {};
      const Problem late = turn_too_late(giving_way_, api_.limits());
      co_await refuse_and_close(late);
    }
    co_return came;
  }

  void begin_record(std::string id) {
    start_ = steady_clock::now();
    id_ = id;
    policy_fields_.clear();
    record_ = {};
    record_.admin = context_.listener == Listener::kAdmin;
    record_.id = std::move(id);
    record_.address = client_;
    client_key_ = client_of(client_);
  }

  void finish_record(const Response& response, bool written) {
    note_answer(record_, response);
    record_.delivered = written;
    record_.milliseconds = milliseconds_since(start_);
    api_.metrics().count_request(record_);
    ops::log_request(record_);
    if (const auto& account = exchange_->request.payer.account) {
      account->count_answer(record_.bytes_in, record_.bytes_out);
      if (record_.method != "GET" && record_.method != "HEAD") ops::log_audit(record_);
    }
  }

  asio::awaitable<OrProblem<std::optional<RequestHead>>> read_head() {
    return http::read_head(
        *connection_, buffer_, api_.limits(), context_.listener, head_size_,
        [this](bool started) { return giving_way_ || (closing() && !started); }, [this] { set_busy(true); });
  }

  /// Fills exchange_->response. Returns false if the client has left and its work was stopped.
  asio::awaitable<bool> compute() {
    const std::shared_ptr<Exchange> exchange = exchange_;
    Request& request = exchange->request;
    const bool alone = goes_on_alone(request.admission.route->operation, request.head);
    work_->expect(request.head.half_closes ? HalfClose::kStillReads : HalfClose::kIsGone);
    request.client_left = work_->begin();
    api_.start(std::shared_ptr<Request>(exchange, &request), alone ? work_->cancelled() : request.client_left,
               [self = shared_from_this(), exchange](Response response) {
                 asio::dispatch(self->executor(), [self, exchange, response = std::move(response)]() mutable {
                   exchange->response = std::move(response);
                   exchange->done = true;
                   self->work_->wake();
                 });
               });
    const std::function<bool()> done = [exchange] { return exchange->done; };
    waited_ = !done();
    co_await work_->until(done);
    if (alone || !work_->client_left()) co_return true;
    api_.metrics().count_abandoned_work();
    co_return false;
  }

  /// Counts the answer as held by this client until `hold` is destroyed. If there is no memory for it,
  /// replaces the answer with a refusal. Frees the bytes of an answer that is sent without its body.
  void count_answer(Response& response, bool head_only, HeldBuffers::Hold& hold) {
    if (head_only || response.body.empty()) response.owner.reset();
    if (!response.owner) return;
    const std::uint64_t held = std::max<std::uint64_t>(response.body.size(), response.owner_bytes);
    if (const auto refusal = api_.hold_answer(client_key_, response.owner.get(), held, hold))
      response = Response::problem(*refusal, id_);
  }

  /// Returns false if the client is gone or reads the answer too slowly.
  asio::awaitable<bool> write(Response& response, bool keep_alive, bool head_only) {
    if (response.stream) {
      const Request& request = exchange_->request;
      const auto allowed = [this, &request] {
        return !refuse_by_now(context_.policy.accounts, request.head, request.payer.account);
      };
      const StreamTarget target{*connection_, work_, api_.limits(), [this] { return closing(); }, allowed};
      const bool chunked = exchange_->request.head.minor_version >= 1;
      co_return co_await write_stream(target, response, id_, policy_fields_, chunked, keep_alive, head_only);
    }
    HeldBuffers::Hold hold;
    count_answer(response, head_only, hold);
    const bool written = co_await write_answer(*connection_, api_.limits(), response, id_, policy_fields_,
                                               keep_alive, head_only);
    // Frees the bytes before `hold` ends, because the connection may linger. The log still needs their number.
    response.owner.reset();
    co_return written && !giving_way_;
  }

  asio::awaitable<void> refuse_and_close(const Problem& problem) {
    Response response = Response::problem(problem, id_);
    const bool written = co_await write(response, false, record_.method == "HEAD");
    finish_record(response, written);
    if (written) co_await connection_->linger();
  }

  const std::shared_ptr<TimedSocket> connection_;
  const std::shared_ptr<WorkWait> work_;
  const std::shared_ptr<TurnWait> turn_;
  beast::flat_buffer buffer_{kReadBuffer};
  const SessionContext context_;
  Api& api_;
  Connections& connections_;
  const Connections::Verdict verdict_;
  Connections::Place place_;
  const std::string address_;  // of the peer
  std::string client_;         // the client named by the PROXY protocol, else the peer
  const bool proxied_;         // the peer is a trusted proxy
  std::string client_key_;     // client_of() of the requesting address, for shared limits
  std::shared_ptr<Exchange> exchange_ = std::make_shared<Exchange>();
  std::string id_;        // of the current request
  Fields policy_fields_;  // CORS and rate limit fields
  ops::RequestRecord record_;
  steady_clock::time_point start_{};
  std::size_t head_size_ = 0;
  bool busy_ = false;    // a request is in progress
  bool waited_ = false;  // the answer was not ready at once
  bool giving_way_ = false;
  bool closing_ = false;  // close after the current answer: draining, or the place is lost
};

}  // namespace

void start_session(tcp::socket socket, const SessionContext& context, Connections::Arrival arrival,
                   const std::string& address) {
  std::make_shared<Session>(std::move(socket), context, std::move(arrival), address)->start();
}

}  // namespace fracture::http
