// Attributes of one vertex, computed from the source's attributes.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "common/fragment/fragments.hpp"
#include "common/mesh/mesh.hpp"

namespace fracture {

/// A flat interior face: its unit normal and two unit vectors that span it. They depend only on the normal
/// and the grain. The bitangent lies along the grain (of unit length), so that a fibre texture does, too.
/// If the face is across the grain, the grain is ignored.
struct FlatFrame {
  Vec3d normal, tangent, bitangent;
  explicit FlatFrame(const Vec3d& unit_normal, const std::optional<Vec3d>& grain = std::nullopt);
};

/// Appends vertices to a fragment's attribute arrays: the source's arrays, and always at least one set of
/// UVs. Interior faces have planar UVs for every source. Exterior vertices of a source without UVs get
/// zeros.
class AttributeWriter {
 public:
  /// `count`: number of vertices that will be appended.
  AttributeWriter(const Attributes& source, Attributes& out, std::size_t count);

  /// Appends an exterior vertex of a source without attributes.
  void blank();
  /// Appends wedge w of the source, bit for bit.
  void copy(std::uint32_t w);
  /// Appends a weighted mean of three wedges (weights sum to 1). Normals and tangents are normalized.
  void blend(const std::array<std::uint32_t, 3>& wedges, const std::array<double, 3>& weights);
  /// Appends a vertex on an interior face, at world position p: planar UVs in metres, white. Its normal is
  /// `rough_normal`, or the face's if that is null.
  void interior(const FlatFrame& frame, const Vec3d& p, const Vec3d* rough_normal = nullptr);

 private:
  const Attributes& in_;
  Attributes& out_;
};

}  // namespace fracture
