// fracture-server bake: the service without HTTP, for one file, or for folders, manifests and shards on a
// farm.
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>

#include "common/base/printable.hpp"
#include "common/base/printed_output.hpp"
#include "common/base/words.hpp"
#include "server/bake/explain.hpp"
#include "server/bake/failure.hpp"
#include "server/bake/flip_engine.hpp"
#include "server/bake/import_workers.hpp"
#include "server/bake/input_file.hpp"
#include "server/bake/mesh_search.hpp"
#include "server/bake/output_path.hpp"
#include "server/bake/plan.hpp"
#include "server/bake/preview.hpp"
#include "server/bake/remote_baker.hpp"
#include "server/bake/run.hpp"
#include "server/bake/stage_dump.hpp"
#include "server/cli/options.hpp"
#include "server/service/control_group.hpp"
#include "server/service/failure_keeper.hpp"
#include "server/service/worker_pool.hpp"

namespace fracture::cli {
namespace {

/// Jobs at the same time if a server computes them and its number of cores is unknown. Enough for eight
/// cores.
constexpr int kRemoteJobs = 8;

std::atomic<bool> interrupted{false};
void on_interrupt(int) { interrupted = true; }

/// Turns SIGINT and SIGTERM into a stop request. A signal handler must not use a stop_source, so a watcher
/// thread polls the flag that the handler sets.
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
    std::mutex mutex;
    std::condition_variable_any ended;  // ends the wait at once when the thread is stopped
    std::unique_lock lock(mutex);
    while (!end.stop_requested()) {
      if (interrupted) stop_.request_stop();
      ended.wait_for(lock, end, std::chrono::milliseconds(20), [] { return false; });
    }
  }};
};

void say(const std::string& line) {
  std::fprintf(stderr, "fracture-server bake: %s\n", printable_lines(line).c_str());
}

int wrong_command_line(const std::string& why) {
  say(why);
  return kExitUsage;
}

/// Returns the stream for summaries: standard output, unless the fragments are written there.
FILE* words_of(const bake::BakePlan& plan) {
  return plan.single && !plan.jobs.empty() && plan.jobs.front().output == bake::kStandardStream ? stderr
                                                                                                : stdout;
}

/// Returns "500 jobs in 12.3 s: 480 made, 19 kept, 1 refused; report in out/bake.ndjson". Counts of zero are left out.
std::string summary_of(const bake::RunFigures& f, std::size_t jobs, double seconds,
                       const std::string& report) {
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
    if (count > 0) line += (line.empty() ? "" : ", ") + grouped(count) + " " + what;
  if (line.empty()) line = "nothing made";
  char took[64];
  std::snprintf(took, sizeof took, " in %.1f s: ", seconds);
  return counted(jobs, "job", "jobs") + took + line +
         (report.empty() ? "" : "; report in " + std::filesystem::path(report).lexically_normal().string());
}

/// Reports the kept failures, even with --quiet, because the user asked for them.
void tell_of(const FailureKeeper& failures) {
  const KeptFailures f = failures.figures();
  if (const std::size_t kept = f.kept + f.known; kept > 0)
    say("kept " + counted(kept, "failure", "failures") + " in " + failures.folder() +
        "; \"command\" in each request.json reproduces the failure");
  if (f.dropped > 0)
    say("no space for " + counted(f.dropped, "more failure", "more failures") + " in " + failures.folder() +
        "; delete the failures there that you no longer need");
}

/// Returns null after reporting an error and setting `exit_code` if the server cannot be used.
std::unique_ptr<bake::Baker> connect(const BakeOptions& options, int jobs, const std::stop_token& stop,
                                     int& exit_code) {
  Expected<protocol::ConnectionSettings> server = bake::parse_server_url(options.server, options.ca_file);
  if (!server) {
    exit_code = wrong_command_line(server.error().detail);
    return nullptr;
  }
  server->token = options.token;
  server->connections = static_cast<std::size_t>(jobs);
  server->connect_timeout = std::chrono::seconds(5);
  server->answer_timeout = std::chrono::seconds(60);
  server->max_answer_bytes = std::size_t{4} << 30;
  bake::RemoteConfig config{std::move(*server), {}};
  config.patience.total = std::chrono::seconds(options.patience_s);
  if (options.explain) return bake::unasked_remote_baker(config);
  auto baker = bake::remote_baker(config, stop, say);
  if (baker) return std::move(*baker);
  const bool stopped = baker.error().code == ErrorCode::kCancelled;
  if (!stopped) say(bake::to_line(baker.error()));
  exit_code = stopped ? kExitInterrupted : kExitSystem;
  return nullptr;
}

/// Optional observers of a bake on this machine.
struct Watched {
  std::shared_ptr<bake::FlipTally> flips;  ///< null: cavity insertion
  std::shared_ptr<bake::StageDump> dump;   ///< null: no dump

