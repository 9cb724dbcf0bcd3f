// Usage per name, for /metrics.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "server/ops/metrics.hpp"
#include "server/tenants/accounts.hpp"

namespace fracture::http {

/// Number of names with their own metrics. The usage of all others is summed under kOtherNames, which cannot
/// be a name because it contains a space.
inline constexpr std::size_t kNamesInMetrics = 100;
inline constexpr const char* kOtherNames = "all others";

/// Bytes that a name holds: in stored meshes, and in answers that it can fetch again.
struct Holdings {
  std::uint64_t stored = 0, cached = 0;
};

/// Writes the metrics; none without tokens.
void write_tenant_metrics(const tenants::Accounts& accounts,
                          const std::function<Holdings(const std::string& name)>& holdings,
                          ops::MetricWriter& writer);

}  // namespace fracture::http
