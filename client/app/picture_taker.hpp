// Pictures of a game without a window.
#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "client/app/options.hpp"
#include "client/effects/debris.hpp"
#include "client/egl/egl_context.hpp"
#include "client/game/game.hpp"
#include "client/render/frame_target.hpp"
#include "client/view/scene_view.hpp"
#include "common/base/error.hpp"

namespace fracture::app {

/// Takes pictures. Creates the context and the renderer for the first picture.
class PictureTaker {
 public:
  /// `options` must outlive this object.
  explicit PictureTaker(const Options& options) : options_(options) {}

  /// Writes a picture to the folder `out` of the options. Returns its path and the figures of the renderer.
  /// Errors: kNoGraphics, kGraphicsDriver, kFileAccess, kBadImage.
  Expected<nlohmann::json> take(const game::Game& game, const effects::Debris* debris,
                                const std::string& name);

  /// The last drawn picture.
  render::Picture picture() const { return target_->read(); }

  /// Draws the game as it is now. Errors: kNoGraphics, kGraphicsDriver.
  Expected<view::ViewFigures> draw(const game::Game& game, const effects::Debris* debris,
                                   int sky_shadows = view::ViewSettings{}.sky_shadows);

 private:
  Expected<void> prepare();

  const Options& options_;
  std::unique_ptr<egl::EglContext> context_;
  std::unique_ptr<render::FrameTarget> target_;
  std::unique_ptr<view::SceneView> view_;
};

}  // namespace fracture::app
