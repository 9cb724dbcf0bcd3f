// Makes things break less finely while many bodies are moving.
#include <algorithm>
#include <iterator>

#include "client/world/state.hpp"
#include "common/base/disjoint_sets.hpp"

namespace fracture::world {

/// All moving bodies share the time for a step. If many move, things break into fewer, larger pieces, because
/// a heap hides its crumbs. Among the bonds that would break, the strongest hold until no part is smaller
/// than a minimum share of the object. The share grows with the number of moving bodies, so a collapse
/// creates bodies ever more slowly. (Kruskal's rule, "On the Shortest Spanning Subtree of a Graph", 1956:
/// takes the strongest bonds first, each if it joins a part that is too small.) These bonds may break later,
/// when there is time.
std::size_t World::State::hold_together(Object& object, std::span<const std::uint32_t> members,
                                        std::span<const std::uint32_t> before,
                                        std::vector<std::uint32_t>& bonds) const {
  constexpr double kShare = 0.03;  // of the object's volume, at the budget; in proportion beyond it
  if (live <= settings.live_bodies) return 0;
  const FragmentSet& set = object.fragments->set;
  const double least = kShare * static_cast<double>(live) /
                       std::max(1.0, static_cast<double>(settings.live_bodies)) * object.fragments->volume;
  DisjointSets parts(set.fragments.size());
  for (const std::uint32_t bond : bonds) parts.unite(set.bonds[bond].a, set.bonds[bond].b);
  std::vector<double> volume(set.fragments.size(), 0);
  for (const std::uint32_t m : members) volume[parts.find(m)] += set.fragments[m].volume;
  std::vector<std::uint32_t> broken, held;
  std::set_difference(before.begin(), before.end(), bonds.begin(), bonds.end(), std::back_inserter(broken));
  std::stable_sort(broken.begin(), broken.end(), [&](std::uint32_t a, std::uint32_t b) {
    return set.bonds[a].strength > set.bonds[b].strength;
  });
  for (const std::uint32_t bond : broken) {
    const std::uint32_t a = parts.find(set.bonds[bond].a), b = parts.find(set.bonds[bond].b);
    if (a == b || std::min(volume[a], volume[b]) >= least) continue;
    const double both = volume[a] + volume[b];
    parts.unite(a, b);
    volume[parts.find(a)] = both;
  }
  // Bonds inside a part are not cracked, because they could have held.
  for (const std::uint32_t bond : broken)
    if (parts.find(set.bonds[bond].a) == parts.find(set.bonds[bond].b)) {
      object.bond_load[bond] = 1;
      held.push_back(bond);
    }
  bonds.insert(bonds.end(), held.begin(), held.end());
  std::sort(bonds.begin(), bonds.end());
  return held.size();
}

}  // namespace fracture::world
