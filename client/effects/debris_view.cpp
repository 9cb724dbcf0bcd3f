#include "client/effects/debris_view.hpp"

#include <algorithm>
#include <cmath>

#include "client/render/gpu_model.hpp"
#include "client/render/programs.hpp"

namespace fracture::effects {
namespace {

// Texture units that the renderer uses only while it draws surfaces.
constexpr int kShapes = render::kBehind, kDepth = render::kSceneDepth;
constexpr int kShapeSide = 64;  // texels
constexpr int kCrumbVertices = 24, kBoxVertices = 36;

/// Sets up consecutive attributes of `sizes` floats each, starting with `first`. `divisor` instances share a
/// value.
void attributes(GLuint buffer, GLuint first, std::initializer_list<int> sizes, GLuint divisor) {
  glBindBuffer(GL_ARRAY_BUFFER, buffer);
  int stride = 0;
  for (const int size : sizes) stride += size;
  std::size_t offset = 0;
  for (const int size : sizes) {
    glEnableVertexAttribArray(first);
    glVertexAttribPointer(first, size, GL_FLOAT, GL_FALSE, static_cast<GLsizei>(sizeof(float)) * stride,
                          reinterpret_cast<const void*>(offset * sizeof(float)));
    glVertexAttribDivisor(first, divisor);
    offset += static_cast<std::size_t>(size);
    ++first;
  }
}

void upload(GLuint buffer, const std::vector<float>& data, GLenum usage) {
  glBindBuffer(GL_ARRAY_BUFFER, buffer);
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(data.size() * sizeof(float)), data.data(), usage);
}

/// Value noise on a repeating grid, 0 … 1.
float noise(int x, int y, int cell, int shape) {
  const auto at = [&](int i, int j) {
    const int cells = kShapeSide / cell;
    std::uint32_t h = static_cast<std::uint32_t>(i % cells) * 73856093u ^
                      static_cast<std::uint32_t>(j % cells) * 19349663u ^
                      static_cast<std::uint32_t>(shape * 16 + cell) * 83492791u;
    h = (h ^ (h >> 13)) * 1274126177u;
    return static_cast<float>((h ^ (h >> 16)) & 0xffffu) / 65535.f;
  };
  const int i = x / cell, j = y / cell;
  const auto smooth = [](float t) { return t * t * (3 - 2 * t); };
  const float u = smooth(static_cast<float>(x % cell) / static_cast<float>(cell)),
              v = smooth(static_cast<float>(y % cell) / static_cast<float>(cell));
  return (at(i, j) * (1 - u) + at(i + 1, j) * u) * (1 - v) +
         (at(i, j + 1) * (1 - u) + at(i + 1, j + 1) * u) * v;
}

}  // namespace

Expected<void> DebrisView::build_programs(render::Tier tier) {
  const auto build = [tier](render::Program& program, const char* name, render::ShaderParts vertex,
                            render::ShaderParts low, render::ShaderParts high) -> Expected<void> {
    auto built = render::build_program(name, tier, vertex, tier == render::Tier::kHigh ? high : low);
    if (!built) return tl::unexpected(built.error());
    program = std::move(*built);
    program.set("puff_shapes", kShapes);
    program.set("scene_depth", kDepth);
    return {};
  };
  auto built = build(puff_, "puff", {"frame", "puff_vertex"},
                     {"frame", "brdf", "lighting", "tone_map", "puff_fragment"},
                     {"frame", "brdf", "noise", "sky", "lighting_high", "puff_fragment"});
  if (built)
    built = build(crumb_, "crumb", {"frame", "crumb_vertex"},
                  {"frame", "brdf", "lighting", "tone_map", "crumb_fragment"},
                  {"frame", "brdf", "noise", "sky", "lighting_high", "crumb_fragment"});
  if (built)
    built = build(mark_, "mark", {"frame", "mark_vertex"},
                  {"frame", "brdf", "lighting", "tone_map", "noise", "mark_fragment"},
                  {"frame", "brdf", "noise", "sky", "lighting_high", "mark_fragment"});
  return built;
}

Expected<DebrisView> DebrisView::create(render::Tier tier) {
  DebrisView view;
  if (const auto built = view.build_programs(tier); !built) return tl::unexpected(built.error());
  for (render::Buffer* buffer :
       {&view.puff_buffer_, &view.crumb_buffer_, &view.mark_buffer_, &view.crumb_shape_, &view.box_})
    *buffer = render::make_buffer();
  for (render::VertexArray* array : {&view.puffs_, &view.crumbs_, &view.marks_})
    *array = render::make_vertex_array();
  view.make_puff_shapes();
  view.make_boxes();
  glBindVertexArray(view.puffs_.get());
  attributes(view.puff_buffer_.get(), 0, {4, 4, 2}, 1);
  glBindVertexArray(view.crumbs_.get());
  attributes(view.crumb_shape_.get(), 0, {3, 3}, 0);
  attributes(view.crumb_buffer_.get(), 2, {4, 4, 4}, 1);
  glBindVertexArray(view.marks_.get());
  attributes(view.box_.get(), 0, {3}, 0);
  attributes(view.mark_buffer_.get(), 1, {4, 4, 4}, 1);
  glBindVertexArray(0);
  return view;
}

