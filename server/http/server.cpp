#include "server/http/server.hpp"
#include "server/http/client_address.hpp"

#include <spdlog/spdlog.h>
#include <sys/resource.h>

#include <algorithm>
#include <exception>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "common/base/bulk.hpp"
#include "common/base/processor_time.hpp"
#include "server/http/asio.hpp"
#include "server/http/connections.hpp"
#include "server/http/io_turns.hpp"
#include "server/http/session.hpp"
#include "server/http/tenant_metrics.hpp"

namespace fracture::http {
namespace {

/// File descriptors reserved for purposes other than connections: logs, listeners, event queues, and files
/// that libraries open briefly.
constexpr std::size_t kReservedDescriptors = 64;
/// Number of these for connections of the admin listener, which may all belong to one client.
constexpr std::size_t kAdminConnections = 16;
/// File descriptors needed in addition to the public listener's places. Each listener can exceed its places
/// for a moment.
constexpr std::size_t kBeside = kReservedDescriptors + 2 * Connections::kMostBeyond;
/// Pause after a failed accept. Without it, a process at its descriptor limit would spin, because the
/// listening socket stays readable.
constexpr std::chrono::milliseconds kAcceptBackOff{75};

std::size_t connection_limit(std::size_t wanted) {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return wanted;
  if (limit.rlim_cur < limit.rlim_max) {
    limit.rlim_cur = limit.rlim_max;
    if (setrlimit(RLIMIT_NOFILE, &limit) != 0) getrlimit(RLIMIT_NOFILE, &limit);
  }
  const auto files = static_cast<std::size_t>(limit.rlim_cur);
  const std::size_t usable = files > 2 * kBeside ? files - kBeside : files / 2;
  if (usable < wanted)
    spdlog::warn("at most {} connections are possible, because the limit on open files is {}", usable,
                 limit.rlim_cur);
  return std::min(wanted, usable);
}

/// Runs io_context::run(). As a last resort, exceptions from handlers are logged and the loop continues.
/// Calls `turned` after each turn, also after one that ended with an exception.
template <class Turned>
void run_forever(asio::io_context& context, Turned turned) {
  for (bool failed = false;; failed = true) {
    try {
      if (failed) turned();
      while (context.run_one() > 0) turned();
      return;
    } catch (const std::exception& e) {
      spdlog::error("an exception reached the io loop: {}", e.what());
    } catch (...) {
      spdlog::error("an unknown exception reached the io loop");
    }
  }
}

/// Runs the public listener. All clients share its threads, so the work in each turn is measured and limited.
void run_public(asio::io_context& context, ops::Metrics& metrics, BulkLimit& bulk, IoTurns& turns) {
  limit_bulk(&bulk);
  double before = processor_seconds_of_this_thread();
  run_forever(context, [&] {
    const double now = processor_seconds_of_this_thread();
    const double used = now - std::exchange(before, now);
    begin_bulk_turn();
    metrics.count_io_turn(used);
    turns.end_turn(used);
  });
}

tcp::acceptor open_acceptor(asio::io_context& context, const std::string& address, std::uint16_t port) {
  try {
    const tcp::endpoint endpoint(asio::ip::make_address(address), port);
    tcp::acceptor acceptor(asio::make_strand(context));
    acceptor.open(endpoint.protocol());
    acceptor.set_option(tcp::acceptor::reuse_address(true));
    acceptor.bind(endpoint);
    acceptor.listen(1024);
    return acceptor;
  } catch (const boost::system::system_error& e) {
    throw std::system_error(e.code().value(), std::generic_category(),
                            "cannot listen on " + address + " port " + std::to_string(port));
  }
}

void count(ops::Metrics& metrics, Connections::Verdict verdict) {
  metrics.count_connection();
  if (verdict == Connections::Verdict::kFull) metrics.count_refused_connection(ops::Metrics::Refusal::kFull);
  if (verdict == Connections::Verdict::kTooManyOfClient)
    metrics.count_refused_connection(ops::Metrics::Refusal::kTooManyOfAddress);
}

/// Accepts connections until the acceptor is closed.
asio::awaitable<void> accept_connections(tcp::acceptor& acceptor, asio::io_context& context,
                                         SessionContext shared) {
  asio::steady_timer pause(acceptor.get_executor());
  while (acceptor.is_open()) {
    error_code ec;
    tcp::socket socket(asio::make_strand(context));
    co_await acceptor.async_accept(socket, asio::redirect_error(asio::use_awaitable, ec));
    if (ec == asio::error::operation_aborted || !acceptor.is_open()) co_return;
    if (ec) {
      if (ec == asio::error::connection_aborted) continue;  // the client left while it was queued
      spdlog::warn("accept failed: {}", ec.message());
      pause.expires_after(kAcceptBackOff);
      co_await pause.async_wait(asio::redirect_error(asio::use_awaitable, ec));
      continue;
    }
    const tcp::endpoint peer = socket.remote_endpoint(ec);
    if (ec) continue;
    const std::string address = peer.address().to_string();
    const auto limit = shared.listener == Listener::kAdmin ? Connections::OfClient::kUnlimited
                                                           : shared.policy.limit_of(address);
    Connections::Arrival arrival = shared.connections.add(client_of(address), limit);
    if (shared.listener == Listener::kPublic) count(shared.api.metrics(), arrival.verdict);
    if (arrival.place) start_session(std::move(socket), shared, std::move(arrival), address);
  }
}

/// Keeps accepting: an error with one connection (no memory for its session) does not affect the next one.
asio::awaitable<void> accept_loop(tcp::acceptor& acceptor, asio::io_context& context, SessionContext shared) {
  asio::steady_timer pause(acceptor.get_executor());
  while (acceptor.is_open()) {
    try {
      co_await accept_connections(acceptor, context, shared);
      co_return;
    } catch (const std::exception& e) {
      spdlog::error("a connection could not be handled: {}", e.what());
    }
    pause.expires_after(kAcceptBackOff);
    error_code ignored;
    co_await pause.async_wait(asio::redirect_error(asio::use_awaitable, ignored));
  }
}

}  // namespace

class HttpServer::Impl {
 public:
  Impl(const ServerConfig& config, Api& api)
      : api_(api),
        policy_{tenants::Accounts(config.tokens), config.proxies, CorsPolicy(config.cors_origins),
                SitePolicy(config.allowed_hosts, CorsPolicy(config.cors_origins))},
        max_connections_(connection_limit(api.limits().max_connections)),
        connections_(max_connections_, api.limits().max_connections_per_address),
        admin_connections_(kAdminConnections, kAdminConnections),
        turns_(static_cast<std::size_t>(std::max(1, config.io_threads)),
               [this](IoTurns::Call call) { asio::defer(context_, std::move(call)); }),
        public_acceptor_(open_acceptor(context_, config.address, config.port)),
        admin_acceptor_(open_acceptor(admin_context_, config.admin_address, config.admin_port)),
        port_(public_acceptor_.local_endpoint().port()),
        admin_port_(admin_acceptor_.local_endpoint().port()) {
    asio::co_spawn(
        public_acceptor_.get_executor(),
        accept_loop(public_acceptor_, context_, {Listener::kPublic, api, connections_, policy_, &turns_}),
        asio::detached);
    asio::co_spawn(
        admin_acceptor_.get_executor(),
        accept_loop(admin_acceptor_, admin_context_, {Listener::kAdmin, api, admin_connections_, policy_}),
        asio::detached);
    metrics_source_ = api.metrics().add_source([this](ops::MetricWriter& writer) {
      writer.gauge("fracture_connections", "Open connections of the public listener.",
                   static_cast<double>(connections_.count()));
      writer.gauge("fracture_connections_limit", "Limit on open connections.",
                   static_cast<double>(max_connections_));
      writer.gauge("fracture_requests_in_progress",
                   "Time from the first byte of a request to the last byte of its answer.",
                   static_cast<double>(connections_.in_progress.load()));
      writer.counter(
          "fracture_io_bulk_turns_total",
          "Turns in which an I/O thread did more work than one turn should contain. Each is a bug.",
          static_cast<double>(bulk_.exceeded.load()));
      const auto holdings = [this](const std::string& name) {
        return Holdings{api_.meshes().bytes_of(name) + api_.jobs().disk_bytes_of(name),
                        api_.ledger().bytes_of(name)};
      };
      write_tenant_metrics(policy_.accounts, holdings, writer);
    });
    api.resume_jobs([this](const std::string& name) -> AccountPointer {
      for (AccountPointer& account : policy_.accounts.all())
        if (account->name() == name) return std::move(account);
      return nullptr;
    });
    for (int t = 0; t < std::max(1, config.io_threads); ++t)
      threads_.emplace_back([this] { run_public(context_, api_.metrics(), bulk_, turns_); });
    threads_.emplace_back([this] { run_forever(admin_context_, [] {}); });
  }

