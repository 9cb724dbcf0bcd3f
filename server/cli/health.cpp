// fracture-server health: for a container's HEALTHCHECK and for scripts on machines without curl.
#include <algorithm>
#include <boost/asio/connect.hpp>
#include <charconv>
#include <cstdio>
#include <optional>
#include <system_error>

#include "common/exchange/exchange.hpp"
#include "server/cli/options.hpp"
#include "server/cli/serve_settings.hpp"
#include "server/http/asio.hpp"

namespace fracture::cli {
namespace {

using http::asio::use_awaitable;

struct Probe {
  std::string host, port, path;
};

/// http://host[:port][/path], the port 80 and the path as given when the URL has none.
std::optional<Probe> probe_of_url(const std::string& url, const std::string& path) {
  constexpr std::string_view kScheme = "http://";
  if (!url.starts_with(kScheme)) return std::nullopt;
  const std::size_t slash = std::min(url.find('/', kScheme.size()), url.size());
  const std::string authority = url.substr(kScheme.size(), slash - kScheme.size());
  const bool bracketed = authority.starts_with('[');
  const std::size_t close = bracketed ? authority.find(']') : 0;
  if (close == std::string::npos) return std::nullopt;
  const std::size_t colon = std::min(authority.find(':', close), authority.size());
  if (bracketed && colon != close + 1) return std::nullopt;
  Probe probe{bracketed ? authority.substr(1, close - 1) : authority.substr(0, colon),
              colon < authority.size() ? authority.substr(colon + 1) : "80",
              slash + 1 < url.size() ? url.substr(slash) : path};
  std::uint16_t port = 0;
  const char* const end = probe.port.data() + probe.port.size();
  if (const auto [at, error] = std::from_chars(probe.port.data(), end, port);
      at != end || error != std::errc() || port == 0)
    return std::nullopt;
  const auto printable = [](const std::string& s) {
    return !s.empty() && std::all_of(s.begin(), s.end(), [](char c) { return c > ' ' && c < 127; });
  };
  if (!printable(probe.host) || !printable(probe.path)) return std::nullopt;
  return probe;
}

/// The admin listener of a server that is started here with the same environment and the same file.
std::optional<Probe> probe_of_settings(const std::string& config_file, const std::string& path,
                                       std::vector<std::string>& errors) {
  ServeOptions serve;
  const std::vector<Setting> settings = serve_settings(serve);
  read_settings(serve, settings, {}, config_file, errors);
  if (serve.server.admin_port == 0)
    errors.push_back("admin-port is 0, so the port is not known: give the URL");
  if (!errors.empty()) return std::nullopt;
  std::string host = serve.server.admin_address;
  if (host == "0.0.0.0") host = "127.0.0.1";  // every address: this machine's own is one of them
  if (host == "::") host = "::1";
  return Probe{host, std::to_string(serve.server.admin_port), path};
}

/// The status of the answer; throws boost::system::system_error.
http::asio::awaitable<unsigned> ask(const Probe& probe) {
  namespace bhttp = http::beast::http;
  const auto executor = co_await http::asio::this_coro::executor;
  http::tcp::resolver resolver(executor);
  http::tcp::socket socket(executor);
  co_await http::asio::async_connect(
      socket, co_await resolver.async_resolve(probe.host, probe.port, use_awaitable), use_awaitable);
  bhttp::request<bhttp::empty_body> request(bhttp::verb::get, probe.path, 11);
  request.set(bhttp::field::host, protocol::authority_of(probe.host, probe.port));
  request.set(bhttp::field::connection, "close");
  co_await bhttp::async_write(socket, request, use_awaitable);
  http::beast::flat_buffer buffer(64 << 10);
  bhttp::response_parser<bhttp::empty_body> answer;
  co_await bhttp::async_read_header(socket, buffer, answer, use_awaitable);
  co_return answer.get().result_int();
}

int say(const std::string& reason, int code) {
  std::fprintf(stderr, "fracture-server health: %s\n", reason.c_str());
  return code;
}
int unhealthy(const std::string& reason) { return say(reason, kExitSystem); }

}  // namespace

int health(const HealthOptions& o) {
  const std::string path = o.ready ? "/readyz" : "/livez";
  std::vector<std::string> errors;
  const std::optional<Probe> probe =
      o.url.empty() ? probe_of_settings(o.config_file, path, errors) : probe_of_url(o.url, path);
  if (!o.url.empty() && !probe)
    errors.push_back("the URL must be http://host[:port][/path]; it was '" + o.url + "'");
  if (!errors.empty()) {
    std::string all;
    for (const std::string& error : errors) all += (all.empty() ? "" : "; ") + error;
    return say(all, kExitUsage);
  }
  const std::string where = probe->host + " port " + probe->port + probe->path + ": ";
  std::optional<unsigned> status;
  std::string failure = "no answer within " + std::to_string(o.timeout) + " s";
  http::asio::io_context io(1);
  http::asio::co_spawn(io, ask(*probe), [&](std::exception_ptr error, unsigned answered) {
    try {
      if (error) std::rethrow_exception(error);
      status = answered;
    } catch (const boost::system::system_error& e) {
      failure = e.code().message();  // what() also names a line of Boost
    }
  });
  io.run_for(std::chrono::seconds(o.timeout));
  if (!status) return unhealthy(where + failure);
  if (*status != 200) return unhealthy(where + "status " + std::to_string(*status));
  std::puts("healthy");
  return kExitDone;
}

}  // namespace fracture::cli