  explicit Watched(const BakeOptions& options) {
    if (options.insertion == Insertion::kFlips) flips = std::make_shared<bake::FlipTally>();
    if (const std::string& folder = options.source.stages; !folder.empty())
      dump = std::make_shared<bake::StageDump>(folder, say);
  }
  std::unique_ptr<FractureEngine> engine(int import_workers) const {
    std::unique_ptr<FractureEngine> engine = make_engine(bake::own_import_workers(
        import_workers,
        "The limit is half of the memory of one mesh, which is --memory divided by -j. Use a smaller mesh, raise --memory, or "
        "lower -j."));
    if (flips) engine = bake::flip_engine(std::move(engine), flips);
    if (dump) engine = bake::dumping_engine(std::move(engine), dump);
    return engine;
  }
};

/// Returns the names that rules by node or material are matched with; empty if no rule needs them.
Expected<bake::MeshNames> names_for(const bake::BakePlan& plan, const bake::BakeJob& job,
                                    const std::stop_token& stop) {
  if (!plan.rules.by_names()) return bake::MeshNames{};
  const std::optional<std::string> bytes = bake::read_bytes(job.input, stop);
  if (bytes) return bake::names_in(job.input, std::as_bytes(std::span(*bytes)), bake::format_given(job));
  if (errno == ECANCELED) return fail(ErrorCode::kCancelled, "Stopped.");
  return fail(ErrorCode::kFileAccess, "cannot read " + printable(job.input) + ": " + std::strerror(errno));
}

/// Default picture size in pixels. A single picture is viewed alone; many are compared in a table.
constexpr int kPictureOfOne = 512, kPictureOfMany = 256;

/// The pictures of a bake, if there are any.
struct Pictured {
  std::unique_ptr<bake::Previews> previews;  ///< null: no pictures requested
  std::string none;                          ///< a sentence: why the page has no pictures
};

/// Returns kNoProgram if --preview is given but there is no renderer. An HTML page is written without
/// pictures then.
Expected<Pictured> pictured(const BakeOptions& options, bool single, int jobs) {
  const bool asked = !options.source.preview.empty();
  if (!asked && options.source.html.empty()) {
    if (!options.renderer.empty())
      return fail(ErrorCode::kBadParameter, "--renderer needs --preview or --html: give one of them.");
    return Pictured{};
  }
  const Expected<std::string> renderer = bake::find_renderer(options.renderer);
  if (!renderer && (asked || !options.renderer.empty())) return tl::unexpected(renderer.error());
  const int cores = available_cores();
  const bake::PreviewSettings settings{.renderer = renderer ? *renderer : std::string(),
                                       .size = options.preview_size > 0 ? options.preview_size
                                               : single                 ? kPictureOfOne
                                                                        : kPictureOfMany,
                                       .fine = single,
                                       .at_once = std::min(jobs, cores),
                                       .threads = single ? 0 : 1,
                                       .limit = std::chrono::seconds(options.preview_timeout_s)};
  return Pictured{std::make_unique<bake::Previews>(settings, say), renderer ? "" : renderer.error().detail};
}

/// Returns "assets/ -> broken/", the title of the page.
std::string title_of(const bake::BakeSource& source) {
  if (!source.manifest.empty()) return source.manifest;
  std::string title;
  for (const std::string& input : source.inputs) {
    constexpr std::size_t kMost = 200;  // a shell's glob can expand to thousands of names
    if (title.size() > kMost) {
      title += " …";
      break;
    }
    title += (title.empty() ? "" : " ") + input;
  }
  return title + " → " + source.output;
}

/// Prints the parameters of each job. Makes no outputs and writes no report.
int explain(const bake::BakePlan& plan, bake::Baker& baker, std::size_t allowed,
            const std::stop_token& stop) {
  std::size_t refused = 0, unreadable = plan.dangling.size();
  bake::RuleTally tally(plan.rules);
  for (const bake::BakeJob& job : plan.jobs) {
    if (stop.stop_requested()) return kExitInterrupted;
    const Expected<bake::MeshNames> names = names_for(plan, job, stop);
    if (!names && names.error().code == ErrorCode::kCancelled) return kExitInterrupted;
    if (!names) tally.add_unread(job.input);
    if (!names && names.error().code == ErrorCode::kFileAccess) {
      say(names.error().detail);
      ++unreadable;
      continue;
    }
    Expected<std::vector<bake::RuleMatch>> match = std::vector<bake::RuleMatch>{};
    if (names)
      match = tally.find(job.input, *names, stop);
    else
      match = tl::unexpected(names.error());
    if (!match && match.error().code == ErrorCode::kCancelled) return kExitInterrupted;
    if (!match) {
      std::printf("%s -> %s\n  refused: %s\n", printable(job.input).c_str(), printable(job.output).c_str(),
                  printable(bake::to_line(match.error())).c_str());
      ++refused;
      continue;
    }
    const bake::JobParameters parameters = bake::parameters_of(job, plan.rules, std::move(*match));
    std::string text = bake::explanation_of(job, plan.rules, parameters);
    if (const auto parsed = baker.parse(parameters.all); !parsed) {
      text += "  refused: " + printable(bake::to_line(parsed.error())) + "\n";
      ++refused;
    }
    std::fputs(text.c_str(), stdout);
  }
  if (plan.jobs.size() == plan.all)
    for (const std::string& warning : tally.warnings()) say("warning: " + warning);
  if (flush_printed() != 0 || unreadable > 0) return kExitSystem;
  return refused > allowed ? kExitRefused : kExitDone;
}

}  // namespace

