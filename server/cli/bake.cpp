// fracture-server bake: the service without HTTP, for artists (one file) and farms (folders, manifests,
// shards).
#include <signal.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cinttypes>
#include <cstdio>
#include <cstring>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>

#include "server/bake/atomic_file.hpp"
#include "server/bake/depfile.hpp"
#include "server/bake/import_workers.hpp"
#include "server/bake/input_file.hpp"
#include "server/bake/memory.hpp"
#include "server/bake/plan.hpp"
#include "server/bake/progress.hpp"
#include "server/bake/remote_baker.hpp"
#include "server/bake/run.hpp"
#include "server/cli/options.hpp"
#include "server/service/worker_pool.hpp"

namespace fracture::cli {
namespace {

/// At the same time through a server whose cores are not known: enough for eight of them, and little to hold.
constexpr int kRemoteJobs = 8;

std::atomic<bool> interrupted{false};
void on_interrupt(int) { interrupted = true; }

/// SIGINT and SIGTERM as a stop. A signal handler may not touch a stop_source: a watcher carries the message.
class StopOnSignal {
 public:
  StopOnSignal() {
    struct sigaction action {};
    action.sa_handler = on_interrupt;
    sigaction(SIGINT, &action, nullptr);
    sigaction(SIGTERM, &action, nullptr);
  }
  std::stop_token token() { return stop_.get_token(); }

