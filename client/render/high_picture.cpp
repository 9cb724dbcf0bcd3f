#include "client/render/high_picture.hpp"

#include <utility>

#include "client/render/programs.hpp"
#include "client/render/surface_pass.hpp"

namespace fracture::render {
namespace {

/// Values of `layer` in shaders/surface_fragment.glsl.
enum SurfaceLayer : int { kOpaque, kHiddenGlass, kNearestGlass };

void read(int unit, const Texture& texture) {
  glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  glBindTexture(GL_TEXTURE_2D, texture.get());
}

}  // namespace

Expected<std::unique_ptr<HighPicture>> HighPicture::create() {
  Expected<SkyLight> sky = SkyLight::create();
  if (!sky) return tl::unexpected(sky.error());
  Expected<Occlusion> occlusion = Occlusion::create();
  if (!occlusion) return tl::unexpected(occlusion.error());
  Expected<PostProcess> post = PostProcess::create();
  if (!post) return tl::unexpected(post.error());
  std::unique_ptr<HighPicture> picture(
      new HighPicture(std::move(*sky), std::move(*occlusion), std::move(*post)));
  const auto build = [&](Program& program, const char* name, ShaderParts vertex,
                         ShaderParts fragment) -> Expected<void> {
    Expected<Program> made = build_program(name, Tier::kHigh, vertex, fragment);
    if (!made) return tl::unexpected(made.error());
    program = std::move(*made);
    return {};
  };
  HighPicture& p = *picture;
  Expected<void> built = build(p.surface_, "surface (high)", {"frame", "objects", "surface_vertex"},
                               {"frame", "brdf", "noise", "sky", "lighting_high", "objects", "looks",
                                "refraction", "surface_fragment"});
  if (built)
    built =
        build(p.depth_, "depth of surfaces", {"frame", "objects", "surface_vertex"}, {"depth_only_fragment"});
  if (built)
    built = build(p.ground_, "ground (high)", {"frame", "ground_high_vertex"},
                  {"frame", "brdf", "noise", "sky", "lighting_high", "ground_high_fragment"});
  if (built)
    built =
        build(p.ground_depth_, "depth of the ground", {"frame", "ground_high_vertex"}, {"nothing_fragment"});
  if (built)
    built = build(p.background_, "background (high)", {"screen_vertex"},
                  {"frame", "brdf", "noise", "sky", "lighting_high", "background_high_fragment"});
  if (built)
    built = build(p.glass_back_, "back of glass", {"frame", "objects", "surface_vertex"},
                  {"frame", "glass_back_fragment"});
  if (!built) return tl::unexpected(built.error());
  p.empty_ = make_vertex_array();
  return picture;
}

Expected<void> HighPicture::prepare(int width, int height) {
  if (targets_ && targets_->width == width && targets_->height == height) return {};
  targets_.reset();
  Expected<HighTargets> made = HighTargets::create(width, height);
  if (!made) return tl::unexpected(made.error());
  targets_.emplace(std::move(*made));
  return {};
}

void HighPicture::draw_ground(const Program& program, const Shown& shown) const {
  program.use();
  program.set("grid", shown.settings.ground == Ground::kGrid ? 1 : 0);
  glBindVertexArray(empty_.get());
  glDisable(GL_CULL_FACE);
  glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
}

void HighPicture::draw_depth(const Shown& shown, FrameStats& stats) const {
  targets_->scene_depth.begin();
  glEnable(GL_DEPTH_TEST);
  glDepthMask(GL_TRUE);
  glDepthFunc(GL_LESS);
  glDisable(GL_BLEND);
  glClear(GL_DEPTH_BUFFER_BIT);
  FrameStats of_depth;
  for (const DrawItem& item : shown.items)
    draw_surfaces({depth_}, item, shown.camera, shown.settings, of_depth);
  stats.draw_calls += of_depth.draw_calls;
  if (shown.settings.ground == Ground::kNone) return;
  draw_ground(ground_depth_, shown);
  ++stats.draw_calls;
}

void HighPicture::draw_opaque(const Shown& shown, FrameStats& stats) const {
  glBindFramebuffer(GL_FRAMEBUFFER, targets_->lit.get());
  glViewport(0, 0, targets_->width, targets_->height);
  glClearColor(0, 0, 0, 0);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  if (shown.settings.background) {
    background_.use();
    glBindVertexArray(empty_.get());
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_CULL_FACE);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    ++stats.draw_calls;
  }
  glEnable(GL_DEPTH_TEST);
  surface_.use();
  surface_.set("layer", kOpaque);
  for (const DrawItem& item : shown.items)
    draw_surfaces({surface_}, item, shown.camera, shown.settings, stats);
  if (shown.settings.ground == Ground::kNone) return;
  draw_ground(ground_, shown);
  ++stats.draw_calls;
}

