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

/// 0 if every edge of Fragment::topology is used exactly once in each direction and every vertex is where its topological
/// vertex is: then the fragment is closed with equal positions welded, too. Else, if edges have no opposite, the larger
/// number of open edges of the two, at least the number of vertices that are elsewhere; if all have one, the number of
/// uses that are not the first of their edge and direction, and of triangles with two corners at one vertex. Fast enough
/// for every answer: the directed edges' hashes, forwards minus backwards, sum to zero when all are paired (and by chance
/// with probability 2^-64); only when they do not, edges are counted. Throws Interrupted.
std::uint64_t open_edges(const Fragment& fragment, const Execution& execution = kUninterrupted);

}  // namespace fracture