int bake(const BakeOptions& options) {
  bake::BakeSource source = options.source;
  if (!options.shard.empty()) {
    const Expected<bake::Shard> shard = bake::parse_shard(options.shard);
    if (!shard) return wrong_command_line(shard.error().detail);
    source.shard = *shard;
  }
  const ParameterTable table(options.service.max_sites, options.service.formats);
  const Expected<bake::BakePlan> plan = bake::plan_bake(
      source, [&](const std::vector<RawParameter>& given) { return bake::parse_parameters(table, given); });
  if (!plan) return wrong_command_line(plan.error().detail);
  for (const std::string& link : plan->dangling) say("cannot read " + link + ": " + bake::kDangling);
  FILE* const words = words_of(*plan);
  if (!options.explain && words == stderr && ::isatty(STDOUT_FILENO))
    return wrong_command_line(
        "Standard output ('-') is a terminal, which cannot show a GLB: redirect it, or give a file.");
  if (const std::size_t results = plan->skipped.size(); results > 0 && !options.quiet)
    say("skipped " + std::to_string(results) +
        (results > 1 ? " results of earlier bakes, such as " : " result of an earlier bake: ") +
        plan->skipped.front());

  const bool remote = !options.server.empty();
  const Watched watched(options);
  if (remote && (watched.flips || watched.dump))
    return wrong_command_line("--insertion and --dump-stages work only on this machine: leave out --server.");
  const int cores = available_cores();
  const int jobs = plan->single ? 1 : options.jobs > 0 ? options.jobs : remote ? kRemoteJobs : cores;
  ServiceConfig service = options.service;
  const std::uint64_t memory = options.memory > 0 ? options.memory : available_memory() / 4 * 3;
  service.max_bytes_per_job = memory / static_cast<std::uint64_t>(jobs);
  service.memory_setting = "--memory";
  StopOnSignal stop;
  int refused = 0;
  std::unique_ptr<bake::Baker> baker;
  try {
    baker = remote ? connect(options, jobs, stop.token(), refused)
                   : bake::local_baker(service, watched.engine(jobs));
  } catch (const std::runtime_error& e) {  // thrown if the import processes cannot be started
    say(e.what());
    return kExitSystem;
  }
  if (!baker) return refused;
  if (source.manifest.empty())  // with a manifest, each line has its own parameters
    if (const auto parameters = baker->parse(source.parameters); !parameters) {
      say("parameters: " + bake::to_lines(parameters.error()));
      return kExitRefused;
    }
  if (const auto right =
          bake::check_rules(plan->rules, source.parameters,
                            [&](const std::vector<RawParameter>& given) { return baker->parse(given); });
      !right)
    return wrong_command_line(bake::to_line(right.error()));
  if (options.explain) return explain(*plan, *baker, options.allow_refused, stop.token());
  const Expected<Pictured> pictures = pictured(options, plan->single, jobs);
  if (!pictures) return wrong_command_line(bake::to_line(pictures.error()));
  if (!pictures->none.empty() && !options.quiet) say("no pictures are drawn: " + pictures->none);
  FailureKeeper failures({.folder = source.failures, .program = "fracture-server " FRACTURE_VERSION}, say);
  bake::RunOptions run;
  run.jobs = jobs;
  if (plan->single) run.threads = options.threads > 0 ? options.threads : cores;
  run.report = plan->report;
  run.depfile = source.depfile;
  run.stages = source.stages;
  run.force = options.force || watched.dump;
  run.quiet = options.quiet;
  run.failures = &failures;
  run.previews = pictures->previews.get();
  run.title = title_of(source);
  run.no_pictures = pictures->none;
  const auto start = std::chrono::steady_clock::now();
  bake::RunFigures f = bake::run_bake(*plan, *baker, run, stop.token());
  f.unreadable += plan->dangling.size();
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  tell_of(failures);
  if (!options.quiet && f.begun) {
    std::string summary =
        plan->single ? f.sentence : summary_of(f, plan->jobs.size(), took.count(), run.report);
    if (!summary.empty() && !plan->html.empty()) summary += "; page in " + plan->html;
    if (!summary.empty()) std::fprintf(words, "%s\n", printable_lines(summary).c_str());
    if (watched.flips) std::fprintf(words, "%s\n", watched.flips->sentence().c_str());
    if (f.cancelled > 0 && !run.report.empty())
      std::fprintf(words,
                   "To continue, run the same command "
                   "again.\n");
  }
  const int code = exit_code(f, options.allow_refused);
  return code == kExitDone && watched.dump && watched.dump->failed() ? kExitSystem : code;
}

}  // namespace fracture::cli
