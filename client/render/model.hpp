// A glTF file as the renderer takes it: one vertex and one index array for everything, objects that move as a
// whole (a fragment is one), and surfaces: the triangles of one object that wear one material. Plain data; no
// OpenGL.
//
//   Model ── objects[k]   where it stands, what fragment it is, its surfaces
//         ── surfaces[s]  object, material, range of indices; sorted by material: one draw call for each
//         ── vertices     each knows its object: transforms come from a table, not from a uniform per call
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "client/render/image.hpp"

namespace fracture::render {

inline constexpr std::uint32_t kNoSlot = std::numeric_limits<std::uint32_t>::max();

struct Vertex {
  glm::vec3 position{};      ///< in the object's frame, metres
  glm::vec3 normal{};        ///< unit length
  glm::vec4 tangent{};       ///< xyz unit length, w = ±1; all zero where the file has none
  glm::vec2 uv[2]{};         ///< TEXCOORD_0 and _1, v down
  glm::u8vec4 color{255};    ///< COLOR_0, linear, 0 … 255
  std::uint32_t object = 0;  ///< index into Model::objects
};

enum class AlphaMode { kOpaque, kMask, kBlend };

/// One texture slot of a material. Filters and wraps are glTF's numbers, which are OpenGL's.
struct TextureSlot {
  std::uint32_t picture = kNoSlot;  ///< index into Model::pictures
  int uv_set = 0;
  int min_filter = 9987, mag_filter = 9729;  ///< LINEAR_MIPMAP_LINEAR, LINEAR
  int wrap_s = 10497, wrap_t = 10497;        ///< REPEAT
  bool operator==(const TextureSlot&) const = default;
};

struct Material {
  std::string name;
  glm::vec4 base_color{1};  ///< linear
  glm::vec3 emissive{0};    ///< linear
  float metallic = 1, roughness = 1;
  float normal_scale = 1, occlusion_strength = 1, alpha_cutoff = 0.5f;
  float transmission = 0;  ///< KHR_materials_transmission: 1 is clear glass, thin-walled here
  float ior = 1.5f;        ///< KHR_materials_ior
  AlphaMode alpha_mode = AlphaMode::kOpaque;
  bool double_sided = false;
  bool interior = false;  ///< of cut faces, as a file of the service says
  TextureSlot base_color_texture, metallic_roughness_texture, normal_texture, occlusion_texture,
      emissive_texture;

  bool blended() const { return alpha_mode == AlphaMode::kBlend || transmission > 0; }
  bool operator==(const Material&) const = default;
};

/// From a node's extras.fracture.
struct FragmentInfo {
  std::uint64_t id = 0;  ///< as in the file: 53 bits
  double volume = 0;     ///< cubic metres
  bool anchored = false;
  glm::vec3 centroid{};  ///< centre of mass, in the world at load
  std::vector<std::uint32_t>
      ancestors;  ///< nodes of the hierarchy, coarsest first, the fragment's own node last
};

struct Sphere {
  glm::vec3 center{};
  float radius = 0;
};

/// Where the solid texture of a look lies (looks.hpp), in the frame of the file.
struct SolidPlacement {
  Sphere frame;              ///< it fills this sphere
  glm::vec3 grain{0, 1, 0};  ///< of wood
  /// Courses of bricks of this size from `brick_low` to `brick_high` along x and up y, every other one
  /// shifted by a half. 0: none.
  glm::vec2 brick{0}, brick_low{0}, brick_high{0};
};

struct Object {
  std::string name;
  glm::mat4 transform{1};  ///< object to world at load
  Sphere bounds;           ///< of its vertices, in the object's frame
  std::optional<FragmentInfo> fragment;
  std::optional<SolidPlacement> solid;  ///< else: around the whole model
};

struct Surface {
  std::uint32_t object = 0, material = 0;
  std::uint32_t first_index = 0, index_count = 0;
};

struct Model {
  std::vector<Vertex> vertices;
  std::vector<std::uint32_t> indices;
  std::vector<Object> objects;
  std::vector<Surface> surfaces;
  std::vector<Material> materials;  ///< the file's, then glTF's default material
  std::vector<Picture> pictures;    ///< decoded; one grey pixel for what could not be
  std::vector<std::string> warnings;
};

/// A GLB, or a glTF as one JSON text with its buffers inside. The mesh is checked as an upload is (lengths,
/// indices, extensions; common/import), and a position that is not finite is refused. Mirrored nodes keep
/// their outside outside; missing normals become flat; nodes called UCX_… (collision hulls) are left out;
/// images that are neither PNG nor JPEG, and what extensions of materials ask beyond transmission and ior,
/// are left out with a warning. kMesh, kTooLarge.
Expected<Model> read_model(std::span<const std::byte> bytes);

/// read_model of a file's bytes; kFile where it cannot be read.
Expected<Model> load_model(const std::string& path);

/// The smallest sphere around the box of all objects under their transforms (kept at the model's own where
/// `transforms` is empty), not around invisible ones. Radius 0 for nothing.
struct ObjectState;
Sphere bounding_sphere(const Model& model, std::span<const ObjectState> states);

/// Where an object stands in a picture, and what colour covers its material.
struct ObjectState {
  glm::mat4 transform{1};
  glm::vec4 tint{0};  ///< linear rgb; a = how much of it instead of the material's base colour
  bool visible = true;
};

/// Every object as the file places it.
std::vector<ObjectState> initial_states(const Model& model);

}  // namespace fracture::render
