#include "server/bake/run.hpp"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <fstream>
#include <iterator>
#include <new>
#include <thread>

#include "server/bake/atomic_file.hpp"
#include "server/bake/depfile.hpp"
#include "server/bake/input_file.hpp"
#include "server/bake/progress.hpp"
#include "server/bake/report.hpp"

namespace fracture::bake {
namespace {

constexpr double kMaxRelativeError = 1e-9;

bool has_digest(const std::string& path, const std::string& digest) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return false;
  const std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  return !file.bad() && "sha256:" + sha256(bytes).hex() == digest;
}

OutputFormat format_of_output(const std::string& path) {
  return path.size() > 5 && path.ends_with(".gltf") ? OutputFormat::kGltf : OutputFormat::kGlb;
}

class Run {
 public:
  Run(const BakePlan& plan, Baker& baker, const RunOptions& options, const std::stop_token& stop)
      : plan_(plan),
        baker_(baker),
        options_(options),
        stop_(stop),
        report_(options.report),
        progress_(plan.jobs.size(), options.quiet) {
    baker_.on_notice([this](const std::string& line) { progress_.say("fracture-server bake: " + line); });
  }
  ~Run() {
    baker_.on_notice([](const std::string&) {});
  }

  RunFigures operator()() {
    {
      std::vector<std::jthread> threads;
      for (int k = 0; k < options_.jobs; ++k)
        threads.emplace_back([this] {
          for (std::size_t job = next_++; job < plan_.jobs.size(); job = next_++) {
            if (stop_.stop_requested() || unavailable_)
              count(&RunFigures::cancelled);
            else
              work(job);
          }
        });
    }
    std::vector<std::string> outputs;
    for (const BakeJob& job : plan_.jobs) outputs.push_back(job.output);
    // A run that was stopped leaves its lines as they are: the next one goes on from them.
    if (figures_.cancelled == 0 && !report_.finish(outputs)) unwritable(options_.report);
    progress_.finish();
    return figures_;
  }

 private:
  void count(std::size_t RunFigures::*figure) {
    const std::lock_guard lock(mutex_);
    ++(figures_.*figure);
  }

  void unwritable(const std::string& path) {
    progress_.say("fracture-server bake: cannot write " + path + ": " + std::strerror(errno));
    count(&RunFigures::unwritable);
  }

  /// With the reason in errno.
  void unreadable(std::size_t job) {
    const std::string reason = std::strerror(errno);
    progress_.say("fracture-server bake: cannot read " + plan_.jobs[job].input + ": " + reason);
    report(job, {{"status", "unreadable"}, {"problem", {{"detail", reason}}}});
    count(&RunFigures::unreadable);
    progress_.done(false, false);
  }

  void report(std::size_t job, nlohmann::json line) {
    line["input"] = plan_.jobs[job].input;
    line["output"] = plan_.jobs[job].output;
    if (!report_.add(job, line)) unwritable(options_.report);
  }

  void fail(std::size_t job, const BakeFailure& failure) {
    using enum BakeFailure::Kind;
    if (failure.kind == kUnavailable && !unavailable_.exchange(true)) {
      progress_.say("fracture-server bake: " + failure.words());
      count(&RunFigures::unavailable);
    }
    if (failure.kind == kCancelled || failure.kind == kUnavailable) return count(&RunFigures::cancelled);
    const bool refused = failure.kind == kRefused;
    progress_.say(plan_.jobs[job].input + ": " + failure.words());
    report(job, {{"status", refused ? "refused" : "failed"}, {"problem", failure.problem}});
    count(refused ? &RunFigures::refused : &RunFigures::failed);
    progress_.done(false, refused);
  }

  /// One job that goes wrong in a way that nobody thought of is no reason to lose the others.
  void work(std::size_t number) {
    try {
      make_or_keep(number);
    } catch (const std::bad_alloc&) {
      fail(number, {BakeFailure::Kind::kBroken,
                    BakeFailure(Error{ErrorCode::kOutOfMemory, "Memory is exhausted."}).problem});
    } catch (const std::exception& bug) {
      fail(number, BakeFailure(Error{ErrorCode::kInternal, bug.what()}));
    }
  }

  void make_or_keep(std::size_t number) {
    const BakeJob& job = plan_.jobs[number];
    const Expected<RequestParameters> parameters = baker_.parse(job.parameters);
    if (!parameters) return fail(number, BakeFailure(parameters.error()));
    if (!is_readable(job.input)) return unreadable(number);
    const Expected<MeshFormat> format = format_of_input(job.input, *parameters);
    if (!format) return fail(number, BakeFailure(format.error()));
    const std::optional<InputFile> input = read_input(job.input, *format);
    if (!input) return unreadable(number);
    const FractureRequest request{input->view(), *format, *parameters, as_import_files(input->siblings),
                                  format_of_output(job.output)};
    const RequestKeys keys = keys_of(request);
    if (const KnownOutput* known = options_.force ? nullptr : report_.find(job.output);
        known && known->key == keys.result && has_digest(job.output, known->digest)) {
      report(number, known->line);
      count(&RunFigures::kept);
      return progress_.done(true, false);
    }
    make(number, request, keys, *input);
  }

  void make(std::size_t number, const FractureRequest& request, const RequestKeys& keys,
            const InputFile& input) {
    const BakeJob& job = plan_.jobs[number];
    Execution execution;
    execution.threads = 1;
    execution.stop = stop_;
    const auto start = std::chrono::steady_clock::now();
    const tl::expected<Baked, BakeFailure> baked = baker_.bake(request, execution);
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
    if (!baked) return fail(number, baked.error());
    if (!make_folders_of(job.output) || !write_file(job.output, std::as_bytes(std::span(*baked->file)))) {
      unwritable(job.output);
      return progress_.done(false, false);
    }
    if (!options_.depfile.empty() && !write_depfile(options_.depfile, job, input))
      unwritable(options_.depfile);
    const bool sound = is_sound(baked->figures);
    if (!sound)
      progress_.say(job.input +
                    ": the certificate does not hold: " + baked->figures.at("certificate").dump());
    report(number, {{"status", sound ? "made" : "unsound"},
                    {"key", keys.result},
                    {"mesh", "sha256:" + keys.digest},
                    {"digest", "sha256:" + baked->digest.hex()},
                    {"bytes", baked->file->size()},
                    {"seconds", took.count()},
                    {"certificate", baked->figures.at("certificate")}});
    count(sound ? &RunFigures::made : &RunFigures::unsound);
    progress_.done(false, false);
  }

  const BakePlan& plan_;
  Baker& baker_;
  const RunOptions& options_;
  const std::stop_token stop_;
  BakeReport report_;
  JobProgress progress_;
  std::atomic<std::size_t> next_{0};
  std::atomic<bool> unavailable_{false};
  std::mutex mutex_;
  RunFigures figures_;
};

}  // namespace

RunFigures run_bake(const BakePlan& plan, Baker& baker, const RunOptions& options,
                    const std::stop_token& stop) {
  return Run(plan, baker, options, stop)();
}

bool is_sound(const nlohmann::json& figures) {
  const nlohmann::json& certificate = figures.at("certificate");
  if (certificate.at("open_edges") != 0) return false;
  const bool partition = !figures.value("report", nlohmann::json::object()).contains("barycenter");
  return !partition || certificate.at("relative_error").get<double>() <= kMaxRelativeError;
}

}  // namespace fracture::bake
