// The command line: four commands, each with its own settings. What they exit with: exit_codes.hpp.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "server/bake/plan.hpp"
#include "server/cli/exit_codes.hpp"
#include "server/http/limits.hpp"
#include "server/http/server.hpp"
#include "server/jobs/jobs.hpp"
#include "server/service/dispatcher.hpp"
#include "server/service/mesh_store.hpp"
#include "server/service/service.hpp"
#include "server/service/worker_pool.hpp"

namespace fracture::cli {

struct ServeOptions {
  http::ServerConfig server;
  http::HttpLimits limits;
  ServiceConfig service;
  DispatcherConfig dispatcher;
  std::string keep_failures;  ///< folder; empty: none are kept
  StoreConfig store;
  JobsConfig jobs;
  std::uint64_t memory =
      0;            ///< resident bytes of server and import workers; 0: what there is (memory_plan.hpp)
  int threads = 0;  ///< of the worker pool; 0: as many as there are cores
  std::size_t max_queue = 256;
  int import_workers = available_cores();
  std::uint64_t import_memory = 2ull << 30;  ///< bytes that an import worker may take for a file; 0: no limit
  std::string require_sandbox = "auto";      ///< auto, yes, no
  bool sandbox_required = false;             ///< what that comes to
  std::chrono::milliseconds drain_delay{0}, grace{30'000};
  std::string log_level = "info";
  std::string log_format = "auto";
  std::vector<std::string> enabled_formats;  ///< added to service.formats
  bool all_formats = false;
  std::string redis_password_file;           ///< its first line; empty: service.tiers.redis.password as it is
  std::string farm_key_file;                 ///< empty: what lies in shared tiers is not signed
  std::string token_file;                    ///< empty: no authentication
  std::vector<std::string> trusted_proxies;  ///< networks
  bool no_page = false;                      ///< browsers get JSON, as programs do
  std::vector<std::string> page_samples;     ///< files that the page offers
  bool insecure_bind = false;                ///< listen beyond this machine without tokens
  /// Every setting as it is in force, for the log.
  nlohmann::ordered_json configuration;
  std::vector<std::string> warnings;
};

/// How bake inserts sites into the tetrahedralization; the bytes do not depend on it.
enum class Insertion { kCavity, kFlips };

struct BakeOptions {
  bake::BakeSource source;  ///< its parameters as given: checked by the same table as the server's query
  ServiceConfig service;
  std::string shard;              ///< "I/N" or "auto/N"; empty: everything
  std::size_t allow_refused = 0;  ///< inputs that may be refused before the exit code says so
  int jobs = 0;                   ///< at the same time, 0: one for each core, or kRemoteJobs
  bool force = false;
  bool explain = false;  ///< say which parameters each job has, and make nothing
  Insertion insertion = Insertion::kCavity;
  int threads = 0;                ///< for a single file
  std::uint64_t memory = 0;       ///< bytes, of all jobs together; 0: three quarters of what there is
  std::string server;             ///< URL; empty: baked here
  std::string ca_file;            ///< PEM, for https; empty: whom this system trusts
  std::string token;              ///< for the server
  std::uint32_t patience_s = 60;  ///< with the server
  std::string renderer;           ///< program that draws previews; empty: looked for
  int preview_size = 0;           ///< pixels; 0: kPictureOfOne or kPictureOfMany
  int preview_timeout_s = 60;     ///< for one picture
  bool quiet = false;
};

struct InspectOptions {
  std::string input;
  ServiceConfig service;
  std::vector<RawParameter> parameters;
  int threads = 0;
  bool json = false;
};

struct HealthOptions {
  std::string url;          ///< http://host[:port][/path]; empty: the admin listener by environment and file
  std::string config_file;  ///< as of `serve`; empty: none
  bool ready = false;       ///< ask /readyz (does it take requests?) instead of /livez
  int timeout = 2;          ///< seconds for the connection, and as many for the answer
};

int serve(const ServeOptions& options);
int bake(const BakeOptions& options);
int inspect(const InspectOptions& options);
/// kExitDone when the answer is 200; kExitUsage when the URL or the settings are wrong; else kExitSystem. The reason is on standard error.
int health(const HealthOptions& options);

}  // namespace fracture::cli
