#include "client/render/gpu_model.hpp"

#include <algorithm>
#include <cstddef>
#include <string>

namespace fracture::render {
namespace {

constexpr int kTexelsPerObject = 11;  ///< as in shaders/objects.glsl

void attribute(GLuint location, GLint size, GLenum type, GLboolean normalized, std::size_t offset) {
  glEnableVertexAttribArray(location);
  glVertexAttribPointer(location, size, type, normalized, sizeof(Vertex),
                        reinterpret_cast<const void*>(offset));
}

/// Writes the rows of the upper 3 × 4 part.
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

void GpuModel::Store::add(const void* data, std::size_t bytes) {
  if (used + bytes > capacity) {
    const std::size_t room = used == 0 ? bytes : 2 * (used + bytes);
    Buffer larger = make_buffer();
    glBindBuffer(GL_COPY_WRITE_BUFFER, larger.get());
    glBufferData(GL_COPY_WRITE_BUFFER, static_cast<GLsizeiptr>(room), nullptr, GL_STATIC_DRAW);
    if (used > 0) {
      glBindBuffer(GL_COPY_READ_BUFFER, buffer.get());
      glCopyBufferSubData(GL_COPY_READ_BUFFER, GL_COPY_WRITE_BUFFER, 0, 0, static_cast<GLsizeiptr>(used));
    }
    buffer = std::move(larger);
    capacity = room;
  }
  glBindBuffer(GL_COPY_WRITE_BUFFER, buffer.get());
  glBufferSubData(GL_COPY_WRITE_BUFFER, static_cast<GLintptr>(used), static_cast<GLsizeiptr>(bytes), data);
  used += bytes;
}

void GpuModel::make_names() {
  array_ = make_vertex_array();
  table_ = make_buffer();
  table_texture_ = make_texture();
  constexpr std::uint8_t kWhitePixel[4] = {255, 255, 255, 255};
  white_ = make_texture();
  glBindTexture(GL_TEXTURE_2D, white_.get());
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, 1, 1, 0, GL_RGBA, GL_UNSIGNED_BYTE, kWhitePixel);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
}

Expected<void> GpuModel::check_room(const Model& more) const {
  GLint texels = 0, side = 0;
  glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &texels);
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &side);
  const std::size_t objects = more.objects.size() + (own_ ? own_->objects.size() : 0);
  if (objects * kTexelsPerObject > static_cast<std::size_t>(texels))
    return fail(ErrorCode::kTooLarge, "The model has " + std::to_string(objects) +
                                          " objects; this driver supports at most " +
                                          std::to_string(texels / kTexelsPerObject) + ".");
  for (const Picture& picture : more.pictures)
    if (picture.width > side || picture.height > side)
      return fail(ErrorCode::kTooLarge,
                  "A texture has " + std::to_string(picture.width) + " x " + std::to_string(picture.height) +
                      " pixels; this driver supports at most " + std::to_string(side) + " per side.");
  while (glGetError() != GL_NO_ERROR) {
  }
  return {};
}

Expected<void> GpuModel::put(std::span<const Vertex> vertices, std::span<const std::uint32_t> indices) {
  vertices_.add(vertices.data(), vertices.size_bytes());
  indices_.add(indices.data(), indices.size_bytes());
  glBindVertexArray(array_.get());
  glBindBuffer(GL_ARRAY_BUFFER, vertices_.buffer.get());
  attribute(0, 3, GL_FLOAT, GL_FALSE, offsetof(Vertex, position));
  attribute(1, 3, GL_FLOAT, GL_FALSE, offsetof(Vertex, normal));
  attribute(2, 4, GL_FLOAT, GL_FALSE, offsetof(Vertex, tangent));
  attribute(3, 4, GL_FLOAT, GL_FALSE, offsetof(Vertex, uv));
  attribute(4, 4, GL_UNSIGNED_BYTE, GL_TRUE, offsetof(Vertex, color));
  glEnableVertexAttribArray(5);
  glVertexAttribIPointer(5, 1, GL_UNSIGNED_INT, sizeof(Vertex),
                         reinterpret_cast<const void*>(offsetof(Vertex, object)));
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices_.buffer.get());
  glBindVertexArray(0);
  for (const Material& material : model_->materials)
    each_slot(material, [&](int, const TextureSlot& slot, bool srgb) { upload_texture(slot, srgb); });
  if (const GLenum error = glGetError(); error != GL_NO_ERROR)
    return fail(ErrorCode::kGraphicsDriver, "The driver cannot load the model (" +
                                                std::to_string(vertices.size()) + " vertices, " +
                                                std::to_string(model_->pictures.size()) +
                                                " textures): OpenGL error " + std::to_string(error) + ".");
  return {};
}

Expected<GpuModel> GpuModel::upload(std::shared_ptr<const Model> model) {
  GpuModel gpu;
  if (auto room = gpu.check_room(*model); !room) return tl::unexpected(room.error());
  gpu.make_names();
  gpu.model_ = std::move(model);
  gpu.bounds_ = bounding_sphere(*gpu.model_, {});
  gpu.set_states(initial_states(*gpu.model_));
  glBindTexture(GL_TEXTURE_BUFFER, gpu.table_texture_.get());
  glTexBuffer(GL_TEXTURE_BUFFER, GL_RGBA32F, gpu.table_.get());
  if (auto done = gpu.put(gpu.model_->vertices, gpu.model_->indices); !done)
    return tl::unexpected(done.error());
  return gpu;
}

