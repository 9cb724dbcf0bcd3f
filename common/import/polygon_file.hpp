// The content of an STL, PLY or OFF file before it becomes a Mesh. The readers fill it in, and finish_polygon_file() does the rest
// for all of them: it divides polygons, rounds positions and merges equal wedges.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/remarks.hpp"
#include "common/base/vec.hpp"
#include "common/import/file_positions.hpp"
#include "common/import/import_input.hpp"
#include "common/import/text_scanner.hpp"
#include "common/mesh/dropped.hpp"
#include "common/mesh/material_library.hpp"
#include "common/mesh/mesh.hpp"

namespace fracture {

struct PolygonFile {
  /// A named solid of the file: the vertices and faces between the previous part's end and its own.
  struct Part {
    std::string name;  ///< as in the file; empty if it has none
    std::size_t vertex_end = 0, face_end = 0;
  };

  FilePositions positions;  ///< per vertex, as the file states them
  /// Per vertex, or empty. Texture coordinates as in the file, whose v axis points up.
  std::vector<Vec3f> normals;
  std::vector<Vec2f> uvs;
  std::vector<Vec4f> colors;
  std::vector<std::uint32_t>
      corners;  ///< the vertices of all faces, face after face; each face has at least 3
  std::vector<std::uint32_t> face_end;  ///< per face: the end of its corners
  std::vector<Vec2f> corner_uvs;        ///< per corner, or empty; used instead of uvs
  std::vector<std::uint32_t>
      face_material;  ///< per face: index into library.materials; empty: all faces have `material`
  std::uint32_t material = kNoIndex;
  std::vector<Part> parts;
  MaterialLibrary library;
  Remarks remarks;
  std::vector<Dropped> dropped;
  FilePlaces places;
  /// Vertices whose position does not fit in floats, and their places in the file. In order.
  std::vector<std::pair<std::size_t, std::size_t>> not_finite;

  /// Adds a vertex that is at `place` in the file.
  void add_position(const Vec3d& position, std::size_t place);
  /// Adds a corner. Refuses a vertex that does not exist (kMalformedMesh): `vertex` must be in [0, count).
  void add_corner(double vertex, std::size_t count, std::size_t place);
  /// Refuses a face with so many corners that its triangles would exceed the limit (kTooLarge), before they are added.
  void limit_corners(std::uint64_t count, const ImportLimits& limits) const;
  /// Ends the face of the corners that were added last. Drops points and lines. Refuses more triangles than the limit.
  void end_face(const ImportLimits& limits);
  /// Ends the part of everything added since the previous part.
  void end_part(std::string name);

  std::uint64_t triangles = 0;  ///< of all faces
};

/// Refuses a file that declares more faces than triangles are allowed (kTooLarge).
void limit_faces(std::uint64_t faces, const ImportLimits& limits);
/// Refuses a file that declares more vertices than the Mesh may hold (kTooLarge). `bytes`: of one vertex in the Mesh.
void limit_vertices(std::uint64_t vertices, std::uint64_t bytes, const ImportLimits& limits);

/// The material of a file that has none: not metallic, visible from both sides.
nlohmann::json plain_material(const std::array<double, 3>& color);

/// Makes the Mesh. Far coordinates get an offset (SourceFrame::offset), one for the whole file. Errors: kNotFinite with the vertex and its place, kTooLarge, kEmptyMesh.
Expected<Mesh> finish_polygon_file(PolygonFile file, const ImportLimits& limits);

}  // namespace fracture
