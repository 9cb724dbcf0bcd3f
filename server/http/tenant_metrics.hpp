// Usage by name, for /metrics.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "server/ops/metrics.hpp"
#include "server/tenants/accounts.hpp"

namespace fracture::http {

/// So many names have figures of their own; what the others used is summed under this, which no name can be:
/// names have no spaces.
inline constexpr std::size_t kNamesInMetrics = 100;
inline constexpr const char* kOtherNames = "all others";

/// Bytes that a name holds: of stored meshes, of answers that it can fetch again.
struct Holdings {
  std::uint64_t stored = 0, cached = 0;
};

/// Nothing without tokens.
void write_tenant_metrics(const tenants::Accounts& accounts,
                          const std::function<Holdings(const std::string& name)>& holdings,
                          ops::MetricWriter& writer);

}  // namespace fracture::http
