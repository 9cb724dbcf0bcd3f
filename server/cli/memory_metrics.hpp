// Metrics that compare the memory budgets, the memory in use and the resident memory.
#pragma once

#include "server/cli/options.hpp"
#include "server/http/api.hpp"
#include "server/import_worker/import_pool.hpp"
#include "server/ops/metrics.hpp"

namespace fracture::cli {

void write_memory_metrics(const ServeOptions& options, http::Api& api, Dispatcher& dispatcher,
                          const ImportPool& imports, std::size_t connections, ops::MetricWriter& writer);

/// Returns the resident bytes of a process, or 0 if they cannot be read from /proc.
std::uint64_t resident_bytes(pid_t process);

}  // namespace fracture::cli
