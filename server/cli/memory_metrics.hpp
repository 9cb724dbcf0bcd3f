// What memory was divided into, what of it is taken, and what is resident, side by side.
#pragma once

#include "server/cli/options.hpp"
#include "server/http/api.hpp"
#include "server/import_worker/import_pool.hpp"
#include "server/ops/metrics.hpp"

namespace fracture::cli {

void write_memory_metrics(const ServeOptions& options, http::Api& api, Dispatcher& dispatcher,
                          const ImportPool& imports, std::size_t connections, ops::MetricWriter& writer);

/// Resident bytes of a process; 0 where /proc does not tell.
std::uint64_t resident_bytes(pid_t process);

}  // namespace fracture::cli
