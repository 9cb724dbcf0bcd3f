#include "client/render/renderer.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace fracture::render {

/// The uniform block of shaders/frame.glsl, in std140: only matrices and four-component vectors.
struct Renderer::Frame {
  glm::mat4 view_projection, inverse_view_projection, sun_matrix;
  glm::mat4 sky_matrix[kMaxSkyDirections];
  glm::vec4 sky_direction[kMaxSkyDirections];
  glm::vec4 eye;          ///< w: exposure
  glm::vec4 towards_sun;  ///< w: softness in texels
  glm::vec4 sun;          ///< w: 1 with shadow
  glm::vec4 sky, ground;  ///< sky.w: number of directions; ground.w: 1 where the camera is orthographic
  glm::vec4 background_top, background_bottom;
  glm::vec4 sphere;   ///< of what is drawn: centre, radius
  glm::vec4 plane;    ///< of the ground: colour, height
  glm::vec4 texel;    ///< metres of a texel: sun, sky; then 1 / sides
  glm::vec4 forward;  ///< the camera's direction, for orthographic ones
};

/// Neighbouring surfaces of one material: one glMultiDrawElements.
struct Renderer::Draw {
  std::vector<GLsizei> counts;
  std::vector<const void*> offsets;
  std::uint32_t end = 0;  ///< of the last range

  void add(const Surface& s) {
    if (!empty() && s.first_index == end) {  // neighbours in memory are one range
      counts.back() += static_cast<GLsizei>(s.index_count);
      end += s.index_count;
      return;
    }
    end = s.first_index + s.index_count;
    counts.push_back(static_cast<GLsizei>(s.index_count));
    offsets.push_back(reinterpret_cast<const void*>(sizeof(std::uint32_t) * s.first_index));
  }
  bool empty() const { return counts.empty(); }
  void flush() {
    if (!empty())
      glMultiDrawElements(GL_TRIANGLES, counts.data(), GL_UNSIGNED_INT, offsets.data(),
                          static_cast<GLsizei>(counts.size()));
    counts.clear();
    offsets.clear();
  }
};

namespace {

constexpr GLuint kFrameBinding = 0;
constexpr float kFaintShadow =
    0.35f;  ///< share of the light that clear glass keeps back, where its tint says no more

std::string shader(std::initializer_list<const char*> parts) {
  std::string text = "#version 330 core\n";
  for (const char* part : parts) text += shader_text(part);
  return text;
}

float largest_scale(const glm::mat4& m) {
  return std::sqrt(std::max({glm::dot(m[0], m[0]), glm::dot(m[1], m[1]), glm::dot(m[2], m[2])}));
}

Sphere in_world(const Sphere& local, const glm::mat4& transform) {
  return {glm::vec3(transform * glm::vec4(local.center, 1)), local.radius * largest_scale(transform)};
}

/// Around the spheres of the visible objects: cheap enough for every frame, unlike one around their vertices.
Sphere around_objects(std::span<const DrawItem> items) {
  glm::vec3 low(HUGE_VALF), high(-HUGE_VALF);
  const auto each = [&](auto&& use) {
    for (const DrawItem& item : items)
      for (std::size_t k = 0; k < item.states.size(); ++k)
        if (item.states[k].visible)
          use(in_world(item.model->model().objects[k].bounds, item.states[k].transform));
  };
  each([&](const Sphere& s) {
    low = glm::min(low, s.center - s.radius);
    high = glm::max(high, s.center + s.radius);
  });
  if (!(low.x <= high.x)) return {{0, 0, 0}, 1};
  Sphere result{0.5f * (low + high), 0};
  each([&](const Sphere& s) {
    result.radius = std::max(result.radius, glm::distance(s.center, result.center) + s.radius);
  });
  result.radius = std::max(result.radius, 1e-6f);
  return result;
}

float lowest_point(std::span<const DrawItem> items) {
  float lowest = HUGE_VALF;
  for (const DrawItem& item : items)
    for (const Vertex& v : item.model->model().vertices)
      if (item.states[v.object].visible) {
        const glm::mat4& m = item.states[v.object].transform;
        lowest =
            std::min(lowest, m[0].y * v.position.x + m[1].y * v.position.y + m[2].y * v.position.z + m[3].y);
      }
  return std::isfinite(lowest) ? lowest : 0.f;
}

}  // namespace

