// The attributes of one vertex, as the assembler makes them up from the source's.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "common/fragment/fragments.hpp"
#include "common/mesh/mesh.hpp"

namespace fracture {

/// A flat interior face: its unit normal and two unit vectors that span it, functions of the normal and the grain alone.
/// The second lies along the grain (of unit length), so that a texture of fibres does, too; not where the face is across it.
struct FlatFrame {
  Vec3d normal, tangent, bitangent;
  explicit FlatFrame(const Vec3d& unit_normal, const std::optional<Vec3d>& grain = std::nullopt);
};

/// Appends vertices to a fragment's attribute arrays: those of the source, and always one set of UVs
/// (interior faces have planar UVs whatever the source; exterior vertices of a source without UVs get zeros).
class AttributeWriter {
 public:
  /// `count`: of the vertices that will be appended.
  AttributeWriter(const Attributes& source, Attributes& out, std::size_t count);

  /// An exterior vertex of a source without attributes.
  void blank();
  /// Wedge w of the source, bit for bit.
  void copy(std::uint32_t w);
  /// A weighted mean of three wedges (weights sum to 1); normals and tangents made unit again.
  void blend(const std::array<std::uint32_t, 3>& wedges, const std::array<double, 3>& weights);
  /// A vertex on an interior face, at world position p: planar UVs in metres, white. Its normal is the
  /// face's, or that of a rough face there.
  void interior(const FlatFrame& frame, const Vec3d& p, const Vec3d* rough_normal = nullptr);

 private:
  const Attributes& in_;
  Attributes& out_;
};

}  // namespace fracture
