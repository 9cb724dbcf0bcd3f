// fracture-server serve: starts, waits for a signal, and drains.
#include <pthread.h>
#include <signal.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <exception>
#include <system_error>

#include "common/allocator/allocator.hpp"
#include "server/cli/import_workers.hpp"
#include "server/cli/memory_metrics.hpp"
#include "server/cli/options.hpp"
#include "server/ops/log.hpp"
#include "server/ops/metrics.hpp"
#include "server/page/samples.hpp"

namespace fracture::cli {
namespace {

using std::chrono::steady_clock;

/// Waits for one of the signals, at most until `end`. Returns its number, or 0 on timeout.
int wait_for_signal(const sigset_t& signals, steady_clock::time_point end) {
  for (;;) {
    const auto left = std::chrono::duration_cast<std::chrono::nanoseconds>(end - steady_clock::now());
    if (left.count() <= 0) return 0;
    const timespec timeout{static_cast<time_t>(left.count() / 1'000'000'000), left.count() % 1'000'000'000};
    if (const int number = sigtimedwait(&signals, nullptr, &timeout); number > 0) return number;
    if (errno == EAGAIN) return 0;
  }
}

sigset_t handled_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGHUP);
  return signals;
}

/// Handles SIGHUP: reads the token file again. If the file is invalid, the old tokens stay in force.
void reload_tokens(const std::string& path, http::HttpServer& server) {
  if (path.empty()) return spdlog::info("SIGHUP: this server has no token file to reload");
  auto tokens = tenants::TokenFile::load(path);
  if (!tokens) {
    spdlog::error("--token-file {} The old tokens stay in force.", tokens.error().detail);
    return;
  }
  const std::size_t names = tokens->size();
  server.replace_tokens(std::move(*tokens));
  spdlog::info("token-file {} was reloaded: {} names", path, names);  // after the replacement
}

/// Gives free memory, such as that left by large meshes, back to the system: at once if it is more than a
/// tenth of the server's memory, else after it was unused for some seconds. Called a few times per second.
void trim_memory(std::uint64_t memory) {
  if (free_memory() > memory / 10)
    return_free_memory();
  else
    return_old_free_memory();
}

void tell_of_jobs(const http::Api& api) {
  if (const JobFigures jobs = api.jobs().figures(); jobs.jobs > 0)
    spdlog::info("found {} jobs from an earlier process, {} of them unfinished", jobs.jobs, jobs.unfinished);
}

/// Tries to take over the cache folder while another server holds it. Called a few times per second.
/// `trouble` is the reason of the last failure; each reason is logged once.
void take_folder(http::Api& api, const std::string& folder, std::string& trouble) {
  std::string why;
  try {
    const Expected<bool> taken = api.take_folder();
    if (taken && !*taken) return;
    if (taken) {
      spdlog::info("cache-dir {} was released by the other server; this server now uses it and is ready",
                   folder);
      return tell_of_jobs(api);
    }
    why = taken.error().detail;
  } catch (const std::exception& e) {  // not enough memory for the folder's contents
    why = e.what();
  }
  if (trouble != why) spdlog::error("--cache-dir: {}", why);
  trouble = why;
}

/// Serves until a signal arrives, then drains. Returns the exit code.
int serve_until_stopped(const ServeOptions& options) {
  const sigset_t signals = handled_signals();
  // Without a token file, SIGHUP stops a server that was started from a terminal, as usual when the terminal
  // closes.
  const bool terminal = ::isatty(STDERR_FILENO) != 0 && options.token_file.empty();
  sigset_t stopping = signals;  // a reload does not interrupt the waits below
  if (!terminal) sigdelset(&stopping, SIGHUP);
  const int threads = options.threads > 0 ? options.threads : available_cores();
  std::shared_ptr<ImportPool> imports;
  try {
    imports = start_import_workers(options);
  } catch (const std::exception& e) {
    spdlog::critical("{}", e.what());
    return kExitSystem;
  }
  page::Samples samples;
  if (!options.no_page) {
    Expected<page::Samples> read = page::Samples::load(options.page_samples);
    if (!read) {
      spdlog::critical("--page-sample: {}", read.error().detail);
      return kExitSystem;
    }
    samples = std::move(*read);
  }
  FractureService service(options.service, make_engine(imports));
  WorkerPool pool(threads, options.max_queue, {options.limits.realtime_deadline, options.limits.deadline});
  FailureKeeper failures({.folder = options.keep_failures, .program = "fracture-server " FRACTURE_VERSION},
                         [](const std::string& problem) { spdlog::warn("{}", problem); });
  DispatcherConfig config = options.dispatcher;
  if (failures.any()) config.failures = &failures;
  Dispatcher dispatcher(service, pool, config);
  http::Api api(dispatcher, options.limits, options.store, options.jobs);
  api.show_page(!options.no_page);
  api.offer(std::move(samples));
  for (const std::optional<Error>& unusable : {service.tiers().disk_unusable(), api.jobs().folder_unusable()})
    if (unusable) {
      spdlog::critical("--cache-dir: {}", unusable->detail);
      return kExitSystem;
    }
  if (const Expected<void> made = failures.make_folder(); !made) {
    spdlog::critical("--keep-failures: {}", made.error().detail);
    return kExitSystem;
  }
  if (api.waits_for_folder())
    spdlog::warn(
        "cache-dir {} is in use by another server: until that server ends, this one is not ready and answers "
        "requests without the folder",
        options.service.tiers.folder);
  else
    tell_of_jobs(api);
  api.metrics().add_source(ops::write_process_metrics);
  if (failures.any())
    api.metrics().add_source([&failures](ops::MetricWriter& writer) {
      const KeptFailures figures = failures.figures();
      writer.counter("fracture_failures_kept_total", "Failures saved so that they can be reproduced.",
                     static_cast<double>(figures.kept));
      writer.counter("fracture_failures_not_kept_total",
                     "Failures that were not saved because of an error or a lack of space.",
                     static_cast<double>(figures.dropped + figures.unwritten));
    });
  api.metrics().add_source([&imports](ops::MetricWriter& writer) { write_import_metrics(*imports, writer); });
  try {
    http::HttpServer server(options.server, api);  // the metrics below are only read through it
    api.metrics().add_source([&](ops::MetricWriter& writer) {
      write_memory_metrics(options, api, dispatcher, *imports, server.connections(), writer);
    });
    spdlog::info("serving on http://{}:{} (admin port {}), {} computing threads", options.server.address,
                 server.port(), server.admin_port(), pool.threads());

    std::string trouble;
    for (bool serving = true; serving;) {
      const int number = wait_for_signal(signals, steady_clock::now() + std::chrono::milliseconds(200));
      if (number == SIGHUP && !terminal)
        reload_tokens(options.token_file, server);
      else
        serving = number == 0;
      trim_memory(options.memory);
      if (serving && api.waits_for_folder()) take_folder(api, options.service.tiers.folder, trouble);
    }
    spdlog::info("draining: not ready; {} requests in progress", server.requests_in_progress());
    api.set_draining();
    wait_for_signal(stopping, steady_clock::now() + options.drain_delay);  // a second signal skips the delay
    server.stop_accepting();
    const steady_clock::time_point end = steady_clock::now() + options.grace;
    const auto jobs = [&api] {  // except those waiting on disk, for the next server
      const JobFigures figures = api.jobs().figures();
      return figures.unfinished - figures.waiting;
    };
    while (server.connections() + jobs() > 0 && steady_clock::now() < end)
      if (wait_for_signal(stopping, steady_clock::now() + std::chrono::milliseconds(10))) break;
    if (server.connections() + jobs() > 0) {
      const JobFigures figures = api.jobs().figures();
      spdlog::warn(
          "{} connections are still open and {} jobs unfinished: stopping their work; {} jobs are on disk "
          "and continue after a restart",
          server.connections(), figures.unfinished, figures.durable);
      server.cancel_jobs();
      const steady_clock::time_point last = steady_clock::now() + std::chrono::seconds(2);
      while (server.requests_in_progress() > 0 && steady_clock::now() < last)
        if (wait_for_signal(stopping, steady_clock::now() + std::chrono::milliseconds(10))) break;
    }
    // Wait until computed answers are stored in the tiers before the process ends.
    api.flush_jobs();
    service.tiers().flush(std::max(end, steady_clock::now() + std::chrono::seconds(1)));
  } catch (const std::system_error& e) {
    spdlog::critical("{}", e.what());
    return kExitSystem;
  }
  spdlog::info("stopped");
  return kExitDone;
}

}  // namespace

int serve(const ServeOptions& options) {
  // Blocked before any thread starts, so that every thread inherits it and only this one receives them.
  const sigset_t signals = handled_signals();
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  signal(SIGPIPE, SIG_IGN);
  signal(SIGXFSZ, SIG_IGN);  // exceeding a file size limit makes write() fail instead

  // Logs go to standard error, because standard output is for results.
  const bool text = options.log_format == "text" || (options.log_format == "auto" && ::isatty(STDERR_FILENO));
  ops::start_logging(text ? ops::LogFormat::kText : ops::LogFormat::kJson, options.log_level);
  for (const std::string& warning : options.warnings) spdlog::warn("{}", warning);
  ops::log_event("configuration", options.configuration);

  const int code = serve_until_stopped(options);
  constexpr std::chrono::milliseconds kPatience{1'000};
  if (!ops::stop_logging(kPatience)) std::_Exit(code);
  return code;
}

}  // namespace fracture::cli
