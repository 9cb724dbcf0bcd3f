#include "server/bake/run.hpp"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <memory>
#include <mutex>
#include <new>
#include <optional>
#include <set>
#include <thread>
#include <utility>
#include <vector>

#include "common/base/atomic_file.hpp"
#include "common/base/printable.hpp"
#include "common/gltf/report_text.hpp"
#include "common/mesh/dropped.hpp"
#include "server/bake/depfile.hpp"
#include "server/bake/explain.hpp"
#include "server/bake/failure.hpp"
#include "server/bake/files_to_make.hpp"
#include "server/bake/html_report.hpp"
#include "server/bake/input_file.hpp"
#include "server/bake/manifest.hpp"
#include "server/bake/named_files.hpp"
#include "server/bake/output_files.hpp"
#include "server/bake/output_folders.hpp"
#include "server/bake/progress.hpp"
#include "server/bake/report.hpp"
#include "server/bake/sentences.hpp"
#include "server/bake/soundness.hpp"

namespace fracture::bake {
namespace {

using nlohmann::json;

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
        tally_(plan.rules),
        progress_(progress_of(plan, options.quiet)) {
    baker_.on_notice([this](const std::string& line) { say(line); });
  }
  ~Run() {
    baker_.on_notice([](const std::string&) {});
  }

  RunFigures operator()() {
    warn_of_inputs();
    figures_.begun = can_write();
    if (!figures_.begun) return figures_;
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
    // After a stop, the lines stay as they are, and the next run continues from them.
    if (figures_.cancelled == 0 && !report_.finish(outputs)) unwritable(options_.report);
    write_page();
    warn_of_rules();
    progress_->finish();
    return figures_;
  }

 private:
  /// Names the lines of a manifest whose input is missing. Their jobs are tried and reported all the same.
  void warn_of_inputs() {
    LineFaults faults(plan_.manifest);
    check_inputs(plan_.jobs, faults);
    if (!faults.empty()) say(faults.error().detail);
  }

  /// Checks that all files can be written, except those of earlier runs, which may be kept.
  bool can_write() {
    if (const int trouble = report_.trouble()) {
      errno = trouble;
      unwritable(options_.report);
    }
    std::set<std::string> said;
    for (const std::string& path : files_to_make(
             plan_, options_, [&](const BakeJob& job) { return report_.find(job.output) != nullptr; })) {
      const std::optional<std::string> fault = folders_.fault_of(path);
      if (!fault) continue;
      count(&RunFigures::unwritable);
      if (said.insert(*fault).second) say(cannot_write(path) + ": " + *fault);
    }
    return figures_.unwritable == 0;
  }

  /// Writes the page, even for a run that was stopped, which then shows how far it came.
  void write_page() {
    if (plan_.html.empty()) return;
    if (const std::optional<Error> loss = named_.loss_of(plan_.html)) {
      say("cannot write " + plan_.html + ": " + loss->detail);
      return count(&RunFigures::unwritable);
    }
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begun_;
    const std::string page = html_report({.title = options_.title,
                                          .jobs = plan_.jobs.size(),
                                          .kept = figures_.kept,
                                          .seconds = took.count(),
                                          .stopped = figures_.cancelled > 0,
                                          .no_pictures = options_.no_pictures,
                                          .path = plan_.html},
                                         report_.lines());
    if (!make_folders_of(plan_.html) || !write_atomically(plan_.html, std::as_bytes(std::span(page))))
      unwritable(plan_.html);
  }

  /// Adds the picture of an output to its report line. If drawing fails, there is only a warning.
  void show(const BakeJob& job, json& line, bool fresh, std::span<const std::byte> bytes) {
    if (!options_.previews || job.picture.empty()) return;
    line.erase("preview");
    json preview;
    if (const std::optional<Error> loss = named_.loss_of(job.picture))
      preview = {{"file", job.picture}, {"warning", "The file is not overwritten: " + loss->detail + "."}};
    else
      preview = options_.previews->of(job.output, job.picture, fresh, bytes, stop_);
    if (preview.is_null()) return;
    if (const auto warning = preview.find("warning"); warning != preview.end())
      say(name_of_output(job.output) + ": warning: no picture: " + warning->get<std::string>());
    line["preview"] = std::move(preview);
  }

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

