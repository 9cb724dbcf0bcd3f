// What several polygons of one input triangle cover together, as new triangles: the outline of their union,
// triangulated, without the vertices that only separated them.
#pragma once

#include <cstdint>
#include <vector>

#include "common/clip/triangulate.hpp"
#include "common/fragment/pieces.hpp"

namespace fracture {

/// Fuses within one triangle after the other; keeps its buffers between them.
class Outline {
 public:
  /// Both are borrowed.
  explicit Outline(const RestrictedDiagram& diagram, const Execution& execution)
      : d_(diagram), execution_(execution) {}

  void clear() { sides_.clear(); }
  /// A directed side of the outline. In a generic diagram a vertex is left by one side.
  void add(CutVertexId from, CutVertexId to) { sides_.push_back({from, to, false}); }
  /// Appends the triangles of what the sides enclose in triangle t. A vertex between two sides along the same
  /// edge of t is left out: the edge is not cut there any more. Both triangles at the edge agree about that,
  /// because what lies on the two sides of such a vertex hangs together by volume around it. The whole
  /// triangle comes back as it was. Throws Interrupted, and InternalError when the sides do not chain into
  /// loops.
  void triangulate_into(std::uint32_t t, std::vector<Face>& out);

 private:
  struct Side {
    CutVertexId from, to;
    bool used;
  };
  std::size_t leaving(CutVertexId v, std::uint32_t t) const;
  bool lies_on(CutVertexId v, std::uint32_t edge) const;
  bool is_straight(CutVertexId before, CutVertexId v, CutVertexId after) const;
  void project(std::uint32_t t);

  const RestrictedDiagram& d_;
  const Execution& execution_;
  std::vector<Side> sides_;
  std::vector<CutVertexId> ring_, loop_;
  std::vector<std::uint32_t> loop_begin_;
  std::vector<LatticePoint> points_;
  Triangulation triangulation_;
};

}  // namespace fracture
