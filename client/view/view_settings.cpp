#include "client/view/view_settings.hpp"

#include <algorithm>

namespace fracture::view {

render::RenderSettings render_settings(const scenes::Scene& scene, const ViewSettings& settings) {
  render::RenderSettings how;
  how.ground = render::Ground::kGrid;
  how.ground_height = 0.f;
  how.ground_color = {0.30f, 0.31f, 0.32f};
  how.background_top = {0.20f, 0.33f, 0.52f};
  how.background_bottom = {0.66f, 0.72f, 0.78f};
  how.lit = scene.bounds;
  how.lighting.sky_shadows = settings.sky_shadows;
  how.lighting.sun_shadow = settings.sun_shadow;
  how.wireframe = settings.debug == DebugView::kWireframe;
  how.highlight =
      settings.debug == DebugView::kInterior ? render::Highlight::kInterior : render::Highlight::kNone;
  how.tier = settings.tier;
  if (settings.tier == render::Tier::kLow) return how;
  // A sunny day: warm light, blue shadows, and a ground of light stone.
  constexpr int kLeastDirections = 24;  // without noise, fewer would be visible one by one
  if (settings.sky_shadows > 0) how.lighting.sky_shadows = std::max(kLeastDirections, settings.sky_shadows);
  how.lighting.sun = {3.5f, 3.15f, 2.6f};
  how.lighting.sky = {0.40f, 0.50f, 0.68f};
  how.lighting.ground = {0.27f, 0.25f, 0.22f};
  how.ground_color = {0.31f, 0.295f, 0.27f};
  return how;
}

}  // namespace fracture::view
