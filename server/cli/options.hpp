// The command line: four commands, each with its own settings. For exit codes, see exit_codes.hpp.
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
  std::string keep_failures;  ///< folder; empty: failures are not kept
  StoreConfig store;
  JobsConfig jobs;
  std::uint64_t memory =
      0;            ///< limit on resident bytes of server and import workers; 0: all (memory_plan.hpp)
  int threads = 0;  ///< in the worker pool; 0: one per core
  std::size_t max_queue = 256;
  int import_workers = available_cores();
  std::uint64_t import_memory = 2ull << 30;  ///< maximum bytes for an import worker; 0: no limit
  std::string require_sandbox = "auto";      ///< auto, yes, no
  bool sandbox_required = false;             ///< the result of require_sandbox on this machine
  std::chrono::milliseconds drain_delay{0}, grace{30'000};
  std::string log_level = "info";
  std::string log_format = "auto";
  std::vector<std::string> enabled_formats;  ///< added to service.formats
  bool all_formats = false;
  std::string redis_password_file;           ///< its first line; empty: service.tiers.redis.password
  std::string farm_key_file;                 ///< empty: data in shared tiers is not signed
  std::string token_file;                    ///< empty: no authentication
  std::vector<std::string> trusted_proxies;  ///< networks
  bool no_page = false;                      ///< browsers get JSON, like other clients
  std::vector<std::string> page_samples;     ///< files that the page offers
  bool insecure_bind = false;                ///< allow listening on the network without tokens
  /// All settings with their current values, for the log.
  nlohmann::ordered_json configuration;
  std::vector<std::string> warnings;
};

/// How bake inserts sites into the tetrahedralization. The output bytes do not depend on it.
enum class Insertion { kCavity, kFlips };

struct BakeOptions {
  bake::BakeSource source;  ///< unparsed parameters, validated by the same table as a server's query
  ServiceConfig service;
  std::string shard;              ///< "I/N" or "auto/N"; empty: everything
  std::size_t allow_refused = 0;  ///< number of refused inputs that still give exit code 0
  int jobs = 0;                   ///< at the same time; 0: one per core, or kRemoteJobs
  bool force = false;
  bool explain = false;  ///< print the parameters of each job and make nothing
  Insertion insertion = Insertion::kCavity;
  int threads = 0;                ///< for a single file
  std::uint64_t memory = 0;       ///< bytes for all jobs together; 0: three quarters of the available memory
  std::string server;             ///< URL; empty: bake on this machine
  std::string ca_file;            ///< PEM, for https; empty: the system's certificate authorities
  std::string token;              ///< for the server
  std::uint32_t patience_s = 60;  ///< seconds to wait for the server
  std::string renderer;           ///< program that draws previews; empty: search for it
  int preview_size = 0;           ///< pixels; 0: kPictureOfOne or kPictureOfMany
  int preview_timeout_s = 60;     ///< for one picture
  bool quiet = false;
};

struct InspectOptions {
  std::vector<std::string> inputs;  ///< files, folders (all meshes below them) and globs
  ServiceConfig service;
  std::vector<RawParameter> parameters;
  int threads = 0;
  std::uint64_t memory = 0;  ///< bytes for one mesh; 0: three quarters of the available memory
  bool json = false;
};

struct HealthOptions {
  std::string url;          ///< http://host[:port][/path]; empty: the admin listener by settings
  std::string config_file;  ///< the config file of `serve`; empty: none
  bool ready = false;       ///< ask /readyz (does the server accept requests?) instead of /livez
  int timeout = 2;          ///< seconds to connect, and the same again for the answer
};

int serve(const ServeOptions& options);
int bake(const BakeOptions& options);
int inspect(const InspectOptions& options);
/// Returns kExitDone if the answer is 200, kExitUsage if the URL or the settings are invalid, else
/// kExitSystem. The reason is printed to standard error.
int health(const HealthOptions& options);

}  // namespace fracture::cli
