#include "server/bake/http_caller.hpp"

#include <boost/asio/use_future.hpp>
#include <charconv>
#include <string_view>
#include <thread>

#include "common/exchange/connection_pool.hpp"
#include "common/exchange/tls.hpp"

namespace fracture::bake {

namespace asio = protocol::asio;

Expected<protocol::ConnectionSettings> parse_server_url(const std::string& url, const std::string& ca_file) {
  const auto wrong = [&](const char* why) {
    return fail(ErrorCode::kBadParameter, "--server must be http://host:port or https://host:port; '" +
                                              url.substr(0, 200) + "' " + why + ".");
  };
  constexpr std::string_view kPlain = "http://", kTls = "https://";
  std::string_view rest = url;
  const bool tls = rest.starts_with(kTls);
  if (!tls && !rest.starts_with(kPlain)) return wrong("begins with another scheme");
  if (!tls && !ca_file.empty()) return wrong("is not https, but --ca-file is for https only");
  rest.remove_prefix(tls ? kTls.size() : kPlain.size());
  if (rest.ends_with('/')) rest.remove_suffix(1);
  if (rest.find_first_of("/?#") != std::string_view::npos) return wrong("has a path");
  if (rest.find('@') != std::string_view::npos)
    return wrong("has a user name; give the token in FRACTURE_TOKEN");
  protocol::ConnectionSettings settings;
  settings.port = tls ? 443 : 80;
  std::string_view port;
  if (rest.starts_with('[')) {
    const std::size_t close = rest.find(']');
    if (close == std::string_view::npos) return wrong("has a bracket that is not closed");
    settings.host = rest.substr(1, close - 1);
    rest.remove_prefix(close + 1);
    if (!rest.empty() && rest.front() != ':') return wrong("has text after its bracket");
    port = rest;
  } else {
    const std::size_t colon = rest.find(':');
    settings.host = rest.substr(0, colon);
    port = colon == std::string_view::npos ? std::string_view() : rest.substr(colon);
  }
  if (settings.host.empty()) return wrong("names no host");
  if (settings.host.find_first_of(" \t\r\n") != std::string::npos) return wrong("has a space in its host");
  if (!port.empty()) {
    port.remove_prefix(1);
    const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), settings.port);
    if (error != std::errc() || end != port.data() + port.size() || settings.port == 0)
      return wrong("needs a port from 1 to 65535 after the colon");
  }
  if (tls) {
    Expected<std::shared_ptr<protocol::TlsTrust>> trust = protocol::trust_in(ca_file);
    if (!trust) return tl::unexpected<Error>(std::move(trust.error()));
    settings.tls = std::move(*trust);
  }
  return settings;
}

struct HttpCaller::State {
  explicit State(const protocol::ConnectionSettings& settings) : pool(io, settings) {}
  asio::io_context io{1};
  protocol::ConnectionPool pool;
  asio::executor_work_guard<asio::io_context::executor_type> work = asio::make_work_guard(io);
  std::thread thread{[this] { io.run(); }};
};

HttpCaller::HttpCaller(const protocol::ConnectionSettings& settings)
    : state_(std::make_unique<State>(settings)) {}

HttpCaller::~HttpCaller() {
  asio::post(state_->io, [state = state_.get()] {
    state->pool.close_idle();
    state->work.reset();
  });
  state_->thread.join();
}

protocol::Exchange HttpCaller::exchange(const protocol::HttpRequest& request, const std::stop_token& stop) {
  // Shared with the handler that the stop callback posts, which may run after this exchange has ended.
  const auto interruption = std::make_shared<protocol::Interruption>();
  auto result = asio::co_spawn(state_->io, state_->pool.exchange(request, *interruption), asio::use_future);
  const std::stop_callback on_stop(
      stop, [this, interruption] { asio::post(state_->io, [interruption] { interruption->request(); }); });
  return result.get();
}

}  // namespace fracture::bake
