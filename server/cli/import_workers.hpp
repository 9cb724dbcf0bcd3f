// The import workers of `serve`.
#pragma once

#include <memory>

#include "server/cli/options.hpp"
#include "server/import_worker/import_pool.hpp"
#include "server/ops/metrics.hpp"

namespace fracture::cli {

/// For `serve`. Says in the log what of the sandbox this machine does not allow. Throws std::runtime_error where
/// the workers cannot be started, or not in the sandbox that is required.
std::shared_ptr<ImportPool> start_import_workers(const ServeOptions& options);

void write_import_metrics(const ImportPool& imports, ops::MetricWriter& writer);

}  // namespace fracture::cli
