// Finds the cut faces of clear fragments that must be hidden, because intact glass shows no faces inside.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "client/game/moment.hpp"

namespace fracture::view {

/// For each fragment: whether it has bonds and all bonds of its group hold. `loads`: from World::bond_states.
/// A bond does not hold if its fragments are in different groups or one is gone.
std::vector<bool> in_whole_groups(const world::FragmentSet& set,
                                  const std::vector<world::FragmentState>& fragments,
                                  const std::vector<float>& loads);

/// Hides the cut faces of intact groups in a broken part of glass or ice, if its loads are known. `uncut`:
/// one entry per object of the layer, 1 if its cut faces are hidden.
void hide_held_cuts(const scenes::SceneObject& object, const game::Moment::Part& part,
                    const game::Decoded::Layer& layer, std::span<std::uint8_t> uncut);

}  // namespace fracture::view
