// Reads an answer written by gltf_writer.hpp from its GLB, without a copy, to convert it to other formats. It
// accepts only the output of that writer, whatever the source of the bytes. The module import reads other
// glTF files.
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
#include "common/base/similarity.hpp"
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
    std::uint32_t value = 0;  // the bytes are little-endian, like every supported machine
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
  Indices indices;  ///< three per triangle; each refers to an existing vertex
};

/// A fragment, the sheets that a fragment carries, or a part of the scene that was not fractured.
struct Object {
  std::string name;                 ///< unique among objects (kept_name())
  std::optional<std::uint64_t> id;  ///< for a fragment: extras.fracture.id; none: another object
  bool carried = false;             ///< sheets of the fragment before it
  Vec3f place;                      ///< translation of the node below the root, added to its positions
  /// Rotation, scale and translation of the node of an instance; none: only `place`
  std::optional<Similarity> turned{};
  Floats positions, normals, colors;
  std::vector<Floats> uvs;
  std::vector<Primitive> primitives;
  /// EXT_mesh_manifold: corners, counted through all primitives, and the vertices that replace theirs.
  bool manifold = false;
  Indices merge_corners, merge_vertices;

  /// Position in the frame of the root node, metres. Exact, because the pivots were chosen for this (I2): points
  /// that two fragments share have the same bits in both. Instances share no points; theirs are rounded.
  Vec3f position(std::size_t vertex) const {
    const Vec3f p = positions.vec3(vertex);
    if (turned) return rounded(turned->point(to_double(p)));
    return {p.x + place.x, p.y + place.y, p.z + place.z};
  }
  /// Normal in the frame of the scene.
  Vec3f normal(std::size_t vertex) const {
    const Vec3f n = normals.vec3(vertex);
    return turned ? rounded(rotated(turned->rotation, to_double(n))) : n;
  }
  static Vec3f rounded(const Vec3d& v) {
    return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
  }
  std::size_t triangles() const;
};

struct Map {
  std::size_t image = 0, uv_set = 0;
  double scale[2] = {1, 1}, offset[2] = {0, 0};  ///< KHR_texture_transform, without rotation
};

/// Name of the material for objects without one, if a format requires a name. No material of an answer has
/// this name.
inline constexpr const char* kBareMaterial = "none";

/// Metallic and roughness as in glTF 2.0; colours are linear.
struct Material {
  std::string name;  ///< like Object::name
  Vec3d color{1, 1, 1}, emission{};
  double opacity = 1;
  std::optional<double> metallic,
      roughness;  ///< none: a texture defines them, and the factors alone would be wrong
  std::optional<Map> color_map, normal_map, emission_map;
};

struct Image {
  std::string ending;  ///< ".png", ".jpg", ".webp", ".ktx2"
  std::span<const std::uint8_t> bytes;
};

struct Answer {
  std::string generator;  ///< "fracture, algorithm 14"
  /// Translation of the root node, m. Not in Object::place, because floats are too coarse at that distance from the origin.
  Vec3d offset{};
  std::vector<Object> objects;
  std::vector<Material> materials;
  std::vector<Image> images;

  /// "offset (x, y, z)" with the fewest digits that read back as the same numbers; empty if the offset is zero.
  std::string offset_text() const;
  std::size_t vertices() const;
  std::size_t triangles() const;
};

/// The beginning of `generator` in every answer of every version.
inline constexpr const char* kGenerator = "fracture, algorithm ";

/// Reads an answer; the bytes are borrowed. Error: kInternal, with the reason, if the bytes are not an
/// answer.
Expected<Answer> read_answer(std::span<const std::uint8_t> glb);
Expected<Answer> read_answer(std::vector<std::uint8_t>&&) = delete;  // would dangle

}  // namespace fracture::outputs