void HighPicture::draw_glass(const Shown& shown, FrameStats& stats) const {
  const HighTargets& t = *targets_;
  FrameStats again;  // for surfaces that are already counted
  const auto pass = [&](const Program& program, SurfacePass::Sides sides, FrameStats& counted) {
    for (const DrawItem& item : shown.items)
      draw_surfaces({program, true, sides}, item, shown.camera, shown.settings, counted);
  };
  glDisable(GL_BLEND);
  t.glass_front.begin();
  glClear(GL_DEPTH_BUFFER_BIT);
  pass(depth_, SurfacePass::Sides::kFront, again);
  t.glass_back.begin();
  glClearColor(0, 0, 0, 0);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  pass(glass_back_, SurfacePass::Sides::kBack, again);
  read(kGlassFront, t.glass_front.texture);
  read(kGlassBack, t.glass_back.texture);
  read(kBehind, t.behind.texture);

  glBindFramebuffer(GL_FRAMEBUFFER, t.lit.get());
  glViewport(0, 0, t.width, t.height);
  glDepthMask(GL_FALSE);
  glEnable(GL_BLEND);
  glBlendFuncSeparate(GL_ONE, GL_SRC1_COLOR, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  surface_.use();
  surface_.set("layer", kHiddenGlass);
  pass(surface_, SurfacePass::Sides::kBackThenFront, stats);

  glBindFramebuffer(GL_READ_FRAMEBUFFER, t.lit.get());
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, t.behind.framebuffer.get());
  glBlitFramebuffer(0, 0, t.width, t.height, 0, 0, t.width, t.height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  glActiveTexture(GL_TEXTURE0 + kBehind);
  glGenerateMipmap(GL_TEXTURE_2D);
  glBindFramebuffer(GL_FRAMEBUFFER, t.lit.get());
  surface_.use();
  surface_.set("layer", kNearestGlass);
  pass(surface_, SurfacePass::Sides::kFront, again);
  stats.draw_calls += again.draw_calls;
  glDepthMask(GL_TRUE);
  glDisable(GL_BLEND);
}

void HighPicture::draw(const Shown& shown, GLuint framebuffer, FrameStats& stats) {
  glEnable(GL_TEXTURE_CUBE_MAP_SEAMLESS);
  glEnable(GL_MULTISAMPLE);
  glEnable(GL_FRAMEBUFFER_SRGB);  // affects only sRGB targets
  sky_.update(shown.frame);
  draw_depth(shown, stats);
  occlusion_.draw(*targets_, shown.camera);
  stats.draw_calls += 2;
  draw_opaque(shown, stats);
  if (any_blended(shown.items, shown.settings)) draw_glass(shown, stats);
  for (GLuint unit = kBaseColor; unit <= kEmissive; ++unit) glBindSampler(unit, 0);
  glBindVertexArray(0);
  if (shown.settings.overlay) shown.settings.overlay(targets_->lit.get());
  glBindSampler(kSunDepths, 0);
  stats.draw_calls += post_.draw(*targets_, framebuffer);
  glBindVertexArray(0);
}

}  // namespace fracture::render