/// Makes four shapes side by side: soft discs with edges eaten away by noise.
void DebrisView::make_puff_shapes() {
  std::vector<std::uint8_t> texels(static_cast<std::size_t>(4 * kShapeSide * kShapeSide));
  for (int y = 0; y < kShapeSide; ++y)
    for (int x = 0; x < 4 * kShapeSide; ++x) {
      const int shape = x / kShapeSide, column = x % kShapeSide;
      const float dx = (static_cast<float>(column) + 0.5f) / (0.5f * kShapeSide) - 1,
                  dy = (static_cast<float>(y) + 0.5f) / (0.5f * kShapeSide) - 1;
      const float cloud = 0.5f * noise(column, y, 16, shape) + 0.3f * noise(column, y, 8, shape) +
                          0.2f * noise(column, y, 4, shape);
      const float disc = std::max(0.f, 1 - std::sqrt(dx * dx + dy * dy));
      const float value = std::clamp(2.2f * disc * (0.25f + 1.1f * cloud) - 0.25f * (1 - disc), 0.f, 1.f) *
                          std::min(1.f, 4 * disc);
      texels[static_cast<std::size_t>(y * 4 * kShapeSide + x)] = static_cast<std::uint8_t>(255 * value);
    }
  shapes_ = render::make_texture();
  glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(kShapes));
  glBindTexture(GL_TEXTURE_2D, shapes_.get());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_R8, 4 * kShapeSide, kShapeSide, 0, GL_RED, GL_UNSIGNED_BYTE,
               texels.data());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
}

void DebrisView::make_boxes() {
  // A crumb: an irregular octahedron with flat faces.
  const glm::vec3 corners[6] = {{1, 0.1f, 0},      {-1, -0.1f, 0.1f}, {0.1f, 0.8f, 0.2f},
                                {0, -0.9f, -0.1f}, {0.2f, 0.1f, 1},   {-0.1f, 0, -0.8f}};
  std::vector<float> shape;
  for (int k = 0; k < 8; ++k) {
    glm::vec3 p[3] = {corners[k & 1 ? 1 : 0], corners[k & 2 ? 3 : 2], corners[k & 4 ? 5 : 4]};
    if (glm::dot(glm::cross(p[1] - p[0], p[2] - p[0]), p[0] + p[1] + p[2]) < 0) std::swap(p[1], p[2]);
    const glm::vec3 normal = glm::normalize(glm::cross(p[1] - p[0], p[2] - p[0]));
    for (const glm::vec3& corner : p)
      shape.insert(shape.end(), {corner.x, corner.y, corner.z, normal.x, normal.y, normal.z});
  }
  upload(crumb_shape_.get(), shape, GL_STATIC_DRAW);
  // The cube of side 2 around the origin.
  std::vector<float> box;
  for (int axis = 0; axis < 3; ++axis)
    for (const float side : {-1.f, 1.f}) {
      const float square[6][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, -1}, {1, 1}, {-1, 1}};
      for (const auto& at : square) {
        float p[3];
        p[axis] = side;
        p[(axis + 1) % 3] = side * at[0];
        p[(axis + 2) % 3] = at[1];
        box.insert(box.end(), {p[0], p[1], p[2]});
      }
    }
  upload(box_.get(), box, GL_STATIC_DRAW);
}

/// Copies one depth sample per pixel into a texture.
void DebrisView::copy_depth(GLuint framebuffer, int width, int height) {
  glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(kDepth));
  if (width != width_ || height != height_) {
    depth_ = render::make_texture();
    glBindTexture(GL_TEXTURE_2D, depth_.get());
    glTexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT24, width, height, 0, GL_DEPTH_COMPONENT,
                 GL_UNSIGNED_INT, nullptr);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    depth_framebuffer_ = render::make_framebuffer();
    glBindFramebuffer(GL_FRAMEBUFFER, depth_framebuffer_.get());
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, depth_.get(), 0);
    glDrawBuffer(GL_NONE);
    glReadBuffer(GL_NONE);
    width_ = width;
    height_ = height;
  }
  glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer);
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, depth_framebuffer_.get());
  glBlitFramebuffer(0, 0, width, height, 0, 0, width, height, GL_DEPTH_BUFFER_BIT, GL_NEAREST);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  glBindTexture(GL_TEXTURE_2D, depth_.get());
}

