#include "server/bake/run.hpp"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <new>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "common/gltf/report_text.hpp"
#include "server/bake/atomic_file.hpp"
#include "server/bake/depfile.hpp"
#include "server/bake/failure.hpp"
#include "server/bake/input_file.hpp"
#include "server/bake/output_path.hpp"
#include "server/bake/progress.hpp"
#include "server/bake/report.hpp"

namespace fracture::bake {
namespace {

using nlohmann::json;

constexpr double kMaxRelativeError = 1e-9;

bool has_digest(const std::string& path, const std::string& digest) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return false;
  const std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  return !file.bad() && "sha256:" + sha256(bytes).hex() == digest;
}

std::string name_of_input(const std::string& path) {
  return path == kStandardStream ? "standard input" : path;
}

std::string name_of_output(const std::string& path) {
  return path == kStandardStream ? "standard output" : path;
}

Error unsound(const Certificate& c) {
  char detail[300];
  std::snprintf(
      detail, sizeof detail,
      "The certificate does not hold: %llu open edges, %llu caps without a mirror image, volume in %.9g m3, "
      "out %.9g m3, relative error %.2g. Nothing was written.",
      static_cast<unsigned long long>(c.open_edges), static_cast<unsigned long long>(c.unmirrored_caps),
      c.volume_in, c.volume_out, c.relative_error);
  return {ErrorCode::kUnsound, detail, {}, Figures(certificate_document(c))};
}

/// "fragments.glb: 50 fragments, volume in 1 m3, out 1 m3, relative error 2.2e-16, 0 open edges, 51372 bytes,
/// 0.006 s (import 0.1 ms, ...)"
std::string sentence_of(const std::string& output, const Baked& baked, double seconds) {
  const Certificate& c = baked.summary.certificate;
  char text[300];
  std::snprintf(
      text, sizeof text,
      ": %u fragments, volume in %.9g m3, out %.9g m3, relative error %.2g, %llu open edges, %zu bytes, "
      "%.3f s",
      c.fragments, c.volume_in, c.volume_out, c.relative_error, static_cast<unsigned long long>(c.open_edges),
      baked.file->size(), seconds);
  std::string sentence = name_of_output(output) + text;
  const char* separator = " (";
  for (const StageRow& row : kStages) {
    if (!baked.timings.ran(row.stage)) continue;
    std::snprintf(text, sizeof text, "%s%s %.1f ms", separator, row.name,
                  baked.timings.milliseconds(row.stage));
    sentence += text;
    separator = ", ";
  }
  return sentence + (baked.timings.empty() ? "" : ")");
}

std::unique_ptr<Progress> progress_of(const BakePlan& plan, bool quiet) {
  if (plan.single) return std::make_unique<StageProgress>(quiet);
  return std::make_unique<JobProgress>(plan.jobs.size(), quiet);
}

class Run {
 public:
  Run(const BakePlan& plan, Baker& baker, const RunOptions& options, const std::stop_token& stop)
      : plan_(plan),
        baker_(baker),
        options_(options),
        stop_(stop),
        report_(options.report),
        progress_(progress_of(plan, options.quiet)) {
    baker_.on_notice([this](const std::string& line) { say(line); });
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
    progress_->finish();
    return figures_;
  }

 private:
  void count(std::size_t RunFigures::*figure) {
    const std::lock_guard lock(mutex_);
    ++(figures_.*figure);
  }

  void say(const std::string& line) { progress_->say("fracture-server bake: " + line); }

  void conclude(const std::string& sentence) {
    if (!plan_.single) return;
    const std::lock_guard lock(mutex_);
    figures_.sentence = sentence;
  }

  /// With the reason in errno.
  void unwritable(const std::string& path) {
    say("cannot write " + name_of_output(path) + ": " + std::strerror(errno));
    count(&RunFigures::unwritable);
  }

  void unwritable(std::size_t job, const std::string& reason) {
    say("cannot write " + name_of_output(plan_.jobs[job].output) + ": " + reason);
    report(job, {{"status", "unwritable"}, {"problem", {{"detail", reason}}}});
    count(&RunFigures::unwritable);
    progress_->done(false, false);
  }

