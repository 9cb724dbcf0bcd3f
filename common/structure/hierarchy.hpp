// Clusters of clusters: a fractured object first breaks into few large chunks, and each chunk into smaller
// ones. The finest level consists of the fragments. A cluster is a set of fragments, so every level is a
// partition of the solid, and each cluster lies in one cluster of the next coarser level.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/execution.hpp"
#include "common/fragment/fragments.hpp"

namespace fracture {

/// Fragments that a coarser level of the hierarchy keeps together.
struct Cluster {
  std::uint64_t id = 0;         ///< depends only on its fragments' ids and its level (at most 2^53 - 1)
  std::uint32_t parent = 0;     ///< index into the clusters of the next coarser level, or kNoIndex
  std::uint32_t fragments = 0;  ///< number of fragments
  double volume = 0;            ///< m³
  double density_share = 1;     ///< mean of Fragment::density_share, weighted by volume
  Vec3d center_of_mass;         ///< m
};
struct ClusterLevel {
  std::vector<Cluster> clusters;
  std::vector<Bond> bonds;  ///< between clusters: a and b are indices into `clusters`; otherwise as in Bond
};
/// A companion of a FragmentSet.
struct Hierarchy {
  std::vector<ClusterLevel> levels;  ///< coarsest first; the fragments are the level after the last
  std::vector<std::uint32_t> cluster_of_fragment;  ///< index into levels.back().clusters; may be empty
};

/// Makes the hierarchy from the fragments upwards (clusters.hpp). `counts`: number of clusters in each
/// level, coarsest first, increasing, without the finest level. If there are fewer fragments, a level has
/// fewer clusters. Throws Interrupted.
Hierarchy make_hierarchy(const FragmentSet& set, const std::vector<std::uint32_t>& counts,
                         const Execution& execution);

}  // namespace fracture
