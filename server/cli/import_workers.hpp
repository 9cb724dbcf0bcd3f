// The import workers of a command.
#pragma once

#include <cstdint>
#include <memory>

#include "common/base/error.hpp"
#include "server/import_worker/import_pool.hpp"
#include "server/ops/metrics.hpp"

namespace fracture::cli {

/// For `serve`. Says in the log what of the sandbox this machine does not allow; null, with a warning, for 0
/// workers. Throws std::runtime_error where the workers cannot be started.
std::shared_ptr<ImportPool> start_import_workers(int workers, std::uint64_t memory_bytes,
                                                 std::chrono::milliseconds deadline);

void write_import_metrics(const ImportCounters& counters, ops::MetricWriter& writer);

/// For commands whose user owns the file: one worker without a limit on its memory, so that a crash of a
/// reader is an error message; null (imports run in this process) where fracture-import is not installed.
std::shared_ptr<ImportPool> one_import_worker();

}  // namespace fracture::cli
