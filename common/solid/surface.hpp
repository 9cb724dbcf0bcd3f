// The working form of make_solid(): an indexed surface that the stages weld, orient, pair, fill and split in
// place.
//
// Half-edge h = 3t + k is the directed edge of triangle t from corner k to corner (k + 1) % 3.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/base/execution.hpp"
#include "common/base/vec.hpp"
#include "common/mesh/mesh.hpp"
#include "common/solid/vertex_id.hpp"

namespace fracture::solid_detail {

using TriangleId = Id<struct SurfaceTriangleTag>;
inline constexpr TriangleId kNoTriangle{0xffffffffu};
using HalfEdge = std::uint32_t;
using Triangle = std::array<VertexId, 3>;

inline TriangleId triangle_of(HalfEdge h) { return TriangleId{h / 3}; }

inline HalfEdge next(HalfEdge h) { return h % 3 == 2 ? h - 2 : h + 1; }
inline HalfEdge previous(HalfEdge h) { return h % 3 == 0 ? h + 2 : h - 1; }

/// A number per half-edge; the three of a triangle are together.
struct HalfEdgeArray {
  std::vector<std::array<HalfEdge, 3>> of_triangle;

  static_assert(sizeof(std::array<HalfEdge, 3>) == 3 * sizeof(HalfEdge));
  std::size_t size() const { return 3 * of_triangle.size(); }
  HalfEdge& operator[](std::size_t h) { return reinterpret_cast<HalfEdge*>(of_triangle.data())[h]; }
  HalfEdge operator[](std::size_t h) const {
    return reinterpret_cast<const HalfEdge*>(of_triangle.data())[h];
  }
  bool operator==(const HalfEdgeArray&) const = default;
};
/// The values for a triangle whose half-edges are all open.
inline constexpr std::array<HalfEdge, 3> kThreeOpen{kNoIndex, kNoIndex, kNoIndex};

struct Surface {
  std::vector<Vec3f> positions;
  std::vector<Triangle> triangles;
  std::vector<std::uint32_t> source;  ///< per triangle: the source triangle; kNoIndex for fills
  /// Per triangle: whether corners 1 and 2 are swapped relative to the source. Empty if no triangle is flipped.
  std::vector<std::uint8_t> flipped;
  HalfEdgeArray twin;  ///< per half-edge: the opposite half-edge glued to it; kNoIndex if open

  VertexId from(HalfEdge h) const { return triangles[h / 3][h % 3]; }
  VertexId to(HalfEdge h) const { return triangles[h / 3][(h % 3 + 1) % 3]; }
  VertexId apex(HalfEdge h) const { return triangles[h / 3][(h % 3 + 2) % 3]; }
  void flip(TriangleId t) {
    if (flipped.empty()) flipped.assign(triangles.size(), 0);
    std::swap(triangles[t][1], triangles[t][2]);
    flipped[t] ^= 1;
  }
  /// Removes the triangles with a nonzero entry, keeping the order of the others. Twins become invalid.
  void remove(const std::vector<std::uint8_t>& doomed, const Execution& execution);
};

/// Area of a triangle, m².
inline double area_of(const Surface& surface, std::size_t triangle) {
  const Triangle& c = surface.triangles[triangle];
  const Vec3d a = to_double(surface.positions[c[0]]);
  return 0.5 * length(cross(to_double(surface.positions[c[1]]) - a, to_double(surface.positions[c[2]]) - a));
}

}  // namespace fracture::solid_detail
