// Divides a bond graph into a given number of compact, connected clusters.
//
// Seeds come from recursive coordinate bisection (Berger & Bokhari 1987: halve the volume across the
// longest axis). Then regions grow over the bonds from the seeds; nodes near the cluster's centre and
// strongly bound nodes come first. The centres are moved to the regions' centroids a few times (Lloyd 1982
// on a graph). Every cluster is connected, because it grows over bonds. The number of clusters is the
// number of seeds.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/execution.hpp"
#include "common/structure/bond_graph.hpp"

namespace fracture {

/// Returns the cluster of each node; clusters are numbered by their lowest node. There are min(count,
/// nodes) clusters. Each is connected, unless the graph has more components than `count`; in that case,
/// whole components are combined by their position. `count` >= 1. Depends only on the graph; near-linear.
/// Throws Interrupted.
std::vector<std::uint32_t> find_clusters(const BondGraph& graph, std::uint32_t count,
                                         const Execution& execution);

}  // namespace fracture
