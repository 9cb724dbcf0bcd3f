#include "client/app/tools.hpp"

namespace fracture::app {

bool use_tool(Tool tool, game::Game& game, const glm::dvec3& eye, const glm::dvec3& direction) {
  if (tool == Tool::kExplosion) {
    constexpr double kFarthest = 200, kBefore = 0.1;  // metres: reach of the aim; distance before the surface
    const auto met = game.world().first_met(eye, eye + kFarthest * direction);
    if (!met) return false;
    game.explode({*met - kBefore * direction, scenes::kBlastImpulse, scenes::kBlastRadius});
    return true;
  }
  const scenes::Scene& scene = game.scene();
  const bool wrecks = tool == Tool::kWreckingBall;
  const double radius = wrecks ? scenes::kWreckingBall.radius : scene.ball_radius;
  game.throw_ball(eye + (radius + 0.3) * direction,
                  (wrecks ? scenes::kWreckingSpeed : scene.ball_speed) * direction,
                  wrecks ? scenes::kWreckingBall : scenes::Ball{});
  return true;
}

}  // namespace fracture::app
