// A glTF file in the renderer's form: one vertex and one index array for everything, objects that move as a
// whole (such as fragments), and surfaces, which are the triangles of one object with one material. Plain
// data; no OpenGL.
//
//   Model ── objects[k]   position, fragment information, surfaces
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
  glm::vec4 tangent{};       ///< xyz unit length, w = ±1; all zero if the file has none
  glm::vec2 uv[2]{};         ///< TEXCOORD_0 and _1, v down
  glm::u8vec4 color{255};    ///< COLOR_0, linear, 0 … 255
  std::uint32_t object = 0;  ///< index into Model::objects
};

enum class AlphaMode { kOpaque, kMask, kBlend };

/// One texture slot of a material. Filters and wraps are glTF's numbers, which OpenGL shares.
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
  bool interior = false;  ///< of cut faces, as the service's file states
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
  glm::vec3 centroid{};  ///< centre of mass, in the world when loaded
  std::vector<std::uint32_t>
      ancestors;  ///< nodes of the hierarchy, from the coarsest to the fragment's own node
};

struct Sphere {
  glm::vec3 center{};
  float radius = 0;
};

/// Position of a look's solid texture (looks.hpp), in the frame of the file.
struct SolidPlacement {
  Sphere frame;              ///< the texture fills this sphere
  glm::vec3 grain{0, 1, 0};  ///< direction of the wood's grain
  /// Bricks of this size in courses, from `brick_low` to `brick_high`, along x and up y. Every other course
  /// is shifted by half a brick. 0: none.
  glm::vec2 brick{0}, brick_low{0}, brick_high{0};
};

struct Object {
  std::string name;
  glm::mat4 transform{1};  ///< object to world when loaded
  Sphere bounds;           ///< of its vertices, in the object's frame
  std::optional<FragmentInfo> fragment;
  std::optional<SolidPlacement> solid;  ///< empty: placed around the whole model
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
  std::vector<Picture> pictures;    ///< decoded; one grey pixel for each that could not be decoded
  std::vector<std::string> warnings;
};

/// Reads a GLB, or a glTF document with embedded buffers. The mesh gets the checks of an upload (lengths,
/// indices, extensions; common/import), and positions must be finite. The outside of mirrored nodes stays
/// outside. Missing normals become flat. Nodes called UCX_… (collision hulls) are left out. Images other than
/// PNG and JPEG, and material extensions beyond transmission and ior, are left out with a warning.
/// kMalformedMesh, kEmptyMesh, kNotFinite, kTooLarge, and errors of common/import.
enum class Placed {
  kAsInFile,
  kNearOrigin,  ///< a scene far from the origin is moved to it before its places become floats
};
Expected<Model> read_model(std::span<const std::byte> bytes, Placed placed = Placed::kAsInFile);

/// Calls read_model with a file's bytes, near the origin; kFileAccess if it cannot be read.
Expected<Model> load_model(const std::string& path);

/// The smallest sphere around the bounding box of all visible objects. If `states` is empty, the model's own
/// transforms are used. Radius 0 if there are none.
struct ObjectState;
Sphere bounding_sphere(const Model& model, std::span<const ObjectState> states);

/// An object's place in a picture, and a colour over its material.
struct ObjectState {
  glm::mat4 transform{1};
  glm::vec4 tint{0};  ///< linear rgb; a = the share that replaces the material's base colour
  bool visible = true;
};

/// Every object where the file places it.
std::vector<ObjectState> initial_states(const Model& model);

}  // namespace fracture::render
