// Draws the game's picture into a target for the window. If the player leaves the choice open, it picks the
// tier by the measured drawing time.
#pragma once

#include <memory>

#include "client/render/frame_target.hpp"
#include "client/render/gpu_timer.hpp"
#include "client/view/scene_view.hpp"

namespace fracture::app {

class WindowPicture {
 public:
  /// The window's context must be current.
  explicit WindowPicture(view::SceneView view);

  /// Prepares for a window of this size; kTooLarge, kGraphicsDriver.
  Expected<void> prepare(int width, int height);
  /// Forgets what was uploaded, for another game or a restart.
  void reset() { view_.reset(); }
  /// Draws in the requested tier; settings.tier is ignored.
  Expected<view::ViewFigures> draw(const scenes::Scene& scene, const game::Moment& moment,
                                   const render::Camera& camera, view::ViewSettings settings,
                                   render::TierWish wish);
  /// Copies the picture into the window.
  void show() const { target_->copy_to(0); }
  /// The last drawn picture; waits for the driver. Null before the first picture.
  std::shared_ptr<const render::Picture> read() const;

 private:
  view::SceneView view_;
  std::unique_ptr<render::FrameTarget> target_;
  render::GpuTimer timer_;
  render::TierChoice choice_;
  render::TierWish wish_ = render::TierWish::kAuto;
};

}  // namespace fracture::app
