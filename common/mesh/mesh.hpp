// The mesh as every importer delivers it and as the exporter needs it back: triangles over *wedges* (a wedge
// is one vertex of the file: a position with one set of attributes; glTF splits a vertex into several wedges
// along seams), material slots in source order, and the source's materials, textures and images untouched.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/base/id.hpp"
#include "common/base/remarks.hpp"
#include "common/base/vec.hpp"

namespace fracture {

/// Per-wedge attributes. Each array is empty when no surface of the mesh has the attribute, else as long as
/// Mesh::positions (surfaces that lack it are filled with zeros, colours with ones).
struct Attributes {
  std::vector<Vec3f> normals;              ///< unit length
  std::vector<Vec4f> tangents;             ///< xyz unit length, w = +1 or -1 (handedness)
  std::vector<std::vector<Vec2f>> uvs;     ///< uvs[set][wedge]
  std::vector<std::vector<Vec4f>> colors;  ///< colors[set][wedge], linear RGBA
};

/// Linear red, green, blue: 65535 is 1.
using LinearColor = std::array<std::uint16_t, 3>;

/// What colour a piece of surface has on the whole.
struct SurfaceColor {
  LinearColor light{};
  std::uint16_t known = 0;  ///< 1, or 0: nothing says what it is
  friend bool operator==(const SurfaceColor&, const SurfaceColor&) = default;
};

struct MaterialLibrary;  // mesh/material_library.hpp
/// One without materials.
std::shared_ptr<const MaterialLibrary> empty_library();

/// What the coordinates of an imported mesh mean, as far as its file or its format says so.
struct SourceFrame {
  double metres = 1;           ///< metres in one unit of the coordinates, > 0
  bool metres_stated = false;  ///< false: nothing says so, metres are assumed
  bool z_up = false;           ///< z is up and y points away; else y is up
  bool up_stated = false;      ///< false: nothing says so, y is assumed
};

struct Mesh {
  /// Per wedge, right-handed, in the frame of the scene's root: metres and y up, for an imported mesh once
  /// to_metres_y_up() (mesh/frame.hpp) has seen it.
  std::vector<Vec3f> positions;
  SourceFrame frame;
  Attributes attributes;
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< wedge ids, counter-clockwise seen from outside
  std::vector<std::uint32_t> material;  ///< per triangle: index into library->materials, or kNoIndex
  std::vector<std::uint32_t> node;      ///< per triangle: index into node_names
  std::vector<std::string> node_names;  ///< the source's mesh instances, UTF-8, may repeat
  std::vector<SurfaceColor>
      triangle_color;  ///< per triangle (surface_color/surface_colors.hpp); empty: none known
  std::shared_ptr<const MaterialLibrary> library = empty_library();
  std::string copyright;  ///< asset.copyright of the source, passed on
  /// The rest of the scene, which is not to be fractured (mesh/selection.hpp): written whole beside the
  /// fragments. Same frame, node_names and library. Null when there is none.
  std::shared_ptr<const Mesh> passed_through;
  Remarks remarks;  ///< what the importer changed or left out (skins baked, animations left out, …)
};

}  // namespace fracture