  /// Reads the reason from errno.
  void unwritable(const std::string& path) {
    say(cannot_write(path) + ": " + std::strerror(errno));
    count(&RunFigures::unwritable);
  }

  void unwritable(std::size_t job, const std::string& reason) {
    say(cannot_write(plan_.jobs[job].output) + ": " + reason);
    report(job, {{"status", "unwritable"}, {"problem", {{"detail", reason}}}});
    count(&RunFigures::unwritable);
    progress_->done(false, false);
  }

  void unreadable(std::size_t job, const std::string& reason) {
    tally_.add_unread(plan_.jobs[job].input);
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

  /// Keeps the failing request so that the bug can be investigated.
  void keep_failure(std::size_t job, const FractureRequest& request, const Error& error) {
    if (!options_.failures || !FailureKeeper::concerns(error.code)) return;
    const std::string& input = plan_.jobs[job].input;
    options_.failures->keep(
        request, {error.code, error.detail}, certificate_of(error),
        input == kStandardStream ? std::string() : std::filesystem::path(input).filename().string());
  }

  /// Does one job. An unexpected exception fails this job only, not the whole bake.
  void work(std::size_t number) {
    try {
      make_or_keep(number);
    } catch (const std::exception&) {
      fail(number, error_of_exception());
    }
  }

  /// Converts the exception that is being handled to an Error.
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
    std::optional<std::string> bytes = read_bytes(job.input, stop_);
    if (!bytes) return errno == ECANCELED ? cancelled() : unreadable(number, std::strerror(errno));
    const Expected<std::vector<RawParameter>> given = given_for(job, *bytes);
    if (!given) return fail(number, given.error());
    const Expected<RequestParameters> parameters = baker_.parse(*given);
    if (!parameters) return fail(number, parameters.error());
    const Expected<InputFile> input = to_input(job.input, std::move(*bytes), *parameters);
    if (!input) return fail(number, input.error());
    const Expected<OutputKind> kind = kind_of_output(job.output);
    if (!kind) return fail(number, kind.error());
    const FractureRequest request{input->view(), input->format, *parameters, as_import_files(input->siblings),
                                  answer_format(*kind)};
    const RequestKeys keys = keys_of(request);
    named_.add(*input, job);
    if (const KnownOutput* known = options_.force ? nullptr : report_.find(job.output);
        known && known->key == keys.result && is_right(*known, job.output)) {
      if (!write_depfile_of(number, *input)) return;
      json line = known->line;
      show(job, line, false, {});
      report(number, std::move(line));
      count(&RunFigures::kept);
      conclude(name_of_output(job.output) + ": up to date, kept");
      return progress_->done(true, false);
    }
    if (const std::optional<Error> loss = named_.loss_by(job, options_.depfile))
      return unwritable(number, loss->detail);
    if (const std::optional<std::string> fault = folders_.fault_of(job.output))
      return unwritable(number, *fault);
    make(number, *kind, request, keys, *input);
  }

  Expected<std::vector<RawParameter>> given_for(const BakeJob& job, const std::string& bytes) {
    if (plan_.rules.rules.empty()) return job.parameters;
    Expected<MeshNames> names = MeshNames{};
    if (plan_.rules.by_names())
      names = names_in(job.input, std::as_bytes(std::span(bytes)), format_given(job));
    if (!names) {
      tally_.add_unread(job.input);
      return tl::unexpected(names.error());
    }
    Expected<std::vector<RuleMatch>> matches = tally_.find(job.input, *names, stop_);
    if (!matches) return tl::unexpected(matches.error());
    return parameters_of(job, plan_.rules, std::move(*matches)).all;
  }

