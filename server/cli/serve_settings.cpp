#include "server/cli/serve_settings.hpp"

#include <arpa/inet.h>
#include <unistd.h>

#include <fstream>
#include <functional>
#include <optional>
#include <set>
#include <utility>

#include "common/parameters/parameter_object.hpp"
#include "server/cli/memory_plan.hpp"
#include "server/http/auth.hpp"

namespace fracture::cli {
namespace {

constexpr std::uint64_t kTiB = 1ull << 40;

enum class Reach { kThisMachine, kNetwork };

/// Text that is never printed.
Setting secret(std::string name, std::string type, std::string& target, std::string doc) {
  Setting setting = text(std::move(name), std::move(type), target, std::move(doc));
  setting.secret = true;
  return setting;
}

/// Nothing when it is no numeric address.
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

/// The first line of a file; nothing where it cannot be read or is empty.
std::optional<std::string> first_line(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  if (!std::getline(file, line)) return std::nullopt;
  if (!line.empty() && line.back() == '\r') line.pop_back();
  return line.empty() ? std::nullopt : std::optional(line);
}

/// What is said about Redis and about signatures.
void judge_tiers(const ServeOptions& o, const std::function<void(std::string)>& refuse) {
  const TiersConfig& tiers = o.service.tiers;
  const RedisConfig& redis = tiers.redis;
  const bool password = !redis.password.empty() || !o.redis_password_file.empty();
  if (redis.address.empty() && (password || !redis.user.empty() || redis.tls.on))
    refuse("redis-user, redis-password and redis-tls say how to speak with a Redis: give --redis too");
  if (!redis.user.empty() && !password) refuse("redis-user needs a redis-password or redis-password-file");
  if (!redis.password.empty() && !o.redis_password_file.empty())
    refuse("redis-password and redis-password-file are both given; one of them is enough");
  if (!o.redis_password_file.empty() && !first_line(o.redis_password_file))
    refuse("redis-password-file " + o.redis_password_file + " cannot be read, or its first line is empty");
  if (redis.tls.cert_file.empty() != redis.tls.key_file.empty())
    refuse("redis-cert-file and redis-key-file belong together");
  if (!redis.tls.on && !(redis.tls.ca_file.empty() && redis.tls.cert_file.empty()))
    refuse("redis-ca-file and redis-cert-file are of use with --redis-tls only");
  if (redis.tls.on && redis.address.starts_with('/')) refuse("redis-tls needs a redis at host:port");
  if (redis.tls.on)
    if (const auto tls = RedisTls::load(redis.tls); !tls) refuse("redis-tls: " + tls.error().detail);
  if (!o.farm_key_file.empty())
    if (const auto keys = FarmKeys::load(o.farm_key_file); !keys)
      refuse("farm-key-file " + keys.error().detail);
  if (tiers.sign_disk && o.farm_key_file.empty()) refuse("sign-disk-cache needs a farm-key-file");
}

/// scheme://host[:port], as browsers send it.
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
       number("port", "PORT", o.server.port, 0, kPort, "Port of the public listener, 0: any free one"),
       text("admin-address", "ADDRESS", o.server.admin_address,
            "Numeric address of the admin listener, which asks for no token"),
       number("admin-port", "PORT", o.server.admin_port, 0, kPort,
              "Port of /livez, /readyz and /metrics, 0: any free one"),
       text("token-file", "FILE", o.token_file,
            "Who may ask, and how much: a JSON file of names, or lines 'name token'; read again on SIGHUP"),
       list("trusted-proxy", "CIDR", o.trusted_proxies,
            "Believe proxies of this network in what Forwarded and the PROXY protocol say of their clients"),
       flag("no-page", o.no_page, "Show browsers no page: they get JSON, as programs do"),
       list("page-sample", "FILE", o.page_samples,
            "A mesh that the page offers to everybody who gets it, beside the shapes that it makes"),
       flag("insecure-bind", o.insecure_bind, "Listen beyond this machine without tokens"),
       list("cors-origin", "ORIGIN", o.server.cors_origins,
            "Web pages of this origin may ask (https://example.org), or '*': of any"),
       list("allow-host", "NAME", o.server.allowed_hosts,
            "Where no token is asked for, clients may call this server by this name, or '*': by any; by "
            "address or as localhost they always may")});
  group(
      "Work",
      {number("io-threads", "N", o.server.io_threads, 1, 2, "Threads that read and write"),
       number("threads", "N", o.threads, 0, 1024, "Threads that compute, 0: one for each core"),
       number(
           "memory", "BYTES", o.memory, 0, kTiB,
           "What server and import processes may have resident, 0: the limit of their control group, or the "
           "machine's memory; budgets below that nobody gives are lowered until all fits"),
       number("max-queue", "N", o.max_queue, 0, 1'000'000,
              "Requests of one client that may wait for a computing thread; of all together up to four times "
              "as many"),
       number("import-workers", "N", o.import_workers, 1, 1024,
              "Sandboxed processes that read files, at a time"),
       number("import-memory", "BYTES", o.import_memory, 0, kTiB,
              "Bytes that an import process may take for a file beyond what it begins with, 0: no limit"),
       choice("require-sandbox", o.require_sandbox, {"auto", "yes", "no"},
              "Refuse to start where import processes cannot be sandboxed; auto: beyond this machine"),
       list("enable-format", "FORMAT", o.enabled_formats,
            "Also read this format (blend, fbx and others): their parsers are large and off by default"),
       flag("all-formats", o.all_formats, "Read every format there is")});
  group("Logs",
        {choice("log-level", o.log_level, {"trace", "debug", "info", "warn", "error", "off"},
                "Least important lines that are written"),
         choice("log-format", o.log_format, {"auto", "json", "text"},
                "Form of the lines; auto: text on a terminal, else JSON"),
         text("keep-failures", "FOLDER", o.keep_failures,
              "Keep here what is needed to see an answer again that did not prove itself, or a bug")});
  group("Limits",
        {number("max-body", "BYTES", l.max_body, 1, kTiB, "Bytes of a request body as it is sent"),
         number("max-bodies", "BYTES", l.max_bodies, 1, kTiB,
                "Bytes of all request bodies held at the same time, those of at most 64 KiB not counted"),
         number("max-small-bodies", "BYTES", l.max_small_bodies, 1, kTiB,
                "Bytes of all request bodies of at most 64 KiB held at the same time"),
         number("max-bodies-per-address", "BYTES", l.max_bodies_per_address, 0, kTiB,
                "Share of them for one client address, 0: a quarter; a single body may exceed it"),
         number("max-answers", "BYTES", l.max_answers, 1, kTiB,
                "Bytes of all answers that are being written at the same time"),
         number("max-answers-per-address", "BYTES", l.max_answers_per_address, 0, kTiB,
                "Share of them for one client address, 0: a quarter; a single answer may exceed it"),
         number("answer-ledger", "BYTES", l.answer_ledger, 0, kTiB,
                "Bytes of the ledger of which name of the token file may see which answer, 512 for each"),
         number("max-header", "BYTES", l.max_header, 256, http::kReadBuffer / 2, "Bytes of a request header"),
         number("max-uri", "BYTES", l.max_uri, 64, http::kReadBuffer / 2, "Bytes of a request target"),
         number("max-sites", "N", s.max_sites, 1, kMostSitesAnywhere, "Sites of one request"),
         number("max-triangles", "N", s.import_limits.max_triangles, 1, UINT32_MAX, "Triangles of one mesh"),
         number("max-decoded", "BYTES", s.import_limits.max_decoded_bytes, 1, kTiB,
                "Bytes of a body or a mesh after decompression"),
         number("max-connections", "N", l.max_connections, 1, 1'000'000, "Open connections"),
         number("max-connections-per-address", "N", l.max_connections_per_address, 1, 1'000'000,
                "Open connections of one client address"),
         seconds("deadline", l.deadline, "Longest computation, with its time in the queue"),
         seconds("realtime-deadline", l.realtime_deadline, "The same for realtime work"),
         number("max-working", "BYTES", o.dispatcher.max_working_bytes, 1, kTiB,
                "Bytes that computations may work in at the same time, by estimate"),
         seconds("header-timeout", l.header_timeout, "Time for a whole header"),
         seconds("body-grace", l.body_grace, "Time before a body must keep up its rate"),
         number("body-rate", "BYTES/S", l.body_rate, 1, kTiB, "Bytes a second that a body must keep up"),
         seconds("body-timeout", l.body_timeout, "Time for a whole body, however fast it is"),
         number("answer-rate", "BYTES/S", l.answer_rate, 1, kTiB,
                "Bytes a second at which a client must take its answer, after write-stall"),
         seconds("write-stall", l.write_stall, "Longest time without the client taking a byte"),
         seconds("idle", l.idle, "Longest time between requests of a connection")});
  group(
      "Caches",
      {number("mesh-cache", "BYTES", s.mesh_cache_bytes, 0, kTiB, "Bytes of prepared meshes"),
       number("diagram-cache", "BYTES", s.diagram_cache_bytes, 0, kTiB,
              "Bytes of tetrahedralizations, and of answers kept for hits on them"),
       number("result-cache", "BYTES", s.result_cache_bytes, 0, kTiB, "Bytes of finished answers"),
       text("cache-dir", "FOLDER", s.tiers.folder, "Keep finished answers in this folder too"),
       number("disk-cache", "BYTES", s.tiers.disk_bytes, 0, kTiB, "Bytes of that folder"),
       text("redis", "HOST:PORT", s.tiers.redis.address,
            "Share finished answers through this Redis; or the path of its socket"),
       text("redis-user", "NAME", s.tiers.redis.user,
            "Its user (Redis 6 ACL); without one: the default user"),
       secret("redis-password", "TEXT", s.tiers.redis.password,
              "Its password, better given in the environment or a file than as a flag, which others can see"),
       text("redis-password-file", "FILE", o.redis_password_file,
            "Its password: the first line of this file"),
       flag("redis-tls", s.tiers.redis.tls.on, "Speak TLS with it, and check its certificate"),
       text("redis-ca-file", "FILE", s.tiers.redis.tls.ca_file,
            "Who may have signed that certificate (PEM); without it: whom this machine trusts"),
       text("redis-cert-file", "FILE", s.tiers.redis.tls.cert_file,
            "Our own certificate, where it asks for one"),
       text("redis-key-file", "FILE", s.tiers.redis.tls.key_file, "The key of our own certificate"),
       text("farm-key-file", "FILE", o.farm_key_file,
            "Sign what goes to Redis and believe only what is signed: a key a line, the first signs, the "
            "second is still taken"),
       flag("sign-disk-cache", s.tiers.sign_disk, "The same for the folder of --cache-dir")});
  group("Stores",
        {number("mesh-store", "BYTES", o.store.quota_bytes, 0, kTiB, "Bytes of all stored meshes"),
         seconds("mesh-ttl", o.store.ttl, "A stored mesh is forgotten when nobody used it for so long"),
         number("max-jobs", "N", o.jobs.max_jobs, 0, 1'000'000, "Jobs known at the same time"),
         number("job-results", "BYTES", o.jobs.max_result_bytes, 0, kTiB, "Bytes of results kept for jobs"),
         seconds("job-ttl", o.jobs.ttl, "A finished job is forgotten after this"),
         seconds("job-deadline", o.jobs.deadline,
                 "Longest time of a job, from when it is asked for, or goes on after a restart, to its end"),
         number("job-store", "BYTES", o.jobs.max_disk_bytes, 0, kTiB,
                "Bytes of meshes and requests of jobs in the folder of --cache-dir, where they survive a "
                "restart, 0: they do not")});
  group(
      "Stopping",
      {seconds("drain-delay", o.drain_delay,
               "After SIGTERM, keep accepting for this long with /readyz at 503; 0 by default on a terminal"),
       seconds("grace", o.grace, "Then finish what is in progress for at most this long")});
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
        " can be reached from other machines, and anybody there could use this server: give a --token-file, "
        "or --insecure-bind if something in front of it (a proxy, a firewall) decides who may");

  const http::HttpLimits& l = o.limits;
  const auto at_most = [&](const char* small, std::uint64_t a, const char* large, std::uint64_t b) {
    if (a > b)
      refuse(std::string(small) + " (" + std::to_string(a) + ") is over " + large + " (" + std::to_string(b) +
             "): the first could never be reached");
  };
  at_most("max-uri", l.max_uri, "max-header", l.max_header);
  at_most("max-body", l.max_body, "max-bodies", l.max_bodies);
  at_most("max-connections-per-address", l.max_connections_per_address, "max-connections", l.max_connections);
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
    if (!format_from_extension(name)) refuse("enable-format: there is no format '" + name + "'");
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
      refuse("token-file " + tokens.error().detail);
  return errors;
}

void read_settings(ServeOptions& options, const std::vector<Setting>& settings, const GivenSettings& flags,
                   const std::string& config_file, std::vector<std::string>& errors, GivenSettings* given) {
  std::vector<std::string> unknown;
  std::vector<GivenSettings> sources = {flags, from_environment(environ, settings, unknown)};
  for (const std::string& name : unknown)
    options.warnings.push_back("the environment variable " + name + " is no setting of this server");
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
    else  // it has changed since it was judged
      errors.push_back("farm-key-file " + keys.error().detail);
  }
  if (!tiers.folder.empty() && options.jobs.max_disk_bytes > 0) options.jobs.folder = tiers.folder + "/jobs";
  if (tiers.sign_disk) options.jobs.keys = tiers.keys;
  if (!tiers.redis.address.empty() && tiers.keys.empty())
    options.warnings.push_back(
        "Redis without --farm-key-file: who can write to it can put false answers in, which all servers "
        "believe");
  if (!options.token_file.empty()) {
    auto tokens = tenants::TokenFile::load(options.token_file);
    if (tokens)
      options.server.tokens = std::move(*tokens);
    else  // it has changed since it was judged
      errors.push_back("token-file " + tokens.error().detail);
  }
  return errors;
}

}  // namespace fracture::cli
