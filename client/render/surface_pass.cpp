#include "client/render/surface_pass.hpp"

#include <algorithm>
#include <vector>

#include "client/render/frame_block.hpp"

namespace fracture::render {
namespace {

/// Share of the light that clear glass blocks, unless its tint blocks more.
constexpr float kFaintShadow = 0.35f;

float coverage_of(const Material& m) {
  return std::max(kFaintShadow, m.transmission > 0 ? 0.f : m.base_color.a);
}

/// Whether the material casts its shadow into the map for clear casters. Nearly opaque materials do not.
bool is_clear(const Material& m) {
  constexpr float kNearlyOpaque = 0.7f;
  return m.blended() && coverage_of(m) < kNearlyOpaque;
}

/// Neighbouring surfaces with one material, drawn by one glMultiDrawElements.
struct Draw {
  std::vector<GLsizei> counts;
  std::vector<const void*> offsets;
  std::uint32_t end = 0;  ///< end of the last range

  void add(const Surface& s) {
    if (!empty() && s.first_index == end) {  // adjacent in memory: extend the last range
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

void set_material(const Program& program, const GpuModel& gpu, const Material& m,
                  const RenderSettings& settings) {
  const glm::vec4 pbr(m.metallic, m.roughness, m.transmission, m.ior);
  const glm::vec4 more(m.normal_texture.picture != kNoSlot ? m.normal_scale : 0.f, m.occlusion_strength,
                       m.alpha_mode == AlphaMode::kMask ? m.alpha_cutoff : -1.f,
                       m.alpha_mode == AlphaMode::kBlend ? 1.f : 0.f);
  glUniform4fv(program.location("base_color"), 1, &m.base_color[0]);
  glUniform4fv(program.location("pbr"), 1, &pbr[0]);
  glUniform4fv(program.location("more"), 1, &more[0]);
  glUniform3fv(program.location("emissive"), 1, &m.emissive[0]);
  const int uv_sets[5] = {m.base_color_texture.uv_set, m.metallic_roughness_texture.uv_set,
                          m.normal_texture.uv_set, m.occlusion_texture.uv_set, m.emissive_texture.uv_set};
  glUniform1iv(program.location("uv_set"), 5, uv_sets);
  program.set("interior", m.interior ? 1 : 0);
  program.set("highlight", settings.highlight == Highlight::kInterior ? 1 : 0);
  gpu.bind_textures(m);
  if (m.double_sided)
    glDisable(GL_CULL_FACE);
  else
    glEnable(GL_CULL_FACE);
}

}  // namespace

void draw_depth(const Program& depth, const DrawItem& item, const RenderSettings& settings, int map,
                Casters casters, FrameStats& stats) {
  const GpuModel& gpu = *item.model;
  const Model& model = gpu.model();
  const std::span<const ObjectState> states = item.states;
  const SolidLook look = settings.highlight == Highlight::kNone ? item.look : SolidLook::kPlaster;
  gpu.bind();
  depth.set("map", map);
  Draw draw;
  std::uint32_t current = kNoSlot;
  bool casts = true;
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
      depth.set("cutoff", masked ? m.alpha_cutoff : -1.f);
      depth.set("alpha_factor", m.base_color.a);
      depth.set("alpha_uv", m.base_color_texture.uv_set);
      depth.set("coverage", m.blended() && casters == Casters::kAll ? coverage_of(m) : 1.f);
      casts = casters == Casters::kAll || (casters == Casters::kClear) == is_clear(m);
      if (masked) gpu.bind_textures(m);
    }
    if (casts) draw.add(surface);
  }
  flush();
}

void draw_surfaces(const SurfacePass& pass, const DrawItem& item, const Camera& camera,
                   const RenderSettings& settings, FrameStats& stats) {
  pass.program.use();
  pass.program.set("look", static_cast<int>(item.look));
  item.model->bind();
  const GpuModel& gpu = *item.model;
  const Model& model = gpu.model();
  const std::span<const ObjectState> states = item.states;
  const auto planes = frustum_planes(camera.view_projection());
  const auto uncut = [&](std::uint32_t object) { return !item.uncut.empty() && item.uncut[object] != 0; };
  Draw draw;
  Material material;
  std::uint32_t current = kNoSlot;
  const auto flush = [&] {
    if (draw.empty()) return;
    ++stats.draw_calls;
    if (pass.sides == SurfacePass::Sides::kOfMaterial) {
      draw.flush();
      return;
    }
    glEnable(GL_CULL_FACE);
    if (pass.sides == SurfacePass::Sides::kBackThenFront) {
      Draw again = draw;
      glCullFace(GL_FRONT);
      again.flush();
      ++stats.draw_calls;
    }
    glCullFace(pass.sides == SurfacePass::Sides::kBack ? GL_FRONT : GL_BACK);
    draw.flush();
    glCullFace(GL_BACK);
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
      if (material.blended() == pass.blended) set_material(pass.program, gpu, material, settings);
    }
    if (material.blended() != pass.blended || (material.interior && uncut(surface.object))) continue;
    if (!touches(planes, in_world(model.objects[surface.object].bounds, state.transform))) {
      ++stats.culled;
      continue;
    }
    ++stats.surfaces;
    draw.add(surface);
  }
  flush();
}

bool any_blended(std::span<const DrawItem> items, const RenderSettings& settings) {
  if (settings.highlight == Highlight::kInterior) return false;
  return std::any_of(items.begin(), items.end(), [](const DrawItem& item) {
    const Model& model = item.model->model();
    std::vector<bool> blended;
    for (const Material& m : model.materials) blended.push_back(with_look(m, item.look).blended());
    return std::any_of(model.surfaces.begin(), model.surfaces.end(), [&](const Surface& s) {
      return blended[s.material] && item.states[s.object].visible;
    });
  });
}

}  // namespace fracture::render
