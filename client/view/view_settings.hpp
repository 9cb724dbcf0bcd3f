// How a game is shown, and its lighting.
#pragma once

#include <array>

#include "client/effects/debris.hpp"
#include "client/game/moment.hpp"
#include "client/render/renderer.hpp"

namespace fracture::view {

enum class DebugView { kNone, kWireframe, kHulls, kBonds, kFragments, kInterior };
inline constexpr std::array<const char*, 6> kDebugViewNames = {
    "nothing", "wireframe", "collision hulls", "bonds by load", "groups", "cut faces"};

struct ViewSettings {
  DebugView debug = DebugView::kNone;
  int sky_shadows = 12;
  bool sun_shadow = true;
  render::Tier tier = render::Tier::kLow;   ///< debug views are always low
  const effects::Debris* debris = nullptr;  ///< dust, crumbs and marks; null: none
  /// Things that will break soon, to upload them ahead. Null: earlier uploads are kept.
  const std::vector<game::Game::Coming>* coming = nullptr;
};

/// Light, ground and sky of a picture of the scene.
render::RenderSettings render_settings(const scenes::Scene& scene, const ViewSettings& settings);

}  // namespace fracture::view