  ~Impl() {
    work_.reset();
    admin_work_.reset();
    context_.stop();
    admin_context_.stop();
    for (std::thread& thread : threads_) thread.join();
    turns_.stop();
    // No handler can run or submit work any more. Work that was submitted may still use sessions and
    // contexts.
    api_.wait_idle();
    api_.metrics().remove_source(metrics_source_);
  }

  void stop_accepting() {
    connections_.stopping = true;
    asio::post(public_acceptor_.get_executor(), [this] {
      error_code ignored;
      public_acceptor_.close(ignored);
    });
    for (const auto& session : connections_.sessions()) session->close_when_idle();
  }
  void cancel_jobs() {
    for (const auto& session : connections_.sessions()) session->cancel_job();
    api_.stop_jobs();
  }

  Api& api_;
  Policy policy_;
  std::size_t max_connections_;
  // Handlers of the contexts own sessions, which use the connections and the turns, so the contexts must be
  // destroyed first.
  Connections connections_, admin_connections_;
  IoTurns turns_;
  asio::io_context context_, admin_context_{1};
  asio::executor_work_guard<asio::io_context::executor_type> work_{context_.get_executor()},
      admin_work_{admin_context_.get_executor()};
  tcp::acceptor public_acceptor_, admin_acceptor_;
  std::uint16_t port_, admin_port_;
  int metrics_source_ = 0;
  BulkLimit bulk_{kMostInTurn};
  std::vector<std::thread> threads_;
};

HttpServer::HttpServer(const ServerConfig& config, Api& api) : impl_(std::make_unique<Impl>(config, api)) {}
HttpServer::~HttpServer() = default;

std::uint16_t HttpServer::port() const { return impl_->port_; }
std::uint16_t HttpServer::admin_port() const { return impl_->admin_port_; }
void HttpServer::stop_accepting() { impl_->stop_accepting(); }
void HttpServer::cancel_jobs() { impl_->cancel_jobs(); }
void HttpServer::replace_tokens(tenants::TokenFile tokens) {
  impl_->policy_.accounts.replace(std::move(tokens));
  for (const auto& session : impl_->connections_.sessions()) session->tokens_changed();
}
std::uint64_t HttpServer::bulk_turns() const { return impl_->bulk_.exceeded; }
std::size_t HttpServer::connections() const { return impl_->connections_.count(); }
std::size_t HttpServer::requests_in_progress() const { return impl_->connections_.in_progress.load(); }

}  // namespace fracture::http
