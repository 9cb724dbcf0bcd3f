// The panel that F1 opens (Dear ImGui): server, frames, bodies, view, and every parameter of the next fracture.
#pragma once

#include <array>
#include <functional>
#include <string>

#include "client/app/parameter_controls.hpp"
#include "client/app/snapshot.hpp"
#include "client/app/tools.hpp"
#include "client/protocol/client.hpp"
#include "client/scenes/scene.hpp"
#include "client/view/scene_view.hpp"

namespace fracture::app {

struct PanelState {
  bool help = false, panel = false, menu = false;
  Tool tool = Tool::kBall;
  bool gravity_held = false, gravity_always = false, slow_motion = false;
  view::ViewSettings view;
  render::TierWish picture = render::TierWish::kAuto;
  view::ViewFigures figures;
  std::array<float, 240> frame_ms{};  ///< ring buffer: time until everything is submitted
  std::size_t next_frame = 0;
  double frames_per_second = 0;
  ParameterControls parameters;
  nlohmann::json given = nlohmann::json::object();  ///< parameters from the command line
  std::string note;  ///< the last message for the player; empty after some seconds
  bool loading = false;
  bool effects = true;
  bool sound = true, silent = false;  ///< whether sound is wanted; whether no device is available
  float volume = 0.8f;                ///< 0 … 1

  /// Parameters of the next fracture: those of the command line, overridden by those set in the panel.
  nlohmann::json overrides() const {
    nlohmann::json all = given;
    all.update(parameters.values());
    return all;
  }
};

/// The actions that the panel may request.
struct PanelActions {
  std::function<void(const std::string&)> load_scene, set_material;
  std::function<void()> reset, save_glb, set_overrides;
};

void draw_panel(PanelState& state, const scenes::Scene& scene, const Snapshot& now,
                const protocol::Client& client, const PanelActions& actions);

}  // namespace fracture::app
