// Checks whether a fragment is closed, from the data in the file: final positions, indices and topology.
#pragma once

#include <cstdint>

#include "common/base/execution.hpp"
#include "common/fragment/fragments.hpp"

namespace fracture {

struct Closedness {
  std::uint64_t open_edges = 0;     ///< directed edges without an opposite
  std::uint64_t pinched_edges = 0;  ///< undirected edges used more than twice
};

/// Counts edges after welding equal positions, with a table of all edges. Throws Interrupted.
Closedness closedness(const Fragment& fragment, const Execution& execution = kUninterrupted);

/// Returns 0 if every edge of Fragment::topology is used exactly once in each direction and every vertex is
/// at the position of its topological vertex. Then the fragment is also closed after welding equal
/// positions.
/// Otherwise, if edges have no opposite or vertices are elsewhere, returns the largest of three numbers:
/// open edges in the topology, open edges after welding, and vertices that are elsewhere. If every edge has
/// an opposite, returns the number of repeated uses of edges in one direction, plus the number of triangles
/// with two corners at one vertex.
/// Fast enough for every result: the hashes of all directed edges, forwards minus backwards, sum to zero if
/// all edges are paired (and by chance with probability 2^-64). The table of edges is built only if the sum
/// is not zero. Throws Interrupted.
std::uint64_t open_edges(const Fragment& fragment, const Execution& execution = kUninterrupted);

}  // namespace fracture
