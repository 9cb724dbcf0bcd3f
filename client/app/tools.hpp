// The effects of a click in the window.
#pragma once

#include <array>

#include "client/game/game.hpp"

namespace fracture::app {

enum class Tool { kBall, kWreckingBall, kExplosion };
inline constexpr std::array<const char*, 3> kToolActions = {"throws a ball", "throws a wrecking ball",
                                                            "explodes there"};

/// Throws a ball from the eye in a direction of unit length, or sets off an explosion at the first thing in
/// that direction. Returns false if there is none.
bool use_tool(Tool tool, game::Game& game, const glm::dvec3& eye, const glm::dvec3& direction);

}  // namespace fracture::app
