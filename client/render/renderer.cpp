#include "client/render/renderer.hpp"

#include <algorithm>
#include <string>

#include "client/render/frame_block.hpp"
#include "client/render/high_picture.hpp"
#include "client/render/programs.hpp"
#include "client/render/surface_pass.hpp"

namespace fracture::render {

Renderer::Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;
Renderer::~Renderer() = default;

Expected<Renderer> Renderer::create() {
  const int version = epoxy_gl_version();
  if (version < 33 || !epoxy_is_desktop_gl())
    return fail(ErrorCode::kNoGraphics,
                std::string("The graphics context must support OpenGL 3.3, but it has OpenGL ") +
                    (epoxy_is_desktop_gl() ? "" : "ES ") + std::to_string(version / 10) + "." +
                    std::to_string(version % 10) + ".");
  Renderer renderer;
  const auto build = [&](Program& program, const char* name, ShaderParts vertex,
                         ShaderParts fragment) -> Expected<void> {
    Expected<Program> made = build_program(name, Tier::kLow, vertex, fragment);
    if (!made) return tl::unexpected(made.error());
    program = std::move(*made);
    return {};
  };
  Expected<void> built =
      build(renderer.surface_, "surface", {"frame", "objects", "surface_vertex"},
            {"frame", "brdf", "lighting", "tone_map", "objects", "noise", "looks", "surface_fragment"});
  if (built)
    built = build(renderer.depth_, "depth", {"frame", "objects", "depth_vertex"}, {"depth_fragment"});
  if (built)
    built = build(renderer.ground_, "ground", {"frame", "ground_vertex"},
                  {"frame", "brdf", "lighting", "tone_map", "ground_fragment"});
  if (built)
    built =
        build(renderer.background_, "background", {"background_vertex"}, {"frame", "background_fragment"});
  if (!built) return tl::unexpected(built.error());
  Expected<ShadowMaps> shadows = ShadowMaps::create();
  if (!shadows) return tl::unexpected(shadows.error());
  renderer.shadows_ = std::move(*shadows);
  renderer.frame_block_ = make_buffer();
  renderer.empty_ = make_vertex_array();
  return renderer;
}

void Renderer::upload_frame(const FrameBlock& frame) const {
  glBindBuffer(GL_UNIFORM_BUFFER, frame_block_.get());
  glBufferData(GL_UNIFORM_BUFFER, sizeof(FrameBlock), &frame, GL_STREAM_DRAW);
  glBindBufferBase(GL_UNIFORM_BUFFER, kFrameBinding, frame_block_.get());
}

void Renderer::depth_passes(std::span<const DrawItem> items, const RenderSettings& settings, Tier tier,
                            FrameStats& stats) {
  depth_.use();
  glEnable(GL_DEPTH_TEST);
  glDepthMask(GL_TRUE);
  glDepthFunc(GL_LESS);
  glDisable(GL_BLEND);
  glDisable(GL_CULL_FACE);  // open and double-sided surfaces also cast shadows
  glEnable(GL_POLYGON_OFFSET_FILL);
  glPolygonOffset(1.5f, 2.f);
  if (settings.lighting.sun_shadow) {
    shadows_->begin_sun();
    for (const DrawItem& item : items)
      draw_depth(depth_, item, settings, -1, tier == Tier::kHigh ? Casters::kOpaque : Casters::kAll, stats);
    if (tier == Tier::kHigh) {
      shadows_->begin_clear();
      for (const DrawItem& item : items) draw_depth(depth_, item, settings, -1, Casters::kClear, stats);
    }
  }
  const int count = std::clamp(settings.lighting.sky_shadows, 0, shadows_->sky_count());
  for (int k = 0; k < count; ++k) {
    shadows_->begin_sky(k);
    for (const DrawItem& item : items) draw_depth(depth_, item, settings, k, Casters::kAll, stats);
  }
  glDisable(GL_POLYGON_OFFSET_FILL);
}

FrameStats Renderer::draw(GpuModel& gpu, std::span<const ObjectState> states, const Camera& camera,
                          const RenderSettings& settings, GLuint framebuffer, int width, int height) {
  const DrawItem item{&gpu, states, settings.look, settings.grain};
  return draw(std::span(&item, 1), camera, settings, framebuffer, width, height);
}

FrameStats Renderer::draw(std::span<const DrawItem> items, const Camera& camera,
                          const RenderSettings& settings, GLuint framebuffer, int width, int height) {
  const FrameBlock frame = frame_block(items, camera, settings, *shadows_, width, height);
  upload_frame(frame);

  for (const DrawItem& item : items) item.model->set_states(item.states, item.grain);
  FrameStats stats;
  const bool high = settings.tier == Tier::kHigh && !settings.wireframe && prepare_high(width, height);
  stats.tier = high ? Tier::kHigh : Tier::kLow;
  depth_passes(items, settings, stats.tier, stats);
  if (high) {
    shadows_->bind();
    high_->draw({items, camera, settings, frame}, framebuffer, stats);
    return stats;
  }

  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  glViewport(0, 0, width, height);
  glEnable(GL_FRAMEBUFFER_SRGB);
  glEnable(GL_MULTISAMPLE);
  glEnable(GL_TEXTURE_CUBE_MAP_SEAMLESS);
  glClearColor(0, 0, 0, 0);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  shadows_->bind();
  if (settings.background) {
    background_.use();
    glBindVertexArray(empty_.get());
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_CULL_FACE);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glEnable(GL_DEPTH_TEST);
  }
  glDisable(GL_BLEND);
  if (settings.wireframe) glPolygonMode(GL_FRONT_AND_BACK, GL_LINE);
  for (const DrawItem& item : items) draw_surfaces({surface_}, item, camera, settings, stats);
  glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
  if (settings.ground != Ground::kNone) {
    draw_ground(settings);
    ++stats.draw_calls;
  }
  glEnable(GL_BLEND);
  glBlendFuncSeparate(GL_ONE, GL_SRC1_COLOR, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  glDepthMask(GL_FALSE);
  if (settings.wireframe) glPolygonMode(GL_FRONT_AND_BACK, GL_LINE);
  for (const DrawItem& item : items)
    draw_surfaces({surface_, true, SurfacePass::Sides::kBackThenFront}, item, camera, settings, stats);
  glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
  glDepthMask(GL_TRUE);
  glDisable(GL_BLEND);
  for (GLuint unit = kBaseColor; unit <= kEmissive; ++unit) glBindSampler(unit, 0);
  glBindVertexArray(0);
  if (settings.overlay) settings.overlay(framebuffer);
  return stats;
}

bool Renderer::prepare_high(int width, int height) {
  if (trouble_) return false;
  if (!high_) {
    Expected<std::unique_ptr<HighPicture>> made = HighPicture::create();
    if (made)
      high_ = std::move(*made);
    else
      trouble_ = made.error();
  }
  if (high_)
    if (const auto ready = high_->prepare(width, height); !ready) trouble_ = ready.error();
  if (!trouble_)
    if (const auto added = shadows_->add_clear(); !added) trouble_ = added.error();
  return !trouble_;
}

void Renderer::draw_ground(const RenderSettings& settings) const {
  ground_.use();
  ground_.set("grid", settings.ground == Ground::kGrid ? 1 : 0);
  ground_.set("fade", settings.background ? 1 : 0);
  glBindVertexArray(empty_.get());
  glDisable(GL_CULL_FACE);
  glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
}

}  // namespace fracture::render
