// Import workers of `serve`.
#pragma once

#include <memory>

#include "server/cli/options.hpp"
#include "server/import_worker/import_pool.hpp"
#include "server/ops/metrics.hpp"

namespace fracture::cli {

/// Starts the import workers for `serve` and logs which parts of the sandbox this machine does not allow.
/// Throws std::runtime_error if the workers cannot be started, or not with the required sandbox.
std::shared_ptr<ImportPool> start_import_workers(const ServeOptions& options);

void write_import_metrics(const ImportPool& imports, ops::MetricWriter& writer);

}  // namespace fracture::cli
