// Clusters of clusters: a fractured object breaks into few large chunks first, and each of those into smaller
// ones. The finest level is the fragments themselves; a cluster is a set of them, so that every level is a
// partition of the solid and each cluster of a level lies in one cluster of the next coarser level.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/execution.hpp"
#include "common/fragment/fragments.hpp"

namespace fracture {

/// `counts`: how many clusters each level shall have, coarsest first, increasing; without the finest level. A
/// level has fewer where there are fewer fragments. Built from the fragments upwards (clusters.hpp). Throws
/// Interrupted.
Hierarchy make_hierarchy(const FragmentSet& set, const std::vector<std::uint32_t>& counts,
                         const Execution& execution);

}  // namespace fracture
