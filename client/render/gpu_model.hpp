// A Model in the driver's memory. Uploaded once; what changes from frame to frame is the table of objects
// alone (176 bytes an object), so that hundreds of fragments that move are a few draw calls. A batch grows:
// models are added to it, and what wears equal materials is one draw call whatever model it came from.
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

/// Texture units of all programs, in this order. Sixteen are what every driver has for a fragment.
enum TextureUnit : int {
  kObjectTable,
  kBaseColor,
  kMetallicRoughness,
  kNormalMap,
  kOcclusion,
  kEmissive,
  kSunShadow,
  kSkyShadows,
  // The high tier's; the first two are others' where no surface is drawn (effects, passes over the whole picture).
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
  /// Copies vertices, indices and textures to the current context. kGl where the driver has no room,
  /// kTooLarge where it has too small textures.
  static Expected<GpuModel> upload(std::shared_ptr<const Model> model);

  /// An empty batch.
  static Expected<GpuModel> batch();
  /// Adds a model to a batch (its own copy; vertices stay in the driver alone) and returns the number of its
  /// first object there: the others follow. Equal materials become one. kTooLarge, kGl; then nothing was
  /// added. With a look, materials are taken as it replaces them, and textures stay out.
  Expected<std::uint32_t> append(const Model& more, const std::optional<SolidPlacement>& solid,
                                 SolidLook look = SolidLook::kNone);

  const Model& model() const { return *model_; }
  const Sphere& bounds() const { return bounds_; }  ///< of the model as the file places it

  /// Writes the table of objects; `states` has one for each object. `grain`: of objects without a placement.
  void set_states(std::span<const ObjectState> states, const glm::vec3& grain = {0, 1, 0});
  void bind() const;  ///< vertex array and object table
  /// Binds what the material shows to its units; 1 × 1 white where a slot is empty.
  void bind_textures(const Material& material) const;

 private:
  struct Store {  ///< a buffer that grows by doubling and keeps what is in it; bytes
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
  std::shared_ptr<Model> own_;  ///< model_, where this is a batch
  Sphere bounds_;
  VertexArray array_;
  Store vertices_, indices_;
  Buffer table_;
  Texture table_texture_, white_;
  std::map<std::pair<std::uint32_t, bool>, Texture> textures_;  ///< by picture and whether it is sRGB
  std::map<std::tuple<int, int, int, int>, Sampler> samplers_;
  std::vector<glm::vec4> rows_;  ///< the table, kept to spare allocations
};

}  // namespace fracture::render
