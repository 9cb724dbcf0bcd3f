// Replaces several polygons of one input triangle by new triangles: a triangulation of their union, without
// the vertices that only separated them.
#pragma once

#include <cstdint>
#include <vector>

#include "common/clip/triangulate.hpp"
#include "common/fragment/mirrored_ring.hpp"
#include "common/fragment/pieces.hpp"

namespace fracture {

/// Fuses polygons in one triangle after another and reuses its buffers.
class Outline {
 public:
  /// Both are borrowed.
  explicit Outline(const RestrictedDiagram& diagram, const Execution& execution)
      : d_(diagram), execution_(execution), mirrored_(diagram) {}

  void clear() { sides_.clear(); }
  /// Adds a directed side of the outline. In a generic diagram, one side starts at each vertex.
  void add(CutVertexId from, CutVertexId to) { sides_.push_back({from, to, false}); }
  /// Appends triangles that cover the area enclosed by the sides in triangle t. A vertex between two sides
  /// along the same edge of t is left out, because the edge is no longer cut there. Both triangles at the
  /// edge agree on this, because the polygons on both sides of such a vertex are connected by volume around
  /// it. If the sides enclose all of t, appends t unchanged. Throws Interrupted, and InternalError if the
  /// sides do not form closed loops.
  void triangulate_into(std::uint32_t t, std::vector<Face>& out);

 private:
  struct Side {
    CutVertexId from, to;
    bool used;
  };
  std::size_t leaving(CutVertexId v, std::uint32_t t) const;
  bool lies_on(CutVertexId v, std::uint32_t edge) const;
  bool is_straight(CutVertexId before, CutVertexId v, CutVertexId after) const;
  void arrange_loops(bool reversed);
  void project(std::uint32_t t, bool reversed);

  const RestrictedDiagram& d_;
  const Execution& execution_;
  const MirroredRings mirrored_;
  std::vector<Side> sides_;
  std::vector<CutVertexId> ring_, loop_;
  std::vector<std::uint32_t> loop_begin_;
  std::vector<LatticePoint> points_;
  Triangulation triangulation_;
};

}  // namespace fracture
