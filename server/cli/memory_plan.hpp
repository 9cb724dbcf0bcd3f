// How the memory that a server may have is divided among what holds it. Every budget is a setting; those that
// nobody gave are made to fit.
//
//   memory (--memory, else memory.max of the control group, else the machine's)
//     = base: the process, its threads, its import workers at rest
//     + 1.3 times the sum of the budgets: what an allocator keeps between blocks, and what estimates miss
#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "server/cli/options.hpp"

namespace fracture::cli {

/// One budget of the plan.
struct MemoryShare {
  const char* setting;  ///< its name
  const char* part;     ///< its label in /metrics
  std::uint64_t bytes;
};
/// As they are in force.
std::vector<MemoryShare> memory_shares(const ServeOptions& options);

/// What a server of so many threads and import workers has resident when it holds nothing.
std::uint64_t base_memory(const ServeOptions& options);

/// Of 1 byte of budget, what may be resident.
inline constexpr double kResidentPerByte = 1.3;

/// Lowers the budgets that are not among `given` (names of settings), in proportion, until everything fits
/// into `available` bytes; limits of single requests follow. Sets options.memory to `available`. Not empty:
/// what is given does not fit, with the sum spelled out; then nothing is changed.
std::vector<std::string> plan_memory(ServeOptions& options, const std::set<std::string>& given,
                                     std::uint64_t available);

}  // namespace fracture::cli
