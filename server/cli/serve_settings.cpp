#include "server/cli/serve_settings.hpp"

#include <arpa/inet.h>
#include <unistd.h>

#include <fstream>
#include <functional>
#include <optional>
#include <set>
#include <utility>

#include "common/base/nearest_name.hpp"
#include "common/base/words.hpp"
#include "common/parameters/parameter_object.hpp"
#include "server/cli/memory_plan.hpp"
#include "server/http/auth.hpp"

namespace fracture::cli {
namespace {

constexpr std::uint64_t kTiB = 1ull << 40;

enum class Reach { kThisMachine, kNetwork };

/// Text setting whose value is never printed.
Setting secret(std::string name, std::string type, std::string& target, std::string doc) {
  Setting setting = text(std::move(name), std::move(type), target, std::move(doc));
  setting.secret = true;
  return setting;
}

/// Returns nothing if `address` is not a numeric address.
std::optional<Reach> reach_of(const std::string& address) {
  in_addr v4{};
  if (::inet_pton(AF_INET, address.c_str(), &v4) == 1)
    return (ntohl(v4.s_addr) >> 24) == 127 ? Reach::kThisMachine : Reach::kNetwork;
  in6_addr v6{};
  if (::inet_pton(AF_INET6, address.c_str(), &v6) == 1)
    return IN6_IS_ADDR_LOOPBACK(&v6) ? Reach::kThisMachine : Reach::kNetwork;
  return std::nullopt;
}

bool sandbox_required(const ServeOptions& o) {
  return o.require_sandbox == "yes" ||
         (o.require_sandbox == "auto" && reach_of(o.server.address) == Reach::kNetwork);
}

/// Returns the first line of a file, or nothing if it is empty or the file cannot be read.
std::optional<std::string> first_line(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  if (!std::getline(file, line)) return std::nullopt;
  if (!line.empty() && line.back() == '\r') line.pop_back();
  return line.empty() ? std::nullopt : std::optional(line);
}

/// Returns the format that is most similar to a wrong name: "; did you mean blend?".
std::string nearest_format(const std::string& name) {
  const std::optional<std::string> nearest = nearest_name(name, FormatSet::all().names());
  return nearest ? "; did you mean " + *nearest + "?" : ", such as blend or fbx";
}

/// Refuses inconsistent settings for Redis and signatures.
void judge_tiers(const ServeOptions& o, const std::function<void(std::string)>& refuse) {
  const TiersConfig& tiers = o.service.tiers;
  const RedisConfig& redis = tiers.redis;
  const bool password = !redis.password.empty() || !o.redis_password_file.empty();
  if (redis.address.empty() && (password || !redis.user.empty() || redis.tls.on))
    refuse("redis-user, redis-password and redis-tls need a Redis: give its address with --redis");
  if (!redis.user.empty() && !password) refuse("redis-user needs a redis-password or redis-password-file");
  if (!redis.password.empty() && !o.redis_password_file.empty())
    refuse("redis-password and redis-password-file are both given: give one of them");
  if (!o.redis_password_file.empty() && !first_line(o.redis_password_file))
    refuse("redis-password-file " + o.redis_password_file + " cannot be read, or its first line is empty");
  if (redis.tls.cert_file.empty() != redis.tls.key_file.empty())
    refuse("redis-cert-file and redis-key-file must be given together");
  if (!redis.tls.on && !(redis.tls.ca_file.empty() && redis.tls.cert_file.empty()))
    refuse("redis-ca-file and redis-cert-file need --redis-tls");
  if (redis.tls.on && redis.address.starts_with('/'))
    refuse("redis-tls needs a redis address host:port, not a socket path");
  if (redis.tls.on)
    if (const auto tls = RedisTls::load(redis.tls); !tls) refuse("redis-tls: " + tls.error().detail);
  if (!o.farm_key_file.empty())
    if (const auto keys = FarmKeys::load(o.farm_key_file); !keys)
      refuse("--farm-key-file " + keys.error().detail);
  if (tiers.sign_disk && o.farm_key_file.empty()) refuse("sign-disk-cache needs a farm-key-file");
}

/// Returns whether the text is scheme://host[:port], as browsers send it.
bool is_origin(const std::string& origin) {
  const std::size_t scheme = origin.find("://");
  return scheme != std::string::npos && scheme > 0 && origin.size() > scheme + 3 &&
         origin.find_first_of("/ \t,?#@*", scheme + 3) == std::string::npos;
}

}  // namespace

std::vector<Setting> serve_settings(ServeOptions& o) {
  std::vector<Setting> settings;
  const auto group = [&settings](const char* name, std::vector<Setting> members) {
    for (Setting& member : members) {
      member.group = name;
      settings.push_back(std::move(member));
    }
  };
  http::HttpLimits& l = o.limits;
  ServiceConfig& s = o.service;
  constexpr std::uint64_t kPort = 65535;

  group(
      "Listening",
      {text("address", "ADDRESS", o.server.address, "Numeric address of the public listener"),
       number("port", "PORT", o.server.port, 0, kPort, "Port of the public listener; 0: any free port"),
       text("admin-address", "ADDRESS", o.server.admin_address,
            "Numeric address of the admin listener, which needs no token"),
       number("admin-port", "PORT", o.server.admin_port, 0, kPort,
              "Port of /livez, /readyz and /metrics; 0: any free port"),
       text("token-file", "FILE", o.token_file,
            "Names, tokens and shares of the clients that may use this server: a JSON file, or a file "
            "with lines 'name token'; reloaded on SIGHUP"),
       list("trusted-proxy", "CIDR", o.trusted_proxies,
            "Trust proxies in this network to identify their clients with Forwarded or the PROXY protocol"),
       flag("no-page", o.no_page, "Send no page to browsers; they get JSON, as other programs do"),
       list("page-sample", "FILE", o.page_samples,
            "A mesh that the page offers to every visitor, in addition to its own shapes"),
       flag("insecure-bind", o.insecure_bind, "Accept clients on other machines even if they have no token"),
       list(
           "cors-origin", "ORIGIN", o.server.cors_origins,
           "Accept requests from web pages of this origin, such as https://example.org ('*': of any origin)"),
       list(
           "allow-host", "NAME", o.server.allowed_hosts,
           "Without tokens: accept requests to this host name ('*': to any name). Requests to an address or to localhost are "
           "always accepted")});
  group(
      "Work",
      {number("io-threads", "N", o.server.io_threads, 1, 2, "Threads that read requests and write answers"),
       number("threads", "N", o.threads, 0, 1024, "Computing threads; 0: one per core"),
       number(
           "memory", "BYTES", o.memory, 0, kTiB,
           "Limit on the resident memory of the server and its import processes; 0: the limit of their control group, or the "
           "machine's memory. Memory budgets that you do not set are lowered until all of them fit"),
       number("max-queue", "N", o.max_queue, 0, 1'000'000,
              "Maximum number of requests per client that wait for a computing thread; all clients together "
              "may have up to four times as many"),
       number("import-workers", "N", o.import_workers, 1, 1024,
              "Sandboxed processes that read files at the same time"),
       number(
           "import-memory", "BYTES", o.import_memory, 0, kTiB,
           "Memory by which an import process may grow while it reads a file; 0: no limit. If not given, at most half of "
           "--max-working"),
       choice(
           "require-sandbox", o.require_sandbox, {"auto", "yes", "no"},
           "Refuse to start if import processes cannot be sandboxed; auto: only if other machines can reach "
           "this server"),
       list("enable-format", "FORMAT", o.enabled_formats,
            "Also read this format (such as blend or fbx); the parsers of such formats are large and off "
            "by default"),
       flag("all-formats", o.all_formats, "Read all formats")});
  group(
      "Logs",
      {choice("log-level", o.log_level, {"trace", "debug", "info", "warn", "error", "off"},
              "Lowest level that is logged"),
       choice("log-format", o.log_format, {"auto", "json", "text"},
              "Format of log lines; auto: text on a terminal, otherwise JSON"),
       text(
           "keep-failures", "FOLDER", o.keep_failures,
           "Save to this folder the data needed to reproduce each bug and each answer that failed its check")});
  group(
      "Limits",
      {number("max-body", "BYTES", l.max_body, 1, kTiB,
              "Maximum size of a request body, before decompression"),
       number("max-bodies", "BYTES", l.max_bodies, 1, kTiB,
              "Maximum total size of the request bodies over 64 KiB that are held at the same time"),
       number("max-small-bodies", "BYTES", l.max_small_bodies, 1, kTiB,
              "Maximum total size of the request bodies up to 64 KiB that are held at the same time"),
       number(
           "max-bodies-per-address", "BYTES", l.max_bodies_per_address, 0, kTiB,
           "Maximum total size of the bodies from one client address; 0: a quarter of the limit for all clients. A single "
           "body may exceed it"),
       number("max-answers", "BYTES", l.max_answers, 1, kTiB,
              "Maximum total size of the answers that are being sent at the same time"),
       number(
           "max-answers-per-address", "BYTES", l.max_answers_per_address, 0, kTiB,
           "Maximum total size of the answers to one client address; 0: a quarter of --max-answers. A single answer may "
           "exceed it"),
       number(
           "answer-ledger", "BYTES", l.answer_ledger, 0, kTiB,
           "Maximum size of the list that records which answers each name in the token file may see (512 bytes per entry)"),
       number("max-header", "BYTES", l.max_header, 256, http::kReadBuffer / 2,
              "Maximum size of a request header"),
       number("max-uri", "BYTES", l.max_uri, 64, http::kReadBuffer / 2, "Maximum size of a request target"),
       number("max-sites", "N", s.max_sites, 1, kMostSitesAnywhere, "Maximum number of sites in a request"),
       number("max-triangles", "N", s.import_limits.max_triangles, 1, UINT32_MAX,
              "Maximum number of triangles in a mesh"),
       number("max-decoded", "BYTES", s.import_limits.max_decoded_bytes, 1, kTiB,
              "Maximum size of a body or a mesh after decompression"),
       number("max-connections", "N", l.max_connections, 1, 1'000'000, "Maximum number of open connections"),
       number("max-connections-per-address", "N", l.max_connections_per_address, 1, 1'000'000,
              "Maximum number of open connections from one client address"),
       seconds("deadline", l.deadline, "Time limit of a computation, including its time in the queue"),
       seconds("realtime-deadline", l.realtime_deadline,
               "Time limit of a realtime computation, including its time in the queue"),
       number("max-working", "BYTES", o.dispatcher.max_working_bytes, 1, kTiB,
              "Maximum working memory of all computations together, as estimated by the server"),
       seconds("header-timeout", l.header_timeout,
               "Time limit for receiving a whole header, and for waiting for an I/O thread"),
       seconds("body-grace", l.body_grace, "Time before --body-rate applies to a body"),
       number("body-rate", "BYTES/S", l.body_rate, 1, kTiB, "Minimum speed of a request body"),
       seconds("body-timeout", l.body_timeout, "Time limit for receiving a whole body"),
       number("answer-rate", "BYTES/S", l.answer_rate, 1, kTiB,
              "Minimum speed at which a client must read its answer, after --write-stall"),
       seconds("write-stall", l.write_stall,
               "Longest time that a client may go without reading any of its answer"),
       seconds("idle", l.idle, "Longest time between requests on a connection")});
  group(
      "Caches",
      {number("mesh-cache", "BYTES", s.mesh_cache_bytes, 0, kTiB,
              "Maximum size of the cache of prepared meshes"),
       number("diagram-cache", "BYTES", s.diagram_cache_bytes, 0, kTiB,
              "Maximum size of the cache for tetrahedralizations and for answers kept for later hits"),
       number("result-cache", "BYTES", s.result_cache_bytes, 0, kTiB,
              "Maximum size of the cache of finished answers in memory"),
       text("cache-dir", "FOLDER", s.tiers.folder, "Also keep finished answers in this folder"),
       number("disk-cache", "BYTES", s.tiers.disk_bytes, 0, kTiB,
              "Maximum total size of the answers in the --cache-dir folder"),
       text("redis", "HOST:PORT", s.tiers.redis.address,
            "Share finished answers through the Redis server at this address or socket path"),
       text("redis-user", "NAME", s.tiers.redis.user, "Redis user (Redis 6 ACL); default: the default user"),
       secret("redis-password", "TEXT", s.tiers.redis.password,
              "Redis password; prefer the environment or a file, because other users can see flags"),
       text("redis-password-file", "FILE", o.redis_password_file,
            "File whose first line is the Redis password"),
       flag("redis-tls", s.tiers.redis.tls.on, "Connect to Redis over TLS and check its certificate"),
       text("redis-ca-file", "FILE", s.tiers.redis.tls.ca_file,
            "Certificate authorities to trust for Redis (PEM); default: those that this machine trusts"),
       text("redis-cert-file", "FILE", s.tiers.redis.tls.cert_file,
            "Client certificate of this server, if Redis asks for one"),
       text("redis-key-file", "FILE", s.tiers.redis.tls.key_file, "Key of the client certificate"),
       text(
           "farm-key-file", "FILE", o.farm_key_file,
           "Sign answers in Redis and accept only signed ones. The file has one or two keys, one per line: the "
           "first signs, and both are accepted"),
       flag("sign-disk-cache", s.tiers.sign_disk,
            "Also sign the answers and jobs in the --cache-dir folder")});
  group(
      "Stores",
      {number("mesh-store", "BYTES", o.store.quota_bytes, 0, kTiB, "Maximum total size of the stored meshes"),
       seconds("mesh-ttl", o.store.ttl, "Time after which an unused stored mesh is deleted"),
       number("max-jobs", "N", o.jobs.max_jobs, 0, 1'000'000,
              "Maximum number of known jobs, including finished ones"),
       number("job-results", "BYTES", o.jobs.max_result_bytes, 0, kTiB,
              "Maximum total size of the job results"),
       seconds("job-ttl", o.jobs.ttl, "Time after which a finished job is deleted"),
       seconds("job-deadline", o.jobs.deadline,
               "Time limit of a job, from its request (or a restart of the server) to its end"),
       number("job-store", "BYTES", o.jobs.max_disk_bytes, 0, kTiB,
              "Maximum total size of the jobs in the --cache-dir folder (their meshes and requests), which "
              "survive a restart; 0: jobs do not survive a restart")});
  group(
      "Stopping",
      {seconds("drain-delay", o.drain_delay,
               "Time after SIGTERM during which the server still accepts requests, with /readyz at 503; 0 by "
               "default on a terminal"),
       seconds("grace", o.grace, "Time limit, after --drain-delay, for finishing requests in progress")});
  return settings;
}

std::vector<std::string> inconsistencies(const ServeOptions& o) {
  std::vector<std::string> errors;
  const auto refuse = [&errors](std::string error) { errors.push_back(std::move(error)); };
  const auto reach = reach_of(o.server.address), admin_reach = reach_of(o.server.admin_address);
  if (!reach) refuse("address must be a numeric IPv4 or IPv6 address; it was '" + o.server.address + "'");
  if (!admin_reach)
    refuse("admin-address must be a numeric IPv4 or IPv6 address; it was '" + o.server.admin_address + "'");
  if (o.server.port != 0 && o.server.port == o.server.admin_port &&
      o.server.address == o.server.admin_address)
    refuse("port and admin-port are both " + std::to_string(o.server.port) + "; they must differ");
  if (reach == Reach::kNetwork && o.token_file.empty() && !o.insecure_bind)
    refuse(
        "address " + o.server.address +
        " can be reached from other machines, so anybody there could use this server: give --token-file, or "
        "--insecure-bind if a proxy or a firewall in front of the server controls access");

  const http::HttpLimits& l = o.limits;
  const auto at_most = [&](const char* small, std::uint64_t a, const char* large, std::uint64_t b,
                           const std::function<std::string(std::uint64_t)>& in_words) {
    if (a > b)
      refuse(std::string(small) + " (" + in_words(a) + ") is over " + large + " (" + in_words(b) +
             "), so the first limit could never be reached: lower the first or raise the second");
  };
  at_most("max-uri", l.max_uri, "max-header", l.max_header, detail::size_with_unit);
  at_most("max-body", l.max_body, "max-bodies", l.max_bodies, detail::size_with_unit);
  at_most("max-connections-per-address", l.max_connections_per_address, "max-connections", l.max_connections,
          grouped);
  const std::pair<const char*, std::chrono::milliseconds> positive[] = {
      {"deadline", l.deadline},
      {"realtime-deadline", l.realtime_deadline},
      {"job-deadline", o.jobs.deadline},
      {"header-timeout", l.header_timeout},
      {"body-timeout", l.body_timeout},
      {"write-stall", l.write_stall},
      {"idle", l.idle}};
  for (const auto& [name, value] : positive)
    if (value.count() <= 0) refuse(std::string(name) + " must be more than 0 seconds");

  const std::string& redis = o.service.tiers.redis.address;
  if (!redis.empty() && redis.front() != '/') {
    const std::size_t colon = redis.rfind(':');
    if (colon == 0 || colon == std::string::npos || colon + 1 == redis.size() ||
        redis.find_first_not_of("0123456789", colon + 1) != std::string::npos)
      refuse("redis must be host:port or the path of a socket; it was '" + redis + "'");
  }
  judge_tiers(o, refuse);
  for (const std::string& name : o.enabled_formats)
    if (!format_from_extension(name))
      refuse("enable-format: '" + name + "' is not a known format" + nearest_format(name));
  for (const std::string& origin : o.server.cors_origins)
    if (origin != "*" && !is_origin(origin))
      refuse("cors-origin must be '*' or scheme://host[:port] without a path; it was '" + origin + "'");
  for (const std::string& cidr : o.trusted_proxies)
    if (!http::TrustedProxies().add(cidr))
      refuse("trusted-proxy must be a network such as 192.0.2.0/24 or 2001:db8::/32; it was '" + cidr + "'");
  for (const std::string& name : o.server.allowed_hosts)
    if (name.empty() || (name != "*" && name.find_first_of(":/ \t,*@") != std::string::npos))
      refuse("allow-host must be '*' or a name without port; it was '" + name + "'");
  if (!o.token_file.empty())
    if (const auto tokens = tenants::TokenFile::load(o.token_file); !tokens)
      refuse("--token-file " + tokens.error().detail);
  return errors;
}

void read_settings(ServeOptions& options, const std::vector<Setting>& settings, const GivenSettings& flags,
                   const std::string& config_file, std::vector<std::string>& errors, GivenSettings* given) {
  std::vector<std::string> unknown;
  std::vector<GivenSettings> sources = {flags, from_environment(environ, settings, unknown)};
  for (const std::string& name : unknown)
    options.warnings.push_back(
        "the environment variable " + name +
        " is not a setting of this server and is ignored (--print-config lists the settings)");
  if (!config_file.empty()) sources.push_back(from_file(config_file, settings, errors));
  apply(settings, sources, errors);
  if (!given) return;
  for (const GivenSettings& source : sources) given->insert(source.begin(), source.end());
}

std::vector<std::string> configure(ServeOptions& options, const std::vector<Setting>& settings,
                                   const GivenSettings& flags, const std::string& config_file,
                                   GivenSettings* given) {
  std::vector<std::string> errors;
  GivenSettings all;
  read_settings(options, settings, flags, config_file, errors, &all);
  std::set<std::string> names;
  for (const auto& [name, value] : all) names.insert(name);
  if (given) *given = std::move(all);
  for (std::string& error : inconsistencies(options)) errors.push_back(std::move(error));
  if (!errors.empty()) return errors;
  errors = plan_memory(options, names, options.memory > 0 ? options.memory : available_memory());
  if (!errors.empty()) return errors;

  options.sandbox_required = sandbox_required(options);
  if (options.all_formats) options.service.formats = FormatSet::all();
  for (const std::string& name : options.enabled_formats)
    options.service.formats.enable(*format_from_extension(name));
  for (const std::string& cidr : options.trusted_proxies) options.server.proxies.add(cidr);
  options.limits.max_decoded_body = options.service.import_limits.max_decoded_bytes;
  TiersConfig& tiers = options.service.tiers;
  if (!options.redis_password_file.empty())
    tiers.redis.password = first_line(options.redis_password_file).value_or("");
  if (!options.farm_key_file.empty()) {
    if (auto keys = FarmKeys::load(options.farm_key_file))
      tiers.keys = std::move(*keys);
    else  // the file has changed since it was checked
      errors.push_back("--farm-key-file " + keys.error().detail);
  }
  if (!tiers.folder.empty() && options.jobs.max_disk_bytes > 0) options.jobs.folder = tiers.folder + "/jobs";
  if (tiers.sign_disk) options.jobs.keys = tiers.keys;
  if (!tiers.redis.address.empty() && tiers.keys.empty())
    options.warnings.push_back(
        "Redis is used without --farm-key-file: anybody who can write to this Redis can insert false answers, "
        "which all servers would send. Give a --farm-key-file");
  if (!options.token_file.empty()) {
    auto tokens = tenants::TokenFile::load(options.token_file);
    if (tokens)
      options.server.tokens = std::move(*tokens);
    else  // the file has changed since it was checked
      errors.push_back("token-file " + tokens.error().detail);
  }
  return errors;
}

}  // namespace fracture::cli
