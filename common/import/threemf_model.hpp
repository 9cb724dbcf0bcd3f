// The model parts of a 3MF package: resources and build items, with all references resolved to numbers.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/id.hpp"
#include "common/base/vec.hpp"
#include "common/import/transform.hpp"

namespace fracture::threemf {

/// A list of properties that triangles refer to: base materials, colours or texture coordinates.
struct PropertyGroup {
  std::vector<std::uint32_t> materials;  ///< per property: index into ModelPart::materials
  std::vector<Vec2f> uvs;                ///< per property, with v down; empty if the group has no texture
};

/// A material in the file's words.
struct Material {
  std::string name;
  std::string color;    ///< "#RRGGBB" or "#RRGGBBAA" in sRGB; empty: none
  std::string texture;  ///< path of an image in the package; empty: none
};

/// An object inside another one, or a build item.
struct Instance {
  std::string part;  ///< path of the model part that has the object; empty: the same part
  std::uint32_t object = 0;
  Transform transform{};
};

struct Object {
  std::string name, type;
  std::vector<Vec3d> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::uint32_t> materials;   ///< per triangle: index into ModelPart::materials, or kNoIndex
  std::vector<std::array<Vec2f, 3>> uvs;  ///< per triangle; empty if no triangle has a texture
  std::vector<Instance> components;
};

struct ModelPart {
  double metres = 1e-3;  ///< per unit of the coordinates
  std::vector<Material> materials;
  std::map<std::uint32_t, Object> objects;
  std::vector<Instance> build;
  std::uint64_t blended = 0;  ///< triangles whose corners have different colours or materials
  std::uint64_t unread = 0;   ///< triangles with properties of a kind that is not supported
};

/// Returns the local path of a part: without the leading slash.
std::string part_path(std::string_view target);

/// Reads a model part (3MF Core Specification 1.3, Materials and Properties Extension 1.2, Production Extension 1.1).
/// `path` is for messages. Throws Refused: kMalformedMesh with the byte; kUnsupportedFeature if the part requires an
/// extension that changes its shape.
ModelPart read_model_part(std::string_view text, const std::string& path);

}  // namespace fracture::threemf