void DebrisView::draw_crumbs(const std::vector<Crumb>& crumbs) {
  data_.clear();
  for (const Crumb& crumb : crumbs) {
    const float size = crumb.size * std::clamp(crumb.life + 1 - crumb.age, 0.f, 1.f);
    for (const glm::vec4& v : {glm::vec4(crumb.position, size), glm::vec4(crumb.axis, crumb.turn),
                               glm::vec4(crumb.color, crumb.stretch)})
      data_.insert(data_.end(), {v.x, v.y, v.z, v.w});
  }
  upload(crumb_buffer_.get(), data_, GL_STREAM_DRAW);
  crumb_.use();
  glBindVertexArray(crumbs_.get());
  glDrawArraysInstanced(GL_TRIANGLES, 0, kCrumbVertices, static_cast<GLsizei>(crumbs.size()));
}

void DebrisView::draw_marks(std::span<const PlacedMark> marks) {
  data_.clear();
  for (const PlacedMark& placed : marks) {
    const Mark& mark = *placed.mark;
    for (const glm::vec4& v : {glm::vec4(placed.position, mark.radius), glm::vec4(placed.normal, mark.turn),
                               glm::vec4(mark.color, mark.cracks ? -mark.opacity : mark.opacity)})
      data_.insert(data_.end(), {v.x, v.y, v.z, v.w});
  }
  upload(mark_buffer_.get(), data_, GL_STREAM_DRAW);
  mark_.use();
  glBindVertexArray(marks_.get());
  // Draws the far sides of each box, without a depth test, because the eye may be inside.
  glEnable(GL_CULL_FACE);
  glCullFace(GL_FRONT);
  glDisable(GL_DEPTH_TEST);
  glDrawArraysInstanced(GL_TRIANGLES, 0, kBoxVertices, static_cast<GLsizei>(marks.size()));
  glEnable(GL_DEPTH_TEST);
  glCullFace(GL_BACK);
  glDisable(GL_CULL_FACE);
}

void DebrisView::draw_puffs(const std::vector<Puff>& puffs, const render::Camera& camera) {
  // Draws distant puffs first.
  std::vector<std::pair<float, const Puff*>> ordered;
  for (const Puff& puff : puffs) ordered.emplace_back((camera.view * glm::vec4(puff.position, 1)).z, &puff);
  std::stable_sort(ordered.begin(), ordered.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  data_.clear();
  for (const auto& [depth, puff] : ordered) {
    for (const glm::vec4& v :
         {glm::vec4(puff->position, puff->radius), glm::vec4(puff->color, puff->opacity())})
      data_.insert(data_.end(), {v.x, v.y, v.z, v.w});
    data_.insert(data_.end(), {puff->turn, static_cast<float>(puff->shape)});
  }
  upload(puff_buffer_.get(), data_, GL_STREAM_DRAW);
  puff_.use();
  glUniformMatrix4fv(puff_.location("view"), 1, GL_FALSE, &camera.view[0][0]);
  glBindVertexArray(puffs_.get());
  glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, static_cast<GLsizei>(puffs.size()));
}

std::size_t DebrisView::draw(const Debris& debris, std::span<const PlacedMark> marks,
                             const render::Camera& camera, GLuint framebuffer, int width, int height) {
  if (debris.crumbs().empty() && debris.puffs().empty() && marks.empty()) return 0;
  std::size_t calls = 0;
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_LESS);
  glDisable(GL_CULL_FACE);
  glBlendFuncSeparate(GL_ONE, GL_ONE_MINUS_SRC_ALPHA, GL_ZERO, GL_ONE);  // colours are premultiplied
  if (!marks.empty() || !debris.puffs().empty()) {
    copy_depth(framebuffer, width, height);  // before crumbs are drawn, because they get no marks
    glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(kShapes));
    glBindTexture(GL_TEXTURE_2D, shapes_.get());
  }
  if (!marks.empty()) {
    glEnable(GL_BLEND);
    glDepthMask(GL_FALSE);
    draw_marks(marks);
    glDepthMask(GL_TRUE);
    glDisable(GL_BLEND);
    ++calls;
  }
  if (!debris.crumbs().empty()) {
    draw_crumbs(debris.crumbs());
    ++calls;
  }
  if (!debris.puffs().empty()) {
    glEnable(GL_BLEND);
    glDepthMask(GL_FALSE);
    draw_puffs(debris.puffs(), camera);
    glDepthMask(GL_TRUE);
    glDisable(GL_BLEND);
    ++calls;
  }
  glBindVertexArray(0);
  return calls;
}

}  // namespace fracture::effects
