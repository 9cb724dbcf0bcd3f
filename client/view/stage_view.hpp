// A game's things as the renderer takes them: uploads what is new, carries transforms over, draws.
#pragma once

#include <map>

#include "client/game/game.hpp"
#include "client/render/renderer.hpp"
#include "client/view/debug_lines.hpp"

namespace fracture::view {

enum class DebugView { kNone, kWireframe, kHulls, kBonds, kFragments, kInterior };
inline constexpr std::array<const char*, 6> kDebugViewNames = {
    "nothing", "wireframe", "collision hulls", "bonds by load", "groups", "cut faces"};

struct ViewSettings {
  DebugView debug = DebugView::kNone;
  int sky_shadows = 12;
  bool sun_shadow = true;
};

struct ViewFigures {
  std::size_t draw_calls = 0, culled = 0, uploads = 0;
  double submit_ms = 0;  ///< processor time from the first to the last call of a frame
};

class StageView {
 public:
  static render::Result<StageView> create();

  /// Forgets everything that was uploaded: another stage, or the same anew.
  void reset() {
    items_.clear();
    furnished_ = nullptr;
  }
  /// Draws the game into the framebuffer. kGl where the driver refuses a mesh; the rest is drawn.
  render::Result<ViewFigures> draw(const game::Game& game, const render::Camera& camera,
                                   const ViewSettings& settings, GLuint framebuffer, int width, int height);

 private:
  struct Item {
    render::GpuScene gpu;
    std::vector<render::ObjectState> states;
    bool broken = false;
    render::Sphere look_frame;  ///< of the whole object, so that its solid texture stays when it breaks
  };
  StageView(render::Renderer renderer, DebugLines lines)
      : renderer_(std::move(renderer)), lines_(std::move(lines)) {}
  render::Result<Item*> item_of(const game::Game& game, std::size_t thing);
  void set_states(const game::Game& game, std::size_t thing, Item& item, DebugView debug);
  void add_lines(const game::Game& game, DebugView debug);
  render::Result<void> upload_furniture(const game::Game& game);

  render::Renderer renderer_;
  DebugLines lines_;
  std::map<std::size_t, Item> items_;                          ///< by thing
  std::vector<std::pair<render::SolidLook, Item>> furniture_;  ///< boxes by look, then the balls
  const game::Game* furnished_ = nullptr;
  std::vector<world::FragmentState> fragment_states_;
  std::size_t uploads_ = 0;
};

/// A camera at `eye` that looks at `target`; 50° high.
render::Camera look_at(const glm::vec3& eye, const glm::vec3& target, float aspect);

}  // namespace fracture::view