Expected<GpuModel> GpuModel::batch() {
  GpuModel gpu;
  gpu.own_ = std::make_shared<Model>();
  gpu.model_ = gpu.own_;
  gpu.make_names();
  gpu.set_states({});
  glBindTexture(GL_TEXTURE_BUFFER, gpu.table_texture_.get());
  glTexBuffer(GL_TEXTURE_BUFFER, GL_RGBA32F, gpu.table_.get());
  return gpu;
}

Expected<std::uint32_t> GpuModel::append(const Model& more, const std::optional<SolidPlacement>& solid,
                                         SolidLook look) {
  if (auto room = check_room(more); !room) return tl::unexpected(room.error());
  const auto first_object = static_cast<std::uint32_t>(own_->objects.size()),
             first_vertex = static_cast<std::uint32_t>(vertices_.used / sizeof(Vertex)),
             first_index = static_cast<std::uint32_t>(indices_.used / sizeof(std::uint32_t)),
             first_picture = static_cast<std::uint32_t>(own_->pictures.size());
  const std::size_t materials_before = own_->materials.size();
  // Different files rarely share pictures. Usually the same file is added again, with all of its pictures.
  const auto same = [](const Picture& a, const Picture& b) {
    return a.width == b.width && a.pixels == b.pixels;
  };
  std::vector<std::uint32_t> picture_of;
  const bool textured = look == SolidLook::kNone;
  for (const Picture& picture : textured ? std::span(more.pictures) : std::span<const Picture>()) {
    std::uint32_t at = 0;
    while (at < own_->pictures.size() && !same(own_->pictures[at], picture)) ++at;
    if (at == own_->pictures.size()) own_->pictures.push_back(picture);
    picture_of.push_back(at);
  }
  std::vector<std::uint32_t> material_of;
  for (const Material& source : more.materials) {
    Material material = with_look(source, look);
    material.name.clear();
    for (TextureSlot* slot :
         {&material.base_color_texture, &material.metallic_roughness_texture, &material.normal_texture,
          &material.occlusion_texture, &material.emissive_texture})
      if (slot->picture < picture_of.size()) slot->picture = picture_of[slot->picture];
    const auto known = std::find(own_->materials.begin(), own_->materials.end(), material);
    material_of.push_back(static_cast<std::uint32_t>(known - own_->materials.begin()));
    if (known == own_->materials.end()) own_->materials.push_back(std::move(material));
  }
  std::vector<Vertex> vertices = more.vertices;
  for (Vertex& v : vertices) v.object += first_object;
  std::vector<std::uint32_t> indices = more.indices;
  for (std::uint32_t& index : indices) index += first_vertex;
  if (auto done = put(vertices, indices); !done) {
    own_->materials.resize(materials_before);
    own_->pictures.resize(first_picture);
    return tl::unexpected(done.error());
  }
  for (Object object : more.objects) {
    object.solid = solid;
    own_->objects.push_back(std::move(object));
  }
  for (Surface surface : more.surfaces) {
    surface.object += first_object;
    surface.material = material_of[surface.material];
    surface.first_index += first_index;
    own_->surfaces.push_back(surface);
  }
  std::stable_sort(own_->surfaces.begin(), own_->surfaces.end(),
                   [](const Surface& a, const Surface& b) { return a.material < b.material; });
  return first_object;
}

void GpuModel::upload_texture(const TextureSlot& slot, bool srgb) {
  if (slot.picture >= model_->pictures.size()) return;
  auto [texture, is_new] = textures_.try_emplace({slot.picture, srgb});
  if (is_new) {
    const Picture& picture = model_->pictures[slot.picture];
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

void GpuModel::set_states(std::span<const ObjectState> states, const glm::vec3& grain) {
  const SolidPlacement around_all{.frame = bounds_, .grain = grain};
  rows_.resize(kTexelsPerObject * std::max<std::size_t>(1, model_->objects.size()));
  for (std::size_t k = 0; k < model_->objects.size(); ++k) {
    glm::vec4* out = &rows_[kTexelsPerObject * k];
    put_rows(out, states[k].transform);
    put_rows(out + 3, model_->objects[k].transform);
    out[6] = states[k].tint;
    const std::optional<FragmentInfo>& fragment = model_->objects[k].fragment;
    const std::optional<SolidPlacement>& own = model_->objects[k].solid;
    const SolidPlacement& solid = own ? *own : around_all;
    const bool has_grain = glm::dot(solid.grain, solid.grain) > 0;
    out[7] = glm::vec4(fragment ? static_cast<float>(fragment->id % 65521) : 0.f,
                       has_grain ? glm::normalize(solid.grain) : glm::vec3(0, 1, 0));
    out[8] = glm::vec4(solid.frame.center, std::max(solid.frame.radius, 1e-6f));
    out[9] = glm::vec4(solid.brick, solid.brick_low);
    out[10] = glm::vec4(solid.brick_high, 0, 0);
  }
  glBindBuffer(GL_TEXTURE_BUFFER, table_.get());
  glBufferData(GL_TEXTURE_BUFFER, static_cast<GLsizeiptr>(rows_.size() * sizeof(glm::vec4)), rows_.data(),
               GL_STREAM_DRAW);
  glBindBuffer(GL_TEXTURE_BUFFER, 0);
}

void GpuModel::bind() const {
  glBindVertexArray(array_.get());
  glActiveTexture(GL_TEXTURE0 + kObjectTable);
  glBindTexture(GL_TEXTURE_BUFFER, table_texture_.get());
}

void GpuModel::bind_slot(int unit, const TextureSlot& slot, bool srgb) const {
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

void GpuModel::bind_textures(const Material& material) const {
  each_slot(material, [&](int unit, const TextureSlot& slot, bool srgb) { bind_slot(unit, slot, srgb); });
}

}  // namespace fracture::render