  void unreadable(std::size_t job, const std::string& reason) {
    say("cannot read " + name_of_input(plan_.jobs[job].input) + ": " + reason);
    report(job, {{"status", "unreadable"}, {"problem", {{"detail", reason}}}});
    count(&RunFigures::unreadable);
    progress_->done(false, false);
  }

  void cancelled() {
    conclude("stopped");
    count(&RunFigures::cancelled);
  }

  void report(std::size_t job, json line) {
    line["input"] = plan_.jobs[job].input;
    line["output"] = plan_.jobs[job].output;
    if (!report_.add(job, line)) unwritable(options_.report);
  }

  void fail(std::size_t job, const Error& error) {
    const Outcome outcome = outcome_of(error.code);
    if (outcome == Outcome::kUnavailable && !unavailable_.exchange(true)) {
      say(to_line(error));
      count(&RunFigures::unavailable);
    }
    if (outcome == Outcome::kUnavailable) return count(&RunFigures::cancelled);
    if (outcome == Outcome::kCancelled) return cancelled();
    say(name_of_input(plan_.jobs[job].input) + ": " + to_lines(error));
    const bool refused = outcome == Outcome::kRefused, unproven = outcome == Outcome::kUnsound;
    json line = {{"status", refused    ? "refused"
                            : unproven ? "unsound"
                                       : "failed"},
                 {"problem", to_problem(error)}};
    if (json certificate = certificate_of(error); !certificate.is_null())
      line["certificate"] = std::move(certificate);
    report(job, std::move(line));
    count(refused ? &RunFigures::refused : unproven ? &RunFigures::unsound : &RunFigures::failed);
    progress_->done(false, refused);
  }

  /// So that a bug can be looked into.
  void keep_failure(std::size_t job, const FractureRequest& request, const Error& error) {
    if (!options_.failures || !FailureKeeper::concerns(error.code)) return;
    const std::string& input = plan_.jobs[job].input;
    options_.failures->keep(
        request, {error.code, error.detail}, certificate_of(error),
        input == kStandardStream ? std::string() : std::filesystem::path(input).filename().string());
  }

  /// One job that goes wrong in a way that nobody thought of is no reason to lose the others.
  void work(std::size_t number) {
    try {
      make_or_keep(number);
    } catch (const std::exception&) {
      fail(number, error_of_exception());
    }
  }

  /// Of the exception that is being handled.
  static Error error_of_exception() {
    try {
      throw;
    } catch (const std::bad_alloc&) {
      return {ErrorCode::kOutOfMemory, "Memory is exhausted."};
    } catch (const std::exception& bug) {
      return {ErrorCode::kInternal, bug.what()};
    }
  }

  void make_or_keep(std::size_t number) {
    const BakeJob& job = plan_.jobs[number];
    const Expected<RequestParameters> parameters = baker_.parse(job.parameters);
    if (!parameters) return fail(number, parameters.error());
    std::optional<std::string> bytes = read_bytes(job.input, stop_);
    if (!bytes) return errno == ECANCELED ? cancelled() : unreadable(number, std::strerror(errno));
    const Expected<InputFile> input = to_input(job.input, std::move(*bytes), *parameters);
    if (!input) return fail(number, input.error());
    const Expected<OutputFormat> output = format_of_output(job.output);
    if (!output) return fail(number, output.error());
    const FractureRequest request{input->view(), input->format, *parameters, as_import_files(input->siblings),
                                  *output};
    const RequestKeys keys = keys_of(request);
    if (const KnownOutput* known = options_.force ? nullptr : report_.find(job.output);
        known && known->key == keys.result && has_digest(job.output, known->digest)) {
      report(number, known->line);
      count(&RunFigures::kept);
      conclude(name_of_output(job.output) + ": is right already, kept");
      return progress_->done(true, false);
    }
    protect(*input, job);
    if (const std::optional<Error> loss = loss_by(job)) return unwritable(number, loss->detail);
    make(number, request, keys, *input);
  }

