// Is a fragment closed? Judged on what the file holds: final positions, indices and topology.
#pragma once

#include <cstdint>

#include "common/base/execution.hpp"
#include "common/fragment/fragments.hpp"

namespace fracture {

struct Closedness {
  std::uint64_t open_edges = 0;     ///< directed edges without an opposite
  std::uint64_t pinched_edges = 0;  ///< undirected edges used more than twice
};

/// Counts with equal positions welded, by a table of all edges. Throws Interrupted.
Closedness closedness(const Fragment& fragment, const Execution& execution = kUninterrupted);

/// 0 where every edge of Fragment::topology has its opposite and every vertex stands where its topological
/// vertex does: then the fragment is closed with equal positions welded, too. Else the larger number of open
/// edges of the two, at least the number of vertices that stand elsewhere. Fast enough for every answer: the
/// directed edges' hashes, forwards minus backwards, sum to zero when all are paired (and by chance with
/// probability 2^-64); only when they do not, edges are counted. Throws Interrupted.
std::uint64_t open_edges(const Fragment& fragment, const Execution& execution = kUninterrupted);

}  // namespace fracture
