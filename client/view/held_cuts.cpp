#include "client/view/held_cuts.hpp"

#include <algorithm>
#include <set>

namespace fracture::view {

std::vector<bool> in_whole_groups(const world::FragmentSet& set,
                                  const std::vector<world::FragmentState>& fragments,
                                  const std::vector<float>& loads) {
  std::vector<bool> bonded(set.fragments.size(), false), loose(set.fragments.size(), false);
  for (std::size_t k = 0; k < set.bonds.size(); ++k) {
    const world::Bond& bond = set.bonds[k];
    if (bond.gone) continue;
    const world::FragmentState &a = fragments[bond.a], &b = fragments[bond.b];
    const bool holds = loads[k] >= 0 && a.present && b.present && a.group == b.group;
    for (const std::uint32_t f : {bond.a, bond.b}) {
      bonded[f] = true;
      if (!holds) loose[f] = true;
    }
  }
  // If one fragment has come off, the whole connected group counts as cracked.
  std::set<std::uint32_t> cracked;
  for (std::size_t f = 0; f < loose.size(); ++f)
    if (loose[f]) cracked.insert(fragments[f].group);
  for (std::size_t f = 0; f < bonded.size(); ++f)
    bonded[f] = bonded[f] && !cracked.contains(fragments[f].group);
  return bonded;
}

void hide_held_cuts(const scenes::SceneObject& object, const game::Moment::Part& part,
                    const game::Decoded::Layer& layer, std::span<std::uint8_t> uncut) {
  if (object.look != render::SolidLook::kGlass && object.look != render::SolidLook::kIce) return;
  std::fill(uncut.begin(), uncut.end(), std::uint8_t{0});
  const world::FragmentSet& set = world::fragments_of(*part.broken->fragments);
  if (part.loads.size() != set.bonds.size()) return;
  const std::vector<bool> held = in_whole_groups(set, part.fragments, part.loads);
  for (std::size_t k = 0; k < uncut.size(); ++k) {
    const std::uint32_t fragment = layer.fragment_of_object[k];
    uncut[k] = fragment != game::Decoded::kNoFragment && held[fragment];
  }
}

}  // namespace fracture::view
