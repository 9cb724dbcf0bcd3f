// Clusters of clusters: a fractured object breaks into few large chunks first, and each of those into smaller
// ones. The finest level is the fragments themselves; a cluster is a set of them, so that every level is a
// partition of the solid and each cluster of a level lies in one cluster of the next coarser level.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/execution.hpp"
#include "common/fragment/fragments.hpp"

namespace fracture {

/// Fragments that a coarser level of the hierarchy keeps together.
struct Cluster {
  std::uint64_t id = 0;         ///< function of its fragments' ids only (at most 2^53 - 1)
  std::uint32_t parent = 0;     ///< index into the clusters of the next coarser level, or kNoIndex
  std::uint32_t fragments = 0;  ///< how many
  double volume = 0;            ///< m³
  double density_share = 1;     ///< Fragment::density_share, the mean by volume
  Vec3d center_of_mass;         ///< m
};
struct ClusterLevel {
  std::vector<Cluster> clusters;
  std::vector<Bond> bonds;  ///< between clusters: a and b are indices into `clusters`, otherwise as Bond says
};
/// A companion of a FragmentSet.
struct Hierarchy {
  std::vector<ClusterLevel> levels;  ///< coarsest first; the fragments are the level after the last
  std::vector<std::uint32_t> cluster_of_fragment;  ///< in levels.back(); empty without levels
};

/// `counts`: how many clusters each level shall have, coarsest first, increasing; without the finest level. A
/// level has fewer where there are fewer fragments. Built from the fragments upwards (clusters.hpp). Throws
/// Interrupted.
Hierarchy make_hierarchy(const FragmentSet& set, const std::vector<std::uint32_t>& counts,
                         const Execution& execution);

}  // namespace fracture
