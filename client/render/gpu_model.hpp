// A Model in the driver's memory. It is uploaded once. Only the table of objects (176 bytes per object)
// changes from frame to frame, so hundreds of moving fragments take a few draw calls. A batch can grow:
// models are added to it, and all surfaces with equal materials take one draw call, whichever model they came
// from.
#pragma once

#include <map>
#include <memory>
#include <span>
#include <tuple>
#include <vector>

#include "client/render/gl_objects.hpp"
#include "client/render/looks.hpp"
#include "client/render/model.hpp"

namespace fracture::render {

/// Texture units of all programs, in this order. Every driver has at least sixteen for a fragment shader.
enum TextureUnit : int {
  kObjectTable,
  kBaseColor,
  kMetallicRoughness,
  kNormalMap,
  kOcclusion,
  kEmissive,
  kSunShadow,
  kSkyShadows,
  // For the high tier. The first two are reused when no surface is drawn (effects, passes over the whole
  // picture).
  kBehind,
  kSceneDepth,
  kSunDepths,
  kClearShadow,
  kSkyMap,
  kScreenOcclusion,
  kGlassFront,
  kGlassBack,
};

class GpuModel {
 public:
  /// Copies vertices, indices and textures to the current context. kGraphicsDriver if the driver is out of
  /// memory, kTooLarge if a texture exceeds its limit.
  static Expected<GpuModel> upload(std::shared_ptr<const Model> model);

  /// An empty batch.
  static Expected<GpuModel> batch();
  /// Adds a copy of a model to a batch; vertices are kept only in the driver. Returns the batch's number of
  /// the model's first object; the others follow. Equal materials are merged. On kTooLarge or
  /// kGraphicsDriver, nothing is added. A look replaces the materials, and textures are left out.
  Expected<std::uint32_t> append(const Model& more, const std::optional<SolidPlacement>& solid,
                                 SolidLook look = SolidLook::kNone);

  const Model& model() const { return *model_; }
  const Sphere& bounds() const { return bounds_; }  ///< of the model as the file places it

  /// Writes the table of objects; `states` has one entry per object. `grain`: for objects without a
  /// placement.
  void set_states(std::span<const ObjectState> states, const glm::vec3& grain = {0, 1, 0});
  void bind() const;  ///< vertex array and object table
  /// Binds the material's textures to their units. Empty slots get a white 1 × 1 texture.
  void bind_textures(const Material& material) const;

 private:
  struct Store {  ///< a buffer that grows by doubling and keeps its content; sizes in bytes
    Buffer buffer;
    std::size_t used = 0, capacity = 0;
    void add(const void* data, std::size_t bytes);
  };
  GpuModel() = default;
  void make_names();
  Expected<void> check_room(const Model& more) const;
  Expected<void> put(std::span<const Vertex> vertices, std::span<const std::uint32_t> indices);
  void upload_texture(const TextureSlot& slot, bool srgb);
  void bind_slot(int unit, const TextureSlot& slot, bool srgb) const;

  std::shared_ptr<const Model> model_;
  std::shared_ptr<Model> own_;  ///< same as model_ if this is a batch
  Sphere bounds_;
  VertexArray array_;
  Store vertices_, indices_;
  Buffer table_;
  Texture table_texture_, white_;
  std::map<std::pair<std::uint32_t, bool>, Texture> textures_;  ///< by picture, and whether it is sRGB
  std::map<std::tuple<int, int, int, int>, Sampler> samplers_;
  std::vector<glm::vec4> rows_;  ///< the table; a member to avoid allocations
};

}  // namespace fracture::render