  /// Writes the depfile of a kept output, which may be missing. Returns false after reporting a failure.
  bool write_depfile_of(std::size_t number, const InputFile& input) {
    if (options_.depfile.empty()) return true;
    const BakeJob& job = plan_.jobs[number];
    if (const std::optional<Error> loss = named_.loss_by(job, options_.depfile)) {
      unwritable(number, loss->detail);
      return false;
    }
    if (!write_depfile(options_.depfile, job, input, plan_.rules.path)) unwritable(options_.depfile);
    return true;
  }

  /// Warns about rules that match no mesh. Skipped if there are other shards, whose meshes are unknown here.
  void warn_of_rules() {
    if (figures_.cancelled > 0 || plan_.jobs.size() < plan_.all) return;
    for (const std::string& warning : tally_.warnings()) say("warning: " + warning);
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

  void make(std::size_t number, OutputKind kind, const FractureRequest& request, const RequestKeys& keys,
            const InputFile& input) {
    const BakeJob& job = plan_.jobs[number];
    const auto start = std::chrono::steady_clock::now();
    const Expected<Baked> baked = bake(request);
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
    if (!baked) {
      keep_failure(number, request, baked.error());
      return fail(number, baked.error());
    }
    if (const std::optional<Error> loss = named_.loss_by(job, options_.depfile))
      return unwritable(number, loss->detail);
    const Expected<std::vector<WrittenFile>> written = write_answer(
        job.output, kind, *baked->file, baked->digest, request.format,
        [this](const std::string& path) { return named_.loss_of(path); }, stop_);
    if (!written && written.error().code == ErrorCode::kFileAccess)
      return unwritable(number, written.error().detail);
    if (!written) return fail(number, written.error());
    if (!options_.depfile.empty() && !write_depfile(options_.depfile, job, input, plan_.rules.path))
      unwritable(options_.depfile);
    const Remarks& remarks = baked->summary.remarks;
    const std::string mesh = name_of_input(job.input);
    for (const std::string& warning : remarks.warnings) say(mesh + ": warning: " + warning);
    if (!options_.quiet)
      for (const std::string& note : remarks.notes) say(mesh + ": note: " + note);
    const std::vector<Dropped>& dropped = baked->summary.dropped;
    if (!options_.quiet)
      for (const Dropped& entry : dropped) say(mesh + ": dropped: " + to_text(entry));
    json line = {{"status", "made"},
                 {"key", keys.result},
                 {"mesh", "sha256:" + keys.digest},
                 {"digest", "sha256:" + written->front().digest.hex()},
                 {"bytes", written->front().bytes},
                 {"seconds", took.count()},
                 {"certificate", certificate_document(baked->summary.certificate)}};
    if (!remarks.warnings.empty()) line["warnings"] = remarks.warnings;
    if (!remarks.notes.empty()) line["notes"] = remarks.notes;
    if (!dropped.empty()) line["dropped"] = dropped_document(dropped);
    for (const WrittenFile& file : std::span(*written).subspan(1))
      line["beside"].push_back(
          {{"path", file.path}, {"digest", "sha256:" + file.digest.hex()}, {"bytes", file.bytes}});
    show(job, line, true, std::as_bytes(std::span(*baked->file)));
    report(number, std::move(line));
    conclude(sentence_of(*written, *baked, took.count()));
    count(&RunFigures::made);
    progress_->done(false, false);
  }

  const BakePlan& plan_;
  Baker& baker_;
  const RunOptions& options_;
  const std::stop_token stop_;
  BakeReport report_;
  OutputFolders folders_;
  RuleTally tally_;
  const std::unique_ptr<Progress> progress_;
  const std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
  std::atomic<std::size_t> next_{0};
  std::atomic<bool> unavailable_{false};
  std::mutex mutex_;
  RunFigures figures_;
  NamedFiles named_;  ///< by the meshes read so far
};

}  // namespace

RunFigures run_bake(const BakePlan& plan, Baker& baker, const RunOptions& options,
                    const std::stop_token& stop) {
  return Run(plan, baker, options, stop)();
}

}  // namespace fracture::bake
