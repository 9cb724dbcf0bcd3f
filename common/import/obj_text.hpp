// The content of an OBJ file, as its statements give it. Specification: Wavefront Technologies, "Advanced Visualizer", appendix
// B1 (Object Files), version 3.0. Faces with positions, texture coordinates and normals are read; the other kinds of geometry
// have no surface, or only a free-form one, and are counted.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/vec.hpp"
#include "common/import/file_positions.hpp"
#include "common/import/import_input.hpp"
#include "common/import/obj_materials.hpp"

namespace fracture {

/// Consecutive faces of one object with one material.
struct ObjRun {
  std::uint32_t object = 0;    ///< index into ObjText::objects
  std::uint32_t material = 0;  ///< number in ObjMaterials, or kNoIndex
  std::uint32_t face = 0;      ///< the first one; the last one is before the first of the next run
  std::uint32_t corner = 0;    ///< the first one of this face
};

/// The highest index that faces use before the file has so many values, and the line of such a face. Faces may use values
/// that follow, so this is judged at the end of the file.
struct ObjHighest {
  std::uint64_t index = 0;  ///< from 0; meaningful if the line is not 0
  std::uint64_t line = 0;
};

/// Statements of one kind that are left out.
struct ObjLeftOut {
  const char *what, *reason;
  std::uint64_t count = 0, line = 0;  ///< the line of the first
};

struct ObjText {
  FilePositions positions;
  std::vector<Vec4f> colors;  ///< per position, white if it has none; empty if no position has one
  std::vector<Vec2f> uvs;     ///< v up, as in the file
  std::vector<Vec3f> normals;
  /// Per corner of a face: indices from 0, kNoIndex for none. `uv` and `normal` are empty if no face has any. Indices of
  /// positions are valid. Those of texture coordinates and normals may be too high.
  std::vector<std::uint32_t> position, uv, normal;
  std::vector<std::uint32_t> corners_of_face;  ///< at least 3 each
  std::vector<ObjRun> runs;                    ///< in the order of the file
  std::vector<std::string> objects;            ///< names, including those of objects and groups without faces
  ObjHighest highest_uv, highest_normal;
  std::vector<ObjLeftOut> left_out;
  std::uint64_t triangles = 0;
};

/// Reads the text in time linear in its length, and collects its materials. A group (`g`) begins an object unless the group
/// before it has the same name. `o` continues an object of the same name, if there is one. Throws Refused, with the line:
/// kMalformedMesh, kNotFinite (the position of a corner), kUnsupportedFeature (there is only a free-form surface), kEmptyMesh,
/// kTooLarge (more triangles than the limit, or lists larger than max_decoded_bytes).
ObjText read_obj_text(std::string_view text, const ImportLimits& limits, ObjMaterials& materials);

}  // namespace fracture
