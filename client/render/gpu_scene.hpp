// A Scene in the driver's memory. Uploaded once; what changes from frame to frame is the table of objects
// alone (128 bytes an object), so that hundreds of fragments that move are a few draw calls.
#pragma once

#include <map>
#include <memory>
#include <span>
#include <tuple>
#include <vector>

#include "client/render/gl_objects.hpp"
#include "client/render/scene.hpp"

namespace fracture::render {

/// Texture units of the surface program, in this order.
enum TextureUnit : int {
  kObjectTable,
  kBaseColor,
  kMetallicRoughness,
  kNormalMap,
  kOcclusion,
  kEmissive,
  kSunShadow,
  kSkyShadows,
};

class GpuScene {
 public:
  /// Copies vertices, indices and textures to the current context. kGl where the driver has no room,
  /// kTooLarge where it has too small textures.
  static Result<GpuScene> upload(std::shared_ptr<const Scene> scene);

  const Scene& scene() const { return *scene_; }
  const Sphere& bounds() const { return bounds_; }  ///< of the scene as the file places it

  /// Writes the table of objects; `states` has one for each object.
  void set_states(std::span<const ObjectState> states);
  void bind() const;  ///< vertex array and object table
  /// Binds what the material shows to its units; 1 × 1 white where a slot is empty.
  void bind_textures(const Material& material) const;

 private:
  GpuScene() = default;
  void upload_texture(const TextureSlot& slot, bool srgb);
  void bind_slot(int unit, const TextureSlot& slot, bool srgb) const;

  std::shared_ptr<const Scene> scene_;
  Sphere bounds_;
  VertexArray array_;
  Buffer vertices_, indices_, table_;
  Texture table_texture_, white_;
  std::map<std::pair<std::uint32_t, bool>, Texture> textures_;  ///< by picture and whether it is sRGB
  std::map<std::tuple<int, int, int, int>, Sampler> samplers_;
  std::vector<glm::vec4> rows_;  ///< the table, kept to spare allocations
};

}  // namespace fracture::render
