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
  // The deadline, by the clock, is first to end an import; this is the second line.
  config.worker.cpu =
      std::chrono::ceil<std::chrono::seconds>(options.limits.deadline) + std::chrono::seconds(1);
  auto pool = std::make_shared<ImportPool>(config);
  if (const WorkerHello hello = pool->hello(); hello.seccomp == 0)
    spdlog::warn(
        "import workers run without a seccomp filter, which this machine does not allow ({}); their limits "
        "and the other parts of the sandbox are in force",
        std::generic_category().message(hello.seccomp_errno));
  return pool;
}

void write_import_metrics(const ImportPool& imports, ops::MetricWriter& writer) {
  const std::pair<const char*, bool> layers[] = {{"seccomp", imports.hello().seccomp != 0},
                                                 {"landlock", imports.zygote_hello().landlock != 0}};
  for (const auto& [layer, in_force] : layers)
    writer.gauge(
        "fracture_import_sandbox",
        "1 where files are read in processes behind this layer of the sandbox. Without seccomp there "
        "is none to speak of; Landlock is a second one, for files.",
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
        "Imports by their end: a mesh, an error of the file, the death of the worker, a limit of its "
        "sandbox, given up, refused for one of these as the file is remembered, or no room for a reader.",
        static_cast<double>(count), {{"outcome", outcome}});
  writer.counter("fracture_import_workers_started_total", "Import processes forked, one for each file.",
                 static_cast<double>(counters.started));
  writer.counter("fracture_import_zygotes_started_total",
                 "Processes started to fork the import processes from.",
                 static_cast<double>(counters.zygotes));
  writer.gauge("fracture_import_workers", "Import processes alive.", counters.workers);
  writer.gauge("fracture_import_workers_busy", "Import processes at work.", counters.busy);
}

}  // namespace fracture::cli
