// Is a fragment closed? Judged on what the file holds: final positions, equal ones welded.
#pragma once

#include <cstdint>

#include "common/base/execution.hpp"
#include "common/fragment/fragments.hpp"

namespace fracture {

struct Closedness {
  std::uint64_t open_edges = 0;     ///< directed edges without an opposite
  std::uint64_t pinched_edges = 0;  ///< undirected edges used more than twice
};

/// Counts, by a table of all edges. Throws Interrupted.
Closedness closedness(const Fragment& fragment, const Execution& execution = kUninterrupted);

/// The number of open edges alone, fast enough for every answer: the directed edges' hashes, forwards minus
/// backwards, sum to zero when all are paired (and by chance with probability 2^-64); only when they do not,
/// edges are counted. Throws Interrupted.
std::uint64_t open_edges(const Fragment& fragment, const Execution& execution = kUninterrupted);

}  // namespace fracture
