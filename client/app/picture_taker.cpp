#include "client/app/picture_taker.hpp"

#include <filesystem>
#include <utility>
#include <vector>

namespace fracture::app {

Expected<nlohmann::json> PictureTaker::take(const game::Game& game, const effects::Debris* debris,
                                            const std::string& name) {
  constexpr int kStillSkyShadows = 32;  // pictures need not be fast
  const Expected<view::ViewFigures> figures = draw(game, debris, kStillSkyShadows);
  if (!figures) return tl::unexpected(figures.error());
  const std::string path = (std::filesystem::path(options_.out) / name).string();
  if (const auto written = write_png(target_->read(), path); !written) return tl::unexpected(written.error());
  return nlohmann::json{{"file", path},
                        {"draw_calls", figures->draw_calls},
                        {"shadow_draw_calls", figures->shadow_draw_calls},
                        {"submit_ms", figures->submit_ms},
                        {"culled", figures->culled}};
}

Expected<view::ViewFigures> PictureTaker::draw(const game::Game& game, const effects::Debris* debris,
                                               int sky_shadows) {
  if (auto ready = prepare(); !ready) return tl::unexpected(ready.error());
  const scenes::Scene& scene = game.scene();
  const float aspect = static_cast<float>(options_.width) / static_cast<float>(options_.height);
  view::ViewSettings settings;
  settings.sky_shadows = sky_shadows;
  settings.tier = options_.picture == render::TierWish::kHigh ? render::Tier::kHigh : render::Tier::kLow;
  settings.debris = debris;
  const std::vector<game::Game::Coming> coming = game.coming();
  settings.coming = &coming;
  const game::Moment moment = game::moment_of(game, settings.tier == render::Tier::kHigh);
  const scenes::View from =
      scenes::view_at(scene, static_cast<double>(moment.step) * game.world().settings().step);
  const auto figures = view_->draw(scene, moment, view::look_at(from.eye, from.target, aspect), settings,
                                   target_->framebuffer(), options_.width, options_.height);
  if (!figures) return tl::unexpected(figures.error());
  return *figures;
}

Expected<void> PictureTaker::prepare() {
  if (view_) return {};
  auto context = egl::EglContext::create();
  if (!context) return tl::unexpected(context.error());
  context_ = std::make_unique<egl::EglContext>(std::move(*context));
  auto target = render::FrameTarget::create(options_.width, options_.height);
  if (!target) return tl::unexpected(target.error());
  target_ = std::make_unique<render::FrameTarget>(std::move(*target));
  auto view = view::SceneView::create();
  if (!view) return tl::unexpected(view.error());
  view_ = std::make_unique<view::SceneView>(std::move(*view));
  return {};
}

}  // namespace fracture::app
