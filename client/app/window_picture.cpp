#include "client/app/window_picture.hpp"

#include <utility>

namespace fracture::app {
namespace {

render::TierChoice choice_of_driver() {
  const auto* name = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  return render::TierChoice(name != nullptr && render::draws_in_software(name));
}

}  // namespace

WindowPicture::WindowPicture(view::SceneView view) : view_(std::move(view)), choice_(choice_of_driver()) {}

Expected<void> WindowPicture::prepare(int width, int height) {
  if (target_ && target_->width() == width && target_->height() == height) return {};
  auto made = render::FrameTarget::create(width, height);
  if (!made) return tl::unexpected(made.error());
  target_ = std::make_unique<render::FrameTarget>(std::move(*made));
  choice_ = choice_of_driver();  // another size has another cost
  return {};
}

Expected<view::ViewFigures> WindowPicture::draw(const scenes::Scene& scene, const game::Moment& moment,
                                                const render::Camera& camera, view::ViewSettings settings,
                                                render::TierWish wish) {
  if (std::exchange(wish_, wish) != wish) choice_ = choice_of_driver();  // the player changed the setting
  const bool automatic = wish == render::TierWish::kAuto;
  settings.tier = automatic                         ? choice_.tier()
                  : wish == render::TierWish::kHigh ? render::Tier::kHigh
                                                    : render::Tier::kLow;
  timer_.begin();
  auto drawn = view_.draw(scene, moment, camera, settings, target_->framebuffer(), target_->width(),
                          target_->height());
  timer_.end();
  if (automatic && !drawn && settings.tier == render::Tier::kHigh)
    choice_ = render::TierChoice(true);  // the high tier failed; the low tier needs less
  while (const std::optional<double> took = timer_.take())
    if (automatic && drawn && drawn->tier == settings.tier && settings.debug == view::DebugView::kNone)
      choice_.add(*took);
  return drawn;
}

std::shared_ptr<const render::Picture> WindowPicture::read() const {
  return target_ ? std::make_shared<const render::Picture>(target_->read()) : nullptr;
}

}  // namespace fracture::app
