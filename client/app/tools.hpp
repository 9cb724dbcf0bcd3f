// What a click in the window does.
#pragma once

#include <array>

#include "client/game/game.hpp"

namespace fracture::app {

enum class Tool { kBall, kWreckingBall, kExplosion };
inline constexpr std::array<const char*, 3> kToolActions = {"throws a ball", "throws a wrecking ball",
                                                            "explodes there"};

/// Throws from the eye in a direction of unit length, or lets what lies there explode. False: nothing lies there.
bool use_tool(Tool tool, game::Game& game, const glm::dvec3& eye, const glm::dvec3& direction);

}  // namespace fracture::app
