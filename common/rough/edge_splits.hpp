// Divides the pieces of Voronoi edges inside the solid, which several caps share, into equal parts. The
// positions depend only on the rounded positions of the two ends. So all caps at a piece agree, and so do
// coinciding pieces with different keys (lattices), bit for bit.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "common/clip/positions.hpp"
#include "common/clip/winding.hpp"

namespace fracture {

class EdgeSplits {
 public:
  /// Divides the pieces that bound a facet with `wanted(lo, hi)` and no facet with `plain(lo, hi)` into parts no
  /// longer than `length` (m). Appends the new vertices to `positions`. Throws Interrupted.
  EdgeSplits(const Winding& winding, double length, const std::function<bool(SiteId, SiteId)>& wanted,
             const std::function<bool(SiteId, SiteId)>& plain, VertexPositions& positions,
             const Execution& execution);

  /// Appends the vertices strictly between a and b, in this order. Appends none if (a, b) is not a divided
  /// piece.
  void between(CutVertexId a, CutVertexId b, std::vector<CutVertexId>& out) const;

 private:
  struct Edge {
    CutVertexId from, to;  // in lexicographic order of their positions
    CutVertexId first;     // the first of `count` consecutive vertices
    std::uint32_t count;
  };
  const Edge* find(CutVertexId a, CutVertexId b) const;

  std::vector<Edge> edges_;
};

/// The point of the seam lattice nearest to p.
std::array<std::int32_t, 3> nearest_steps(const SeamLattice& lattice, const Vec3d& p);

/// Appends a vertex at p, rounded to the seam lattice.
CutVertexId append_vertex(VertexPositions& positions, const Vec3d& p);

}  // namespace fracture
