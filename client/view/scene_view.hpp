// Shows a moment of a game: uploads new models, updates transforms and draws. Each look has one batch, so all
// surfaces with equal materials take one draw call.
#pragma once

#include <map>

#include "client/effects/debris_view.hpp"
#include "client/game/moment.hpp"
#include "client/render/renderer.hpp"
#include "client/view/debug_lines.hpp"
#include "client/view/view_settings.hpp"

namespace fracture::view {

struct ViewFigures {
  std::size_t draw_calls = 0, shadow_draw_calls = 0, culled = 0, uploads = 0;
  double submit_ms = 0;  ///< processor time from the first to the last call of a frame
  render::Tier tier = render::Tier::kLow;
};

class SceneView {
 public:
  static Expected<SceneView> create();

  /// Forgets everything that was uploaded, for another scene or a restart.
  void reset() {
    batches_.clear();
    places_.clear();
    waiting_.clear();
    furnished_ = false;
  }
  /// Draws a moment of a game in this scene into the framebuffer. The scene must stay the same until reset().
  /// Things that are missing in the moment are hidden. kGraphicsDriver if the driver rejects a mesh; the rest
  /// is still drawn.
  Expected<ViewFigures> draw(const scenes::Scene& scene, const game::Moment& moment,
                             const render::Camera& camera, const ViewSettings& settings, GLuint framebuffer,
                             int width, int height);

 private:
  struct Batch {
    render::GpuModel gpu;
    std::vector<render::ObjectState> states;
    std::vector<std::uint8_t> uncut;  ///< 1: the interior surfaces are hidden
  };
  struct Place {  ///< of a model's objects in the batch of their look
    render::SolidLook look = render::SolidLook::kNone;
    std::uint32_t first = 0, count = 0;
  };
  SceneView(render::Renderer renderer, DebugLines lines, effects::DebrisView debris)
      : renderer_(std::move(renderer)), lines_(std::move(lines)), debris_(std::move(debris)) {}
  /// Appends to the batch of a look. Returns the number of the first object.
  Expected<std::uint32_t> add(render::SolidLook look, const render::Model& model,
                              const std::optional<render::SolidPlacement>& solid);
  using LayerModel = std::shared_ptr<const render::Model>;  ///< model of a layer; null: the whole
  /// The place of a thing's model in its batch. Uploads the model if necessary.
  Expected<Place> place_of(const scenes::SceneObject& object, std::size_t thing, const LayerModel& model);
  /// Shows a thing as it is in the moment: whole, broken, or absent.
  Expected<void> show(const scenes::Scene& scene, const game::Moment& moment, std::size_t thing,
                      const ViewSettings& settings);
  Expected<Place> upload(const scenes::SceneObject& object, const LayerModel& model);
  /// Uploads hidden models of things about to break, because the frame of the break has enough to do.
  Expected<void> upload_coming(const scenes::Scene& scene, const std::vector<game::Game::Coming>& coming);
  void hide(const Place& place);
  void set_whole(const Place& place, const world::Pose& pose);
  void set_fragments(const Place& place, const game::Decoded::Layer& layer,
                     const std::vector<world::FragmentState>& fragments, DebugView debug);
  void set_balls(const std::vector<world::BallState>& balls);
  void add_lines(const game::Moment& moment, DebugView debug);
  /// The debris view for a tier.
  Expected<effects::DebrisView*> debris_for(render::Tier tier);
  Expected<void> upload_furniture(const scenes::Scene& scene);
  void place_marks(const game::Moment& moment, const effects::Debris& debris);

  render::Renderer renderer_;
  DebugLines lines_;
  effects::DebrisView debris_;
  std::optional<effects::DebrisView> high_debris_;  ///< created when first needed
  std::vector<effects::PlacedMark> marks_;
  std::map<render::SolidLook, Batch> batches_;
  std::map<std::pair<std::size_t, LayerModel>, Place> places_;  ///< by thing and model
  std::map<LayerModel, Place> waiting_;                         ///< uploaded ahead
  std::uint32_t balls_ = 0;                                     ///< first ball in the batch without a look
  bool furnished_ = false;
  std::size_t uploads_ = 0;
};

/// A camera at `eye` that looks at `target`, with a vertical field of view of 50°.
render::Camera look_at(const glm::vec3& eye, const glm::vec3& target, float aspect);

}  // namespace fracture::view
