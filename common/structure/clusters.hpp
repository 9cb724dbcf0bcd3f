// A bond graph divided into a given number of compact, connected clusters.
//
// Seeds by recursive coordinate bisection (Berger & Bokhari 1987: halve the volume across the longest axis),
// then regions grown over the bonds from the seeds, nearest to the cluster's centre first and strongly bound
// before weakly bound, with the centres moved to the regions' centroids a few times (Lloyd 1982 on a graph).
// Growing over bonds keeps every cluster connected; the number of seeds keeps their number.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/execution.hpp"
#include "common/structure/bond_graph.hpp"

namespace fracture {

/// Per node the cluster it is in; clusters are numbered by their lowest node. min(count, nodes) clusters;
/// each is connected, unless the graph has more components than `count`: then whole components are put
/// together by where they lie. `count` >= 1. A function of the graph alone; near-linear. Throws
/// Interrupted.
std::vector<std::uint32_t> find_clusters(const BondGraph& graph, std::uint32_t count,
                                         const Execution& execution);

}  // namespace fracture
