// Triangulation of polygons that two solids share. Two fragments that were cut apart have the same triangles there, once
// as they are and once mirrored. If both are cut again by the same planes, each is cut separately. So that the new
// triangles match again, the polygons are brought into an order that depends only on positions, not on ids or sides.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "common/clip/restricted_diagram.hpp"

namespace fracture {

/// Orders the polygons in mirrored triangles (Solid::mirrored). Borrows the diagram.
class MirroredRings {
 public:
  using Ring = std::vector<CutVertexId>;
  explicit MirroredRings(const RestrictedDiagram& diagram) : d_(diagram) {}

  bool is_mirrored(std::uint32_t triangle) const {
    return !d_.solid.mirrored.empty() && d_.solid.mirrored[triangle] != 0;
  }
  /// Whether the triangle is the one of its two mirror images whose polygons are reversed.
  bool is_reversed(std::uint32_t triangle) const {
    const std::array<CutVertexId, 3> corners = d_.corners(triangle);
    std::array<Vec3d, 3> at{place(corners[0]), place(corners[1]), place(corners[2])};
    std::rotate(at.begin(), std::min_element(at.begin(), at.end(), lexicographic_less), at.end());
    return lexicographic_less(at[2], at[1]);
  }
  /// Reverses the ring if wanted, and begins it at its least vertex. If several are at this position, the ones after
  /// them decide.
  void arrange(Ring& ring, bool reversed) const {
    if (reversed) std::reverse(ring.begin(), ring.end());
    std::size_t best = 0;
    for (std::size_t k = 1; k < ring.size(); ++k)
      if (is_less(ring, k, ring, best)) best = k;
    std::rotate(ring.begin(), ring.begin() + static_cast<std::ptrdiff_t>(best), ring.end());
  }
  /// Sorts rings that are arranged already.
  void sort(std::vector<Ring>& rings) const {
    std::sort(rings.begin(), rings.end(), [&](const Ring& a, const Ring& b) {
      return a.size() != b.size() ? a.size() < b.size() : is_less(a, 0, b, 0);
    });
  }
  /// The position in the file, in the frame of the source.
  Vec3d place(CutVertexId v) const {
    const VertexPositions& p = d_.positions;
    return v < p.first_constructed ? to_double(d_.solid.positions[v])
                                   : p.lattice.to_world(p.steps[v - p.first_constructed]);
  }

 private:
  /// Compares two rings of one size, from these vertices on.
  bool is_less(const Ring& a, std::size_t from_a, const Ring& b, std::size_t from_b) const {
    const std::size_t n = a.size();
    for (std::size_t k = 0; k < n; ++k) {
      const Vec3d x = place(a[(from_a + k) % n]), y = place(b[(from_b + k) % n]);
      if (lexicographic_less(x, y)) return true;
      if (lexicographic_less(y, x)) return false;
    }
    return false;
  }

  const RestrictedDiagram& d_;
};

}  // namespace fracture
