// Whole glass shows no faces inside: which cuts of clear fragments are not to be seen.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "client/game/moment.hpp"

namespace fracture::view {

/// For each fragment: has it bonds, and do all bonds of its group hold? `loads` as World::bond_states says; a bond between
/// fragments of different groups, or of one that is gone, does not hold.
std::vector<bool> in_whole_groups(const world::FragmentSet& set,
                                  const std::vector<world::FragmentState>& fragments,
                                  const std::vector<float>& loads);

/// Hides the cuts of a broken part's groups that have lost nothing, where it is of glass or ice and its loads are known. `uncut`: of the layer's objects, 1 where they are hidden.
void hide_held_cuts(const scenes::SceneObject& object, const game::Moment::Part& part,
                    const game::Decoded::Layer& layer, std::span<std::uint8_t> uncut);

}  // namespace fracture::view
