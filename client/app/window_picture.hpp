// The game's picture in a window: its tier, chosen by what pictures take where it is left to that, and the target it is
// drawn into.
#pragma once

#include <memory>

#include "client/render/frame_target.hpp"
#include "client/render/gpu_timer.hpp"
#include "client/view/scene_view.hpp"

namespace fracture::app {

class WindowPicture {
 public:
  /// The window's context has to be current.
  explicit WindowPicture(view::SceneView view);

  /// For a window of that size; kTooLarge, kGraphicsDriver.
  Expected<void> prepare(int width, int height);
  /// Forgets what was uploaded: another game, or the same anew.
  void reset() { view_.reset(); }
  /// Draws in the tier that is wished; settings.tier is of no account.
  Expected<view::ViewFigures> draw(const scenes::Scene& scene, const game::Moment& moment,
                                   const render::Camera& camera, view::ViewSettings settings,
                                   render::TierWish wish);
  /// Into the window.
  void show() const { target_->copy_to(0); }
  /// What was drawn last; waits for the driver. Null before the first picture.
  std::shared_ptr<const render::Picture> read() const;

 private:
  view::SceneView view_;
  std::unique_ptr<render::FrameTarget> target_;
  render::GpuTimer timer_;
  render::TierChoice choice_;
  render::TierWish wish_ = render::TierWish::kAuto;
};

}  // namespace fracture::app
