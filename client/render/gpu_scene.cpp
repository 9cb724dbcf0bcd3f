#include "client/render/gpu_scene.hpp"

#include <algorithm>
#include <cstddef>
#include <string>

namespace fracture::render {
namespace {

constexpr int kTexelsPerObject = 8;  ///< as in shaders/objects.glsl

void attribute(GLuint location, GLint size, GLenum type, GLboolean normalized, std::size_t offset) {
  glEnableVertexAttribArray(location);
  glVertexAttribPointer(location, size, type, normalized, sizeof(Vertex),
                        reinterpret_cast<const void*>(offset));
}

/// Rows of the upper 3 × 4 part.
void put_rows(glm::vec4* out, const glm::mat4& m) {
  for (int r = 0; r < 3; ++r) out[r] = {m[0][r], m[1][r], m[2][r], m[3][r]};
}

auto sampler_key(const TextureSlot& s) { return std::tuple(s.min_filter, s.mag_filter, s.wrap_s, s.wrap_t); }

template <class Use>
void each_slot(const Material& m, Use&& use) {
  use(kBaseColor, m.base_color_texture, true);
  use(kMetallicRoughness, m.metallic_roughness_texture, false);
  use(kNormalMap, m.normal_texture, false);
  use(kOcclusion, m.occlusion_texture, false);
  use(kEmissive, m.emissive_texture, true);
}

}  // namespace

Result<GpuScene> GpuScene::upload(std::shared_ptr<const Scene> scene) {
  GpuScene gpu;
  gpu.scene_ = std::move(scene);
  gpu.bounds_ = bounding_sphere(*gpu.scene_, {});
  const Scene& s = *gpu.scene_;

  GLint texels = 0, side = 0;
  glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &texels);
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &side);
  if (s.objects.size() * kTexelsPerObject > static_cast<std::size_t>(texels))
    return fail(RenderErrorCode::kTooLarge, "The scene has " + std::to_string(s.objects.size()) +
                                                " objects; this driver has room for " +
                                                std::to_string(texels / kTexelsPerObject) + ".");
  for (const Picture& picture : s.pictures)
    if (picture.width > side || picture.height > side)
      return fail(RenderErrorCode::kTooLarge, "A texture has " + std::to_string(picture.width) + " x " +
                                                  std::to_string(picture.height) +
                                                  " pixels; this driver takes " + std::to_string(side) + ".");
  while (glGetError() != GL_NO_ERROR) {
  }
  gpu.array_ = make_vertex_array();
  glBindVertexArray(gpu.array_.get());
  gpu.vertices_ = make_buffer();
  glBindBuffer(GL_ARRAY_BUFFER, gpu.vertices_.get());
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(s.vertices.size() * sizeof(Vertex)),
               s.vertices.data(), GL_STATIC_DRAW);
  attribute(0, 3, GL_FLOAT, GL_FALSE, offsetof(Vertex, position));
  attribute(1, 3, GL_FLOAT, GL_FALSE, offsetof(Vertex, normal));
  attribute(2, 4, GL_FLOAT, GL_FALSE, offsetof(Vertex, tangent));
  attribute(3, 4, GL_FLOAT, GL_FALSE, offsetof(Vertex, uv));
  attribute(4, 4, GL_UNSIGNED_BYTE, GL_TRUE, offsetof(Vertex, color));
  glEnableVertexAttribArray(5);
  glVertexAttribIPointer(5, 1, GL_UNSIGNED_INT, sizeof(Vertex),
                         reinterpret_cast<const void*>(offsetof(Vertex, object)));
  gpu.indices_ = make_buffer();
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, gpu.indices_.get());
  glBufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(s.indices.size() * sizeof(std::uint32_t)),
               s.indices.data(), GL_STATIC_DRAW);
  glBindVertexArray(0);

  gpu.table_ = make_buffer();
  gpu.table_texture_ = make_texture();
  gpu.set_states(initial_states(s));
  glBindTexture(GL_TEXTURE_BUFFER, gpu.table_texture_.get());
  glTexBuffer(GL_TEXTURE_BUFFER, GL_RGBA32F, gpu.table_.get());

  constexpr std::uint8_t kWhitePixel[4] = {255, 255, 255, 255};
  gpu.white_ = make_texture();
  glBindTexture(GL_TEXTURE_2D, gpu.white_.get());
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, 1, 1, 0, GL_RGBA, GL_UNSIGNED_BYTE, kWhitePixel);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  for (const Material& material : s.materials)
    each_slot(material, [&](int, const TextureSlot& slot, bool srgb) { gpu.upload_texture(slot, srgb); });

  if (const GLenum error = glGetError(); error != GL_NO_ERROR)
    return fail(RenderErrorCode::kGl, "The driver cannot take the scene (" +
                                          std::to_string(s.vertices.size()) + " vertices, " +
                                          std::to_string(s.pictures.size()) + " textures): OpenGL error " +
                                          std::to_string(error) + ".");
  return gpu;
}

