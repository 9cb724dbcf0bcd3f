// What the window shows over the picture (Dear ImGui): panel, help, hints.
#pragma once

#include <array>
#include <functional>
#include <string>

#include "client/app/parameter_controls.hpp"
#include "client/game/game.hpp"
#include "client/view/scene_view.hpp"

namespace fracture::app {

struct PanelState {
  bool help = true, panel = true;
  bool gravity_held = false, gravity_always = false;
  view::ViewSettings view;
  view::ViewFigures figures;
  std::array<float, 240> frame_ms{};  ///< simulation and submission; a ring
  std::size_t next_frame = 0;
  double frames_per_second = 0;
  ParameterControls parameters;
  std::string note;  ///< the last thing that happened, for people
  bool loading = false;
};

/// What the panel may ask for.
struct PanelActions {
  std::function<void(const std::string&)> load_scene, set_material;
  std::function<void()> reset, save_glb;
};

void draw_panel(PanelState& state, game::Game& game, const protocol::Client& client,
                const PanelActions& actions);
void draw_help(const PanelState& state);
/// Numbers on the fragments, for the debug view of groups.
void draw_fragment_ids(const game::Game& game, const render::Camera& camera, int width, int height);

}  // namespace fracture::app