 private:
  std::stop_source stop_;
  std::jthread watcher_{[this](const std::stop_token& end) {
    while (!end.stop_requested()) {
      if (interrupted) stop_.request_stop();
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  }};
};

int unreadable(const std::string& input) {
  std::fprintf(stderr, "fracture-server bake: cannot read %s: %s\n", input.c_str(), std::strerror(errno));
  return kExitSystem;
}

int refuse(const std::string& input, const Error& error) {
  std::fprintf(stderr, "fracture-server bake: %s: %s: %s\n  %s\n", input.c_str(), slug(error.code),
               title(error.code), error.detail.c_str());
  if (error.extra.contains("errors") && error.extra["errors"].size() > 1)
    for (std::size_t i = 1; i < error.extra["errors"].size(); ++i)
      std::fprintf(stderr, "  %s\n", error.extra["errors"][i].value("detail", "").c_str());
  return error.code == ErrorCode::kCancelled ? kExitInterrupted : kExitRefused;
}

/// With the share of the memory that each of the jobs may hold.
ServiceConfig service_for(const BakeOptions& options, int jobs) {
  ServiceConfig service = options.service;
  const std::uint64_t memory = options.memory > 0 ? options.memory : bake::available_memory() / 4 * 3;
  service.max_bytes_per_job = memory / static_cast<std::uint64_t>(jobs);
  return service;
}

/// One file with all threads, in the words of one.
int bake_one(const bake::BakeJob& job, const BakeOptions& options) {
  FractureService service(service_for(options, 1), make_engine(bake::own_import_workers(1)));
  Expected<RequestParameters> parameters = service.parse(job.parameters);
  if (!parameters) return refuse(job.input, parameters.error());
  if (!bake::is_readable(job.input)) return unreadable(job.input);
  const Expected<MeshFormat> format = bake::format_of_input(job.input, *parameters);
  if (!format) return refuse(job.input, format.error());
  const std::optional<bake::InputFile> input = bake::read_input(job.input, *format);
  if (!input) return unreadable(job.input);

  bake::StageProgress progress(options.quiet);
  StopOnSignal stop;
  Execution execution;
  execution.threads = options.threads > 0 ? options.threads : available_cores();
  execution.stop = stop.token();
  execution.progress = [&progress](const char* stage, double fraction) { progress.show(stage, fraction); };

  const bool gltf = format_from_extension(job.output.substr(job.output.rfind('.') + 1)) == MeshFormat::kGltf;
  const OutputFormat output = gltf ? OutputFormat::kGltf : OutputFormat::kGlb;
  const auto start = std::chrono::steady_clock::now();
  const Expected<FractureAnswer> answer = service.fracture(
      {input->view(), *format, *parameters, as_import_files(input->siblings), output}, execution);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  progress.finish();
  if (!answer) return refuse(job.input, answer.error());
  if (!bake::make_folders_of(job.output) ||
      !bake::write_file(job.output, std::as_bytes(std::span(answer->result->file)))) {
    std::fprintf(stderr, "fracture-server bake: cannot write %s: %s\n", job.output.c_str(),
                 std::strerror(errno));
    return kExitSystem;
  }
  if (!options.source.depfile.empty() && !bake::write_depfile(options.source.depfile, job, *input)) {
    std::fprintf(stderr, "fracture-server bake: cannot write %s: %s\n", options.source.depfile.c_str(),
                 std::strerror(errno));
    return kExitSystem;
  }
  if (!options.quiet) {
    const Certificate& c = answer->certificate;
    std::printf("%s: %u fragments, volume in %.9g m3, out %.9g m3, relative error %.2g, %" PRIu64
                " open edges, %zu bytes, %.3f s (",
                job.output.c_str(), c.fragments, c.volume_in, c.volume_out, c.relative_error, c.open_edges,
                answer->result->file.size(), took.count());
    const char* separator = "";
    for (const auto& [stage, ms] : answer->timings.stages()) {
      std::printf("%s%s %.1f ms", separator, stage.c_str(), ms);
      separator = ", ";
    }
    std::printf(")\n");
  }
  return kExitDone;
}

/// "480 made, 19 kept, 1 refused of 500 jobs in 12.3 s; report in out/bake.ndjson": what there was none of is
/// left out.
void print_summary(const bake::RunFigures& f, std::size_t jobs, double seconds, const std::string& report) {
  std::string line;
  const std::pair<std::size_t, const char*> figures[] = {{f.made, "made"},
                                                         {f.kept, "kept"},
                                                         {f.refused, "refused"},
                                                         {f.failed, "failed"},
                                                         {f.unsound, "unsound"},
                                                         {f.unreadable, "unreadable"},
                                                         {f.unwritable, "not written"},
                                                         {f.cancelled, "not done"}};
  for (const auto& [count, what] : figures)
    if (count > 0) line += (line.empty() ? "" : ", ") + std::to_string(count) + " " + what;
  if (line.empty()) line = "nothing";
  std::printf("%s of %zu jobs in %.1f s", line.c_str(), jobs, seconds);
  if (!report.empty()) std::printf("; report in %s", report.c_str());
  std::printf("\n");
}

/// Null where the server cannot be asked, which has been said.
std::unique_ptr<bake::Baker> connect(const BakeOptions& options, int jobs, const std::stop_token& stop,
                                     int& exit_code) {
  Expected<protocol::ConnectionSettings> server = bake::parse_server_url(options.server);
  if (!server) {
    std::fprintf(stderr, "fracture-server bake: %s\n", server.error().detail.c_str());
    exit_code = kExitUsage;
    return nullptr;
  }
  server->token = options.token;
  server->connections = static_cast<std::size_t>(jobs);
  server->connect_timeout = std::chrono::seconds(5);
  server->answer_timeout = std::chrono::seconds(60);
  server->max_answer_bytes = std::size_t{4} << 30;
  bake::RemoteConfig config{std::move(*server), {}};
  config.patience.total = std::chrono::seconds(options.patience_s);
  auto baker = bake::remote_baker(config, stop, [](const std::string& line) {
    std::fprintf(stderr, "fracture-server bake: %s\n", line.c_str());
  });
  if (baker) return std::move(*baker);
  const bool stopped = baker.error().kind == bake::BakeFailure::Kind::kCancelled;
  if (!stopped) std::fprintf(stderr, "fracture-server bake: %s\n", baker.error().words().c_str());
  exit_code = stopped ? kExitInterrupted : kExitSystem;
  return nullptr;
}

int exit_code(const bake::RunFigures& f, const BakeOptions& options) {
  if (f.unavailable > 0) return kExitSystem;
  if (f.cancelled > 0) return kExitInterrupted;
  if (f.unsound > 0 || f.failed > 0) return kExitInternal;
  if (f.unreadable > 0 || f.unwritable > 0) return kExitSystem;
  return f.refused > options.allow_refused ? kExitRefused : kExitDone;
}

}  // namespace

int bake(const BakeOptions& options) {
  bake::BakeSource source = options.source;
  if (!options.shard.empty()) {
    const Expected<bake::Shard> shard = bake::parse_shard(options.shard);
    if (!shard) {
      std::fprintf(stderr, "fracture-server bake: %s\n", shard.error().detail.c_str());
      return kExitUsage;
    }
    source.shard = *shard;
  }
  const Expected<bake::BakePlan> plan = bake::plan_bake(source);
  if (!plan) {
    std::fprintf(stderr, "fracture-server bake: %s\n", plan.error().detail.c_str());
    return kExitUsage;
  }
  if (const std::size_t results = plan->skipped.size(); results > 0 && !options.quiet)
    std::fprintf(stderr, "fracture-server bake: skipped %zu %s %s\n", results,
                 results > 1 ? "results of earlier bakes, such as" : "result of an earlier bake:",
                 plan->skipped.front().c_str());
  const bool remote = !options.server.empty();
  if (plan->single && plan->report.empty() && !remote) return bake_one(plan->jobs.front(), options);

  const int jobs = options.jobs > 0 ? options.jobs : remote ? kRemoteJobs : available_cores();
  StopOnSignal stop;
  int refused = 0;
  const std::unique_ptr<bake::Baker> baker = remote ? connect(options, jobs, stop.token(), refused)
                                                    : bake::local_baker(service_for(options, jobs), jobs);
  if (!baker) return refused;
  if (source.manifest.empty())  // else each line has its own
    if (const auto parameters = baker->parse(source.parameters); !parameters)
      return refuse("parameters", parameters.error());
  bake::RunOptions run;
  run.jobs = jobs;
  run.report = plan->report;
  run.depfile = source.depfile;
  run.force = options.force;
  run.quiet = options.quiet;
  const auto start = std::chrono::steady_clock::now();
  const bake::RunFigures f = bake::run_bake(*plan, *baker, run, stop.token());
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  if (!options.quiet) {
    print_summary(f, plan->jobs.size(), took.count(), run.report);
    if (f.cancelled > 0 && !run.report.empty()) std::printf("The same command goes on from there.\n");
  }
  return exit_code(f, options);
}

}  // namespace fracture::cli
