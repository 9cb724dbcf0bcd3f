// Usage by name, for /metrics.
#pragma once

#include "server/ops/metrics.hpp"
#include "server/tenants/accounts.hpp"

namespace fracture::http {

/// So many names have figures of their own; what the others used is summed under the name "other".
inline constexpr std::size_t kNamesInMetrics = 100;

/// Nothing without tokens.
void write_tenant_metrics(const tenants::Accounts& accounts, ops::MetricWriter& writer);

}  // namespace fracture::http
