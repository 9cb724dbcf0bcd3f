// fracture-server health: for a container's HEALTHCHECK, and for scripts on machines without curl.
#include <algorithm>
#include <charconv>
#include <cstdio>
#include <optional>
#include <system_error>

#include "common/exchange/exchange.hpp"
#include "server/bake/http_caller.hpp"
#include "server/cli/options.hpp"
#include "server/cli/serve_settings.hpp"

namespace fracture::cli {
namespace {

struct Probe {
  std::string host;
  std::uint16_t port;
  std::string path;
};

/// Parses http://host[:port][/path]. Without a port, 80 is used; without a path, `path`.
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
  Probe probe{bracketed ? authority.substr(1, close - 1) : authority.substr(0, colon), 80,
              slash + 1 < url.size() ? url.substr(slash) : path};
  if (colon < authority.size()) {
    const char* const end = authority.data() + authority.size();
    const auto [at, error] = std::from_chars(authority.data() + colon + 1, end, probe.port);
    if (at != end || error != std::errc() || probe.port == 0) return std::nullopt;
  }
  const auto printable = [](const std::string& s) {
    return !s.empty() && std::all_of(s.begin(), s.end(), [](char c) { return c > ' ' && c < 127; });
  };
  if (!printable(probe.host) || !printable(probe.path)) return std::nullopt;
  return probe;
}

/// Returns the admin listener that a server started with this environment and config file would have.
std::optional<Probe> probe_of_settings(const std::string& config_file, const std::string& path,
                                       std::vector<std::string>& errors) {
  ServeOptions serve;
  const std::vector<Setting> settings = serve_settings(serve);
  read_settings(serve, settings, {}, config_file, errors);
  if (serve.server.admin_port == 0)
    errors.push_back("admin-port is 0, so the port is not known: give the URL");
  if (!errors.empty()) return std::nullopt;
  std::string host = serve.server.admin_address;
  if (host == "0.0.0.0") host = "127.0.0.1";  // a wildcard address includes the loopback address
  if (host == "::") host = "::1";
  return Probe{host, serve.server.admin_port, path};
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
  const protocol::Milliseconds longest = std::chrono::seconds(o.timeout);
  protocol::ConnectionSettings settings;
  settings.host = probe->host;
  settings.port = probe->port;
  settings.connect_timeout = settings.answer_timeout = longest;
  settings.max_answer_bytes = 1 << 20;
  bake::HttpCaller caller(settings);
  protocol::HttpRequest request;
  request.target = probe->path;
  const protocol::Exchange answer = caller.exchange(request, {});
  const std::string authority = protocol::authority_of(probe->host, std::to_string(probe->port));
  const std::string where = "http://" + authority + probe->path;
  const bool of_admin = probe->path == "/livez" || probe->path == "/readyz";
  if (answer.outcome == protocol::Exchange::Outcome::kTimedOut)
    return unhealthy(where + ": no answer within " + std::to_string(o.timeout) +
                     " s. The server is overloaded or stuck. To wait longer, use --timeout.");
  if (answer.outcome != protocol::Exchange::Outcome::kAnswered)
    return unhealthy(
        (answer.detail.starts_with(authority) ? "" : where + ": ") + answer.detail +
        (of_admin ? " Is the server running, and is this its admin port?" : " Is the server running?"));
  if (answer.status == 404 && of_admin)
    return unhealthy(where + " answered 404, so this is not an admin listener. Use the --admin-port (" +
                     std::to_string(ServeOptions().server.admin_port) + " by default).");
  if (answer.status == 503 && probe->path == "/readyz")
    return unhealthy(where + " answered 503: the server is not accepting requests at the moment.");
  if (answer.status != 200)
    return unhealthy(where + " answered " + std::to_string(answer.status) + ", not 200.");
  std::puts("healthy");
  return kExitDone;
}

}  // namespace fracture::cli
