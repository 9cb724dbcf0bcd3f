#include "common/gltf/collision_systems.hpp"

#include <utility>

#include "common/base/disjoint_sets.hpp"
#include "common/base/pacer.hpp"

namespace fracture {

CollisionSystems collision_systems(const FragmentSet& set, const Execution& execution) {
  Pacer pacer(execution);
  const std::size_t fragments = set.fragments.size();
  std::vector<std::pair<std::uint32_t, std::uint32_t>> owners;  // of sites
  for (std::uint32_t k = 0; k < fragments; ++k)
    for (const std::uint32_t site : set.fragments[k].sites) owners.emplace_back(site, k);
  sort_with_polls(execution, owners.begin(), owners.end());

  DisjointSets sets(fragments);  // roots are the lowest fragments
  std::vector<bool> shares(fragments, false);
  for (std::size_t k = 1; k < owners.size(); ++k) {
    pacer.step();
    if (owners[k].first != owners[k - 1].first || owners[k].second == owners[k - 1].second) continue;
    sets.unite(owners[k - 1].second, owners[k].second);
    shares[owners[k].second] = shares[owners[k - 1].second] = true;
  }

  CollisionSystems systems;
  systems.of_fragment.assign(fragments, kNoIndex);
  for (std::uint32_t k = 0; k < fragments; ++k) {
    if (!shares[k]) continue;
    const std::uint32_t first = sets.find(k);
    systems.of_fragment[k] =
        first == k ? static_cast<std::uint32_t>(systems.count++) : systems.of_fragment[first];
  }
  return systems;
}

}  // namespace fracture