void GpuScene::upload_texture(const TextureSlot& slot, bool srgb) {
  if (slot.picture >= scene_->pictures.size()) return;
  auto [texture, is_new] = textures_.try_emplace({slot.picture, srgb});
  if (is_new) {
    const Picture& picture = scene_->pictures[slot.picture];
    texture->second = make_texture();
    glBindTexture(GL_TEXTURE_2D, texture->second.get());
    glTexImage2D(GL_TEXTURE_2D, 0, srgb ? GL_SRGB8_ALPHA8 : GL_RGBA8, picture.width, picture.height, 0,
                 GL_RGBA, GL_UNSIGNED_BYTE, picture.pixels.data());
    glGenerateMipmap(GL_TEXTURE_2D);
  }
  auto [sampler, is_new_sampler] = samplers_.try_emplace(sampler_key(slot));
  if (is_new_sampler) {
    sampler->second = make_sampler();
    const GLuint name = sampler->second.get();
    glSamplerParameteri(name, GL_TEXTURE_MIN_FILTER, slot.min_filter);
    glSamplerParameteri(name, GL_TEXTURE_MAG_FILTER, slot.mag_filter);
    glSamplerParameteri(name, GL_TEXTURE_WRAP_S, slot.wrap_s);
    glSamplerParameteri(name, GL_TEXTURE_WRAP_T, slot.wrap_t);
  }
}

void GpuScene::set_states(std::span<const ObjectState> states) {
  rows_.resize(kTexelsPerObject * std::max<std::size_t>(1, scene_->objects.size()));
  for (std::size_t k = 0; k < scene_->objects.size(); ++k) {
    glm::vec4* out = &rows_[kTexelsPerObject * k];
    put_rows(out, states[k].transform);
    put_rows(out + 3, scene_->objects[k].transform);
    out[6] = states[k].tint;
    const std::optional<FragmentInfo>& fragment = scene_->objects[k].fragment;
    out[7] = glm::vec4(fragment ? static_cast<float>(fragment->id % 65521) : 0.f, 0, 0, 0);
  }
  glBindBuffer(GL_TEXTURE_BUFFER, table_.get());
  glBufferData(GL_TEXTURE_BUFFER, static_cast<GLsizeiptr>(rows_.size() * sizeof(glm::vec4)), rows_.data(),
               GL_STREAM_DRAW);
  glBindBuffer(GL_TEXTURE_BUFFER, 0);
}

void GpuScene::bind() const {
  glBindVertexArray(array_.get());
  glActiveTexture(GL_TEXTURE0 + kObjectTable);
  glBindTexture(GL_TEXTURE_BUFFER, table_texture_.get());
}

void GpuScene::bind_slot(int unit, const TextureSlot& slot, bool srgb) const {
  glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  const auto texture = textures_.find({slot.picture, srgb});
  if (texture == textures_.end()) {
    glBindTexture(GL_TEXTURE_2D, white_.get());
    glBindSampler(static_cast<GLuint>(unit), 0);
    return;
  }
  glBindTexture(GL_TEXTURE_2D, texture->second.get());
  glBindSampler(static_cast<GLuint>(unit), samplers_.at(sampler_key(slot)).get());
}

void GpuScene::bind_textures(const Material& material) const {
  each_slot(material, [&](int unit, const TextureSlot& slot, bool srgb) { bind_slot(unit, slot, srgb); });
}

}  // namespace fracture::render
