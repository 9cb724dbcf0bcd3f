#include "server/cli/import_workers.hpp"

#include <spdlog/spdlog.h>

#include <system_error>
#include <utility>

namespace fracture::cli {

std::shared_ptr<ImportPool> start_import_workers(const ServeOptions& options) {
  ImportPoolConfig config;
  config.workers = options.import_workers;
  config.worker.program = import_worker_beside_this_program();
  config.worker.memory_bytes = options.import_memory;
  config.worker.require_sandbox = options.sandbox_required;
  // Limit on CPU time, in case the deadline fails to end an import. The deadline (wall-clock time) normally
  // comes first.
  config.worker.cpu =
      std::chrono::ceil<std::chrono::seconds>(options.limits.deadline) + std::chrono::seconds(1);
  auto pool = std::make_shared<ImportPool>(config);
  if (const WorkerHello hello = pool->hello(); hello.seccomp == 0)
    spdlog::warn(
        "import workers run without a seccomp filter, because this machine does not allow one ({}); their "
        "limits and the other parts of the sandbox are in force",
        std::generic_category().message(hello.seccomp_errno));
  return pool;
}

void write_import_metrics(const ImportPool& imports, ops::MetricWriter& writer) {
  const std::pair<const char*, bool> layers[] = {{"seccomp", imports.hello().seccomp != 0},
                                                 {"landlock", imports.zygote_hello().landlock != 0}};
  for (const auto& [layer, in_force] : layers)
    writer.gauge(
        "fracture_import_sandbox",
        "1 if this layer of the import processes' sandbox is in force. seccomp is the main layer; Landlock is a "
        "second one, for files.",
        in_force, {{"layer", layer}});
  const ImportCounters counters = imports.counters();
  const std::pair<const char*, std::uint64_t> outcomes[] = {
      {"imported", counters.imported},     {"refused", counters.refused},
      {"crashed", counters.crashed},       {"limited", counters.limited},
      {"remembered", counters.remembered}, {"interrupted", counters.interrupted},
      {"no-room", counters.no_room}};
  for (const auto& [outcome, count] : outcomes)
    writer.counter(
        "fracture_imports_total",
        "Imports by outcome: imported, refused (an error in the file), crashed, limited (by the sandbox), interrupted, remembered "
        "(refused without reading, because the same file failed before), no-room (no reader could start).",
        static_cast<double>(count), {{"outcome", outcome}});
  writer.counter("fracture_import_workers_started_total", "Import processes forked, one per file.",
                 static_cast<double>(counters.started));
  writer.counter("fracture_import_zygotes_started_total",
                 "Zygote processes started. Each of them forks import processes.",
                 static_cast<double>(counters.zygotes));
  writer.gauge("fracture_import_workers", "Live import processes.", counters.workers);
  writer.gauge("fracture_import_workers_busy", "Import processes that are reading a file.", counters.busy);
}

}  // namespace fracture::cli
