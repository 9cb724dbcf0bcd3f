// Divides the server's memory among its budgets. Every budget is a setting; budgets that are not given are
// reduced until everything fits.
//
//   memory (--memory, else memory.max of the control group, else the machine's)
//     = base: the process, its threads, its import workers at rest
//     + 1.3 times the sum of the budgets, for allocator overhead and errors of estimates
#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "server/cli/options.hpp"

namespace fracture::cli {

struct MemoryShare {
  const char* setting;  ///< its name
  const char* part;     ///< its label in /metrics
  std::uint64_t bytes;
};
/// Returns all budgets with their current values.
std::vector<MemoryShare> memory_shares(const ServeOptions& options);

/// Returns the resident bytes of an idle server with these numbers of threads and import workers.
std::uint64_t base_memory(const ServeOptions& options);

/// Maximum number of resident bytes per byte of budget.
inline constexpr double kResidentPerByte = 1.3;

/// Lowers the budgets that are not in `given` (names of settings), in proportion, until everything fits into
/// `available` bytes, then lowers the limits of single requests to match. Sets options.memory to `available`.
/// If the given budgets do not fit, changes nothing and returns an error that spells out the sum.
std::vector<std::string> plan_memory(ServeOptions& options, const std::set<std::string>& given,
                                     std::uint64_t available);

}  // namespace fracture::cli
