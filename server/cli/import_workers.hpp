// The import workers of `serve`.
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

}  // namespace fracture::cli
