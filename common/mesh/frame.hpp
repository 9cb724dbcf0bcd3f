// Units and axes: interprets a file's coordinates, and converts the mesh to metres with y up.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "common/base/error.hpp"
#include "common/mesh/mesh.hpp"

namespace fracture {

enum class LengthUnit { kFromFile, kMetre, kCentimetre, kMillimetre, kInch, kKilometre };
enum class UpAxis { kFromFile, kY, kZ };

/// Length of the unit in metres; 1 for kFromFile.
double metres_of(LengthUnit unit);

/// The request's statement about the input; it overrides the file.
struct FrameOptions {
  LengthUnit unit = LengthUnit::kFromFile;
  UpAxis up = UpAxis::kFromFile;
};

/// The interpretation of a file's coordinates.
struct FrameReport {
  enum class From { kAssumed, kFile, kRequest };

  double metres_per_unit = 1;
  From unit_from = From::kAssumed;
  bool z_up = false;  ///< otherwise y
  From up_from = From::kAssumed;
  /// The place of the answer's root node, in metres with y up: a position in the file is this plus the position below the
  /// root. Zero for meshes near the origin.
  Vec3d offset{};
  bool operator==(const FrameReport&) const = default;
};
/// Returns "assumed", "file" or "request".
const char* name_of(FrameReport::From from);
/// {metres_per_unit, unit_from, up, up_from}, and `offset` unless it is zero
void to_json(nlohmann::json& document, const FrameReport& frame);

/// "(x, y, z)", with the fewest digits that read back as the same numbers.
std::string to_text(const Vec3d& place);

/// Scales and rotates the mesh (positions, normals, tangents, the offset of its frame). z up becomes y up by a
/// quarter turn about x, which is exact. A unit other than the metre rounds each coordinate once. Afterwards,
/// `frame` says metres and y up. A mesh with an offset gets a note that states it. Returns the interpretation
/// used. Error: kNotFinite (with the vertex) if a scaled coordinate overflows.
Expected<FrameReport> to_metres_y_up(Mesh& mesh, const FrameOptions& options);

}  // namespace fracture