  /// The files that a mesh names are inputs too.
  void protect(const InputFile& input, const BakeJob& job) {
    const std::lock_guard lock(mutex_);
    for (const SiblingFile& file : input.siblings)
      named_.emplace(identity_of(file.path), "a file that " + job.input + " names");
  }

  /// kFileAccess where the job would write over a file that a mesh names.
  std::optional<Error> loss_by(const BakeJob& job) {
    const std::lock_guard lock(mutex_);
    for (const std::string& path : {job.output, options_.depfile})
      if (!path.empty() && path != kStandardStream)
        if (const auto at = named_.find(identity_of(path)); at != named_.end())
          return Error{ErrorCode::kFileAccess,
                       (path == job.output ? "it is " : "the depfile " + path + " is ") + at->second};
    return std::nullopt;
  }

  Expected<Baked> bake(const FractureRequest& request) {
    Execution execution;
    execution.threads = options_.threads;
    execution.progress = [this](Stage stage, double fraction) { progress_->stage(stage, fraction); };
    try {
      Expected<Baked> baked = baker_.bake(request, execution, stop_);
      if (baked && !is_sound(baked->summary))
        return tl::unexpected<Error>(unsound(baked->summary.certificate));
      return baked;
    } catch (const std::exception&) {
      return tl::unexpected<Error>(error_of_exception());
    }
  }

  bool write(const std::string& output, std::span<const std::byte> bytes) {
    if (output == kStandardStream) return write_standard_output(bytes, stop_);
    return make_folders_of(output) && write_file(output, bytes);
  }

  void make(std::size_t number, const FractureRequest& request, const RequestKeys& keys,
            const InputFile& input) {
    const BakeJob& job = plan_.jobs[number];
    const auto start = std::chrono::steady_clock::now();
    const Expected<Baked> baked = bake(request);
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
    if (!baked) {
      keep_failure(number, request, baked.error());
      return fail(number, baked.error());
    }
    if (const std::optional<Error> loss = loss_by(job)) return unwritable(number, loss->detail);
    if (!write(job.output, std::as_bytes(std::span(*baked->file))))
      return errno == ECANCELED ? cancelled() : unwritable(number, std::strerror(errno));
    if (!options_.depfile.empty() && !write_depfile(options_.depfile, job, input))
      unwritable(options_.depfile);
    const std::vector<std::string>& warnings = baked->summary.warnings;
    for (const std::string& warning : warnings) say(name_of_input(job.input) + ": warning: " + warning);
    json line = {{"status", "made"},
                 {"key", keys.result},
                 {"mesh", "sha256:" + keys.digest},
                 {"digest", "sha256:" + baked->digest.hex()},
                 {"bytes", baked->file->size()},
                 {"seconds", took.count()},
                 {"certificate", certificate_document(baked->summary.certificate)}};
    if (!warnings.empty()) line["warnings"] = warnings;
    report(number, std::move(line));
    conclude(sentence_of(job.output, *baked, took.count()));
    count(&RunFigures::made);
    progress_->done(false, false);
  }

  const BakePlan& plan_;
  Baker& baker_;
  const RunOptions& options_;
  const std::stop_token stop_;
  BakeReport report_;
  const std::unique_ptr<Progress> progress_;
  std::atomic<std::size_t> next_{0};
  std::atomic<bool> unavailable_{false};
  std::mutex mutex_;
  RunFigures figures_;
  std::map<FileIdentity, std::string> named_;  ///< by the meshes that were read so far
};

}  // namespace

RunFigures run_bake(const BakePlan& plan, Baker& baker, const RunOptions& options,
                    const std::stop_token& stop) {
  return Run(plan, baker, options, stop)();
}

bool is_sound(const AnswerSummary& summary) {
  const Certificate& certificate = summary.certificate;
  if (certificate.open_edges != 0) return false;
  if (!summary.partition) return true;
  // Whoever counts these has judged the volumes too, by bounds that need more than the certificate says.
  if (summary.judged) return certificate.unmirrored_caps == 0;
  return certificate.relative_error <= kMaxRelativeError;
}

}  // namespace fracture::bake
