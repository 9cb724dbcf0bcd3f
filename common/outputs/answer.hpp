// An answer as other files show it: what gltf_writer.hpp wrote, seen in its GLB without a copy. Reads what that writes and
// nothing else, whoever sent the bytes; other glTF is import's.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/vec.hpp"

namespace fracture::outputs {

/// Vectors of `width` floats in the answer's buffer.
class Floats {
 public:
  Floats() = default;
  Floats(const std::uint8_t* first, std::size_t count, std::size_t width, std::size_t stride)
      : first_(first), count_(count), width_(width), stride_(stride) {}

  bool empty() const { return count_ == 0; }
  std::size_t size() const { return count_; }
  std::size_t width() const { return width_; }
  float at(std::size_t vector, std::size_t component) const {
    float value = 0;
    std::memcpy(&value, first_ + vector * stride_ + component * sizeof value, sizeof value);
    return value;
  }
  Vec3f vec3(std::size_t vector) const { return {at(vector, 0), at(vector, 1), at(vector, 2)}; }
  friend bool operator==(const Floats&, const Floats&) = default;

 private:
  const std::uint8_t* first_ = nullptr;
  std::size_t count_ = 0, width_ = 0, stride_ = 0;
};

/// Unsigned integers of 2 or 4 bytes in the answer's buffer.
class Indices {
 public:
  Indices() = default;
  Indices(const std::uint8_t* first, std::size_t count, bool wide)
      : first_(first), count_(count), wide_(wide) {}

  std::size_t size() const { return count_; }
  std::uint32_t operator[](std::size_t k) const {
    std::uint32_t value = 0;  // the bytes are little-endian, as those of every machine that this runs on
    std::memcpy(&value, first_ + k * (wide_ ? 4 : 2), wide_ ? 4 : 2);
    return value;
  }

 private:
  const std::uint8_t* first_ = nullptr;
  std::size_t count_ = 0;
  bool wide_ = false;
};

inline constexpr std::size_t kNoMaterial = ~std::size_t{0};

struct Primitive {
  std::size_t material = kNoMaterial;
  Indices indices;  ///< three for each triangle, each of a vertex that is there
};

/// A fragment, or a part of the scene that was not fractured.
struct Object {
  std::string name;                 ///< no two objects have the same; ASCII letters, digits and _
  std::optional<std::uint64_t> id;  ///< of a fragment: extras.fracture.id; nothing: was not fractured
  Vec3f place;                      ///< of the node: what is added to its positions
  Floats positions, normals, colors;
  std::vector<Floats> uvs;
  std::vector<Primitive> primitives;
  /// EXT_mesh_manifold: corners, counted through all primitives, and the vertices that stand for theirs.
  bool manifold = false;
  Indices merge_corners, merge_vertices;

  /// In the frame of the scene, metres. Exact, as the pivots were chosen for that (I2): what two fragments share has
  /// the same bits in both.
  Vec3f position(std::size_t vertex) const {
    const Vec3f p = positions.vec3(vertex);
    return {p.x + place.x, p.y + place.y, p.z + place.z};
  }
  std::size_t triangles() const;
};

struct Map {
  std::size_t image = 0, uv_set = 0;
  double scale[2] = {1, 1}, offset[2] = {0, 0};  ///< KHR_texture_transform, without its rotation
};

/// What has no material has this one where there has to be one; no material of an answer is called so.
inline constexpr const char* kBareMaterial = "none";

/// Metallic and roughness as glTF 2.0 means them; colours are linear.
struct Material {
  std::string name;  ///< as Object::name
  Vec3d color{1, 1, 1}, emission{};
  double opacity = 1;
  std::optional<double> metallic,
      roughness;  ///< nothing: a texture says them, and the factors alone would mislead
  std::optional<Map> color_map, normal_map, emission_map;
};

struct Image {
  std::string ending;  ///< ".png", ".jpg", ".webp", ".ktx2"
  std::span<const std::uint8_t> bytes;
};

struct Answer {
  std::string generator;  ///< "fracture, algorithm 14"
  std::vector<Object> objects;
  std::vector<Material> materials;
  std::vector<Image> images;

  std::size_t vertices() const;
  std::size_t triangles() const;
};

/// How every answer of every version calls who made it.
inline constexpr const char* kGenerator = "fracture, algorithm ";

/// The bytes are borrowed. kInternal: they are no answer, and why.
Expected<Answer> read_answer(std::span<const std::uint8_t> glb);
Expected<Answer> read_answer(std::vector<std::uint8_t>&&) = delete;  // nobody would hold them

}  // namespace fracture::outputs