Expected<Renderer> Renderer::create() {
  if (epoxy_gl_version() < 33 || !epoxy_is_desktop_gl())
    return fail(ErrorCode::kNoGraphics, "The current context is not OpenGL 3.3 or later (it is " +
                                            std::to_string(epoxy_gl_version()) + ").");
  Renderer renderer;
  const auto build = [&](Program& program, const char* name, std::initializer_list<const char*> vertex,
                         std::initializer_list<const char*> fragment) -> Expected<void> {
    Expected<Program> built = Program::build(name, shader(vertex), shader(fragment));
    if (!built) return tl::unexpected(built.error());
    program = std::move(*built);
    program.use();
    program.bind_block("Frame", kFrameBinding);
    for (const auto& [uniform, unit] :
         std::initializer_list<std::pair<const char*, int>>{{"object_table", kObjectTable},
                                                            {"base_color_map", kBaseColor},
                                                            {"metallic_roughness_map", kMetallicRoughness},
                                                            {"normal_map", kNormalMap},
                                                            {"occlusion_map", kOcclusion},
                                                            {"emissive_map", kEmissive},
                                                            {"sun_map", kSunShadow},
                                                            {"sky_maps", kSkyShadows}})
      program.set(uniform, unit);
    return {};
  };
  Expected<void> built = build(renderer.surface_, "surface", {"frame", "objects", "surface_vertex"},
                               {"frame", "lighting", "objects", "noise", "looks", "surface_fragment"});
  if (built)
    built = build(renderer.depth_, "depth", {"frame", "objects", "depth_vertex"}, {"depth_fragment"});
  if (built)
    built = build(renderer.ground_, "ground", {"frame", "ground_vertex"},
                  {"frame", "lighting", "ground_fragment"});
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

void Renderer::upload_frame(const Frame& frame) const {
  glBindBuffer(GL_UNIFORM_BUFFER, frame_block_.get());
  glBufferData(GL_UNIFORM_BUFFER, sizeof(Frame), &frame, GL_STREAM_DRAW);
  glBindBufferBase(GL_UNIFORM_BUFFER, kFrameBinding, frame_block_.get());
}

/// map: -1 the sun, else a direction of the sky.
void Renderer::draw_depth(const DrawItem& item, const RenderSettings& settings, int map,
                          FrameStats& stats) const {
  const GpuModel& gpu = *item.model;
  const Model& model = gpu.model();
  const std::span<const ObjectState> states = item.states;
  const SolidLook look = settings.highlight == Highlight::kNone ? item.look : SolidLook::kPlaster;
  gpu.bind();
  depth_.set("map", map);
  Draw draw;
  std::uint32_t current = kNoSlot;
  const auto flush = [&] {
    stats.shadow_draw_calls += !draw.empty();
    draw.flush();
  };
  for (const Surface& surface : model.surfaces) {
    if (!states[surface.object].visible) continue;
    if (surface.material != current) {
      flush();
      current = surface.material;
      const Material m = with_look(model.materials[current], look);
      const bool masked = m.alpha_mode == AlphaMode::kMask;
      depth_.set("cutoff", masked ? m.alpha_cutoff : -1.f);
      depth_.set("alpha_factor", m.base_color.a);
      depth_.set("alpha_uv", m.base_color_texture.uv_set);
      depth_.set("coverage",
                 m.blended() ? std::max(kFaintShadow, m.transmission > 0 ? 0.f : m.base_color.a) : 1.f);
      if (masked) gpu.bind_textures(m);
    }
    draw.add(surface);
  }
  flush();
}

void Renderer::depth_passes(std::span<const DrawItem> items, const RenderSettings& settings,
                            FrameStats& stats) const {
  depth_.use();
  glEnable(GL_DEPTH_TEST);
  glDepthMask(GL_TRUE);
  glDepthFunc(GL_LESS);
  glDisable(GL_BLEND);
  glDisable(GL_CULL_FACE);  // open and double-sided surfaces throw shadows as well
  glEnable(GL_POLYGON_OFFSET_FILL);
  glPolygonOffset(1.5f, 2.f);
  if (settings.lighting.sun_shadow) {
    shadows_->begin_sun();
    for (const DrawItem& item : items) draw_depth(item, settings, -1, stats);
  }
  const int count = std::clamp(settings.lighting.sky_shadows, 0, shadows_->sky_count());
  for (int k = 0; k < count; ++k) {
    shadows_->begin_sky(k);
    for (const DrawItem& item : items) draw_depth(item, settings, k, stats);
  }
  glDisable(GL_POLYGON_OFFSET_FILL);
}

void Renderer::begin_surfaces(const DrawItem& item) const {
  surface_.use();
  surface_.set("look", static_cast<int>(item.look));
  item.model->bind();
}

void Renderer::draw_surfaces(const DrawItem& item, const Camera& camera, bool blended,
                             const RenderSettings& settings, FrameStats& stats) const {
  begin_surfaces(item);
  const GpuModel& gpu = *item.model;
  const Model& model = gpu.model();
  const std::span<const ObjectState> states = item.states;
  const auto planes = frustum_planes(camera.view_projection());
  Draw draw;
  Material material;
  std::uint32_t current = kNoSlot;
  const auto flush = [&] {
    if (draw.empty()) return;
    if (!blended) {
      ++stats.draw_calls;
      draw.flush();
      return;
    }
    Draw again = draw;
    glEnable(GL_CULL_FACE);
    glCullFace(GL_FRONT);
    again.flush();
    glCullFace(GL_BACK);
    draw.flush();
    stats.draw_calls += 2;
  };
  for (const Surface& surface : model.surfaces) {
    const ObjectState& state = states[surface.object];
    if (!state.visible) continue;
    if (surface.material != current) {
      flush();
      current = surface.material;
      material = with_look(model.materials[current], item.look);
      if (settings.highlight == Highlight::kInterior)
        material.transmission = 0, material.alpha_mode = AlphaMode::kOpaque;
      if (material.blended() == blended) set_material(gpu, material, settings);
    }
    if (material.blended() != blended) continue;
    if (!touches(planes, in_world(model.objects[surface.object].bounds, state.transform))) {
      ++stats.culled;
      continue;
    }
    ++stats.surfaces;
    draw.add(surface);
  }
  flush();
}

void Renderer::set_material(const GpuModel& gpu, const Material& m, const RenderSettings& settings) const {
  const glm::vec4 pbr(m.metallic, m.roughness, m.transmission, m.ior);
  const glm::vec4 more(m.normal_texture.picture != kNoSlot ? m.normal_scale : 0.f, m.occlusion_strength,
                       m.alpha_mode == AlphaMode::kMask ? m.alpha_cutoff : -1.f,
                       m.alpha_mode == AlphaMode::kBlend ? 1.f : 0.f);
  glUniform4fv(surface_.location("base_color"), 1, &m.base_color[0]);
  glUniform4fv(surface_.location("pbr"), 1, &pbr[0]);
  glUniform4fv(surface_.location("more"), 1, &more[0]);
  glUniform3fv(surface_.location("emissive"), 1, &m.emissive[0]);
  const int uv_sets[5] = {m.base_color_texture.uv_set, m.metallic_roughness_texture.uv_set,
                          m.normal_texture.uv_set, m.occlusion_texture.uv_set, m.emissive_texture.uv_set};
  glUniform1iv(surface_.location("uv_set"), 5, uv_sets);
  surface_.set("interior", m.interior ? 1 : 0);
  surface_.set("highlight", settings.highlight == Highlight::kInterior ? 1 : 0);
  gpu.bind_textures(m);
  if (m.double_sided)
    glDisable(GL_CULL_FACE);
  else
    glEnable(GL_CULL_FACE);
}

FrameStats Renderer::draw(GpuModel& gpu, std::span<const ObjectState> states, const Camera& camera,
                          const RenderSettings& settings, GLuint framebuffer, int width, int height) {
  const DrawItem item{&gpu, states, settings.look, settings.grain};
  return draw(std::span(&item, 1), camera, settings, framebuffer, width, height);
}

FrameStats Renderer::draw(std::span<const DrawItem> items, const Camera& camera,
                          const RenderSettings& settings, GLuint framebuffer, int width, int height) {
  const Lighting& light = settings.lighting;
  const Sphere sphere = settings.lit ? *settings.lit : around_objects(items);
  Frame frame{};
  frame.view_projection = camera.view_projection();
  frame.inverse_view_projection = glm::inverse(frame.view_projection);
  const glm::vec3 towards_sun = glm::dot(light.towards_sun, light.towards_sun) > 0
                                    ? glm::normalize(light.towards_sun)
                                    : glm::vec3(0, 1, 0);
  frame.sun_matrix = light_matrix(sphere, towards_sun);
  const int sky_count = std::clamp(light.sky_shadows, 0, shadows_->sky_count());
  const std::vector<glm::vec3> directions = sky_directions(sky_count);
  for (std::size_t k = 0; k < directions.size(); ++k) {
    frame.sky_matrix[k] = light_matrix(sphere, directions[k]);
    frame.sky_direction[k] = glm::vec4(directions[k], 0);
  }
  const bool orthographic = camera.projection[3][3] == 1.f;
  frame.eye = glm::vec4(camera.eye, light.exposure);
  frame.towards_sun = glm::vec4(towards_sun, light.sun_softness);
  frame.sun = glm::vec4(light.sun, light.sun_shadow ? 1 : 0);
  frame.sky = glm::vec4(light.sky, static_cast<float>(sky_count));
  frame.ground = glm::vec4(light.ground, orthographic ? 1 : 0);
  frame.background_top = glm::vec4(settings.background_top, 1);
  frame.background_bottom = glm::vec4(settings.background_bottom, 1);
  frame.sphere = glm::vec4(sphere.center, sphere.radius);
  const float height_of_ground = settings.ground_height.value_or(
      settings.ground == Ground::kNone ? 0.f : lowest_point(items) - 1e-3f * sphere.radius);
  frame.plane = glm::vec4(settings.ground_color, height_of_ground);
  frame.texel = glm::vec4(2 * sphere.radius / static_cast<float>(shadows_->sun_side()),
                          2 * sphere.radius / static_cast<float>(shadows_->sky_side()),
                          1.f / static_cast<float>(shadows_->sun_side()),
                          1.f / static_cast<float>(shadows_->sky_side()));
  frame.forward = glm::vec4(-camera.view[0][2], -camera.view[1][2], -camera.view[2][2], 0);
  upload_frame(frame);

  for (const DrawItem& item : items) item.model->set_states(item.states, item.grain);
  FrameStats stats;
  depth_passes(items, settings, stats);

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
  for (const DrawItem& item : items) draw_surfaces(item, camera, false, settings, stats);
  glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
  if (settings.ground != Ground::kNone) {
    draw_ground(settings);
    ++stats.draw_calls;
  }
  glEnable(GL_BLEND);
  glBlendFuncSeparate(GL_ONE, GL_SRC1_COLOR, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  glDepthMask(GL_FALSE);
  if (settings.wireframe) glPolygonMode(GL_FRONT_AND_BACK, GL_LINE);
  for (const DrawItem& item : items) draw_surfaces(item, camera, true, settings, stats);
  glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
  glDepthMask(GL_TRUE);
  glDisable(GL_BLEND);
  for (GLuint unit = kBaseColor; unit <= kEmissive; ++unit) glBindSampler(unit, 0);
  glBindVertexArray(0);
  return stats;
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
