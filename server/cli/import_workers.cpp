#include "server/cli/import_workers.hpp"

#include <spdlog/spdlog.h>

#include <stdexcept>
#include <system_error>
#include <utility>

namespace fracture::cli {

namespace {

/// A worker that keeps more than this after an import is replaced: it counts as 16 MiB (memory_plan.cpp).
constexpr std::uint64_t kMaxAtRest = 32u << 20;

}  // namespace

std::shared_ptr<ImportPool> start_import_workers(int workers, std::uint64_t memory_bytes,
                                                 std::chrono::milliseconds deadline) {
  if (workers == 0) {
    spdlog::warn("--import-workers 0: files are read in this process, where a hostile one can end it");
    return nullptr;
  }
  ImportPoolConfig config;
  config.workers = workers;
  config.worker.program = import_worker_beside_this_program();
  if (config.worker.program.empty())
    throw std::runtime_error(
        "fracture-import is not beside fracture-server: install both, or read files in this process with "
        "--import-workers 0");
  config.worker.memory_bytes = memory_bytes;
  config.max_resident_bytes = kMaxAtRest;
  // The deadline, by the clock, is first to end an import; this is the second line.
  config.worker.cpu = std::chrono::ceil<std::chrono::seconds>(deadline) + std::chrono::seconds(1);
  auto pool = std::make_shared<ImportPool>(config);
  if (const WorkerHello hello = pool->hello(); hello.seccomp == 0)
    spdlog::warn(
        "import workers run without a seccomp filter, which this machine does not allow ({}); their limits "
        "and "
        "the other parts of the sandbox are in force",
        std::generic_category().message(hello.seccomp_errno));
  return pool;
}

void write_import_metrics(const ImportCounters& counters, ops::MetricWriter& writer) {
  const std::pair<const char*, std::uint64_t> outcomes[] = {{"imported", counters.imported},
                                                            {"refused", counters.refused},
                                                            {"crashed", counters.crashed},
                                                            {"limited", counters.limited},
                                                            {"interrupted", counters.interrupted}};
  for (const auto& [outcome, count] : outcomes)
    writer.counter(
        "fracture_imports_total",
        "Imports by their end: a mesh, an error of the file, the death of the worker, a limit of its "
        "sandbox, or given up.",
        static_cast<double>(count), {{"outcome", outcome}});
  writer.counter("fracture_import_workers_started_total", "Import processes started.",
                 static_cast<double>(counters.started));
  writer.counter("fracture_import_workers_recycled_total", "Import processes replaced in good health.",
                 static_cast<double>(counters.recycled));
  writer.gauge("fracture_import_workers", "Import processes alive.", counters.workers);
  writer.gauge("fracture_import_workers_busy", "Import processes at work.", counters.busy);
}

}  // namespace fracture::cli
