#include "common/gltf/collision_systems.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace fracture {

CollisionSystems collision_systems(const FragmentSet& set) {
  const std::size_t fragments = set.fragments.size();
  std::vector<std::pair<std::uint32_t, std::uint32_t>> owners;  // of sites
  for (std::uint32_t k = 0; k < fragments; ++k)
    for (const std::uint32_t site : set.fragments[k].sites) owners.emplace_back(site, k);
  std::sort(owners.begin(), owners.end());

  // Union-find whose roots are the lowest fragments.
  std::vector<std::uint32_t> parent(fragments);
  std::iota(parent.begin(), parent.end(), 0u);
  const auto root = [&](std::uint32_t k) {
    while (parent[k] != k) k = parent[k] = parent[parent[k]];
    return k;
  };
  std::vector<bool> shares(fragments, false);
  for (std::size_t k = 1; k < owners.size(); ++k) {
    if (owners[k].first != owners[k - 1].first || owners[k].second == owners[k - 1].second) continue;
    const std::uint32_t a = root(owners[k - 1].second), b = root(owners[k].second);
    parent[std::max(a, b)] = std::min(a, b);
    shares[owners[k].second] = shares[owners[k - 1].second] = true;
  }

  CollisionSystems systems;
  systems.of_fragment.assign(fragments, kNoIndex);
  for (std::uint32_t k = 0; k < fragments; ++k) {
    if (!shares[k]) continue;
    const std::uint32_t first = root(k);
    systems.of_fragment[k] =
        first == k ? static_cast<std::uint32_t>(systems.count++) : systems.of_fragment[first];
  }
  return systems;
}

}  // namespace fracture
