// The uses of each edge: every half-edge, sorted by its two vertices. Used for pairing, for finding
// duplicates, and for counting open and non-manifold edges.
#pragma once

#include <span>
#include <vector>

#include "common/base/execution.hpp"
#include "common/base/pacer.hpp"
#include "common/solid/surface.hpp"

namespace fracture::solid_detail {

/// One use of an edge {a, b}, a < b: the half-edge, and whether it goes from b to a.
struct EdgeUse {
  std::uint64_t bits;  ///< b << 32 | half-edge << 1 | backward: sorting by it groups the uses of an edge
  HalfEdge half_edge() const { return static_cast<std::uint32_t>(bits) >> 1; }
  bool backward() const { return bits & 1; }
  VertexId high_vertex() const { return VertexId{bits >> 32}; }
};

class EdgeTable {
 public:
  /// Sorts all half-edges: a counting sort by the lower vertex, then each bucket by (higher vertex,
  /// half-edge). So the cost is linear for ordinary surfaces, and n log n for a vertex that all triangles
  /// share. At most 2^31 half-edges.
  EdgeTable(const Surface& surface, const Execution& execution);

  /// Calls visit(a, b, uses) for every edge {a, b}, a < b, in ascending order; uses are sorted by half-edge.
  template <class Visit>
  void for_each(const Execution& execution, Visit&& visit) const {
    Pacer pacer(execution);
    for (const VertexId a : ids<VertexId>(start_.size() - 1)) {
      pacer.step();
      for (std::uint32_t i = start_[a]; i < start_[a + 1];) {
        std::uint32_t j = i + 1;
        while (j < start_[a + 1] && uses_[j].high_vertex() == uses_[i].high_vertex()) ++j;
        pacer.step(j - i);
        visit(a, uses_[i].high_vertex(), std::span<const EdgeUse>(uses_.data() + i, j - i));
        i = j;
      }
    }
  }

 private:
  std::vector<std::uint32_t> start_;
  std::vector<EdgeUse> uses_;
};

/// The fast path: glues a surface in which every edge is used exactly twice, in opposite directions. Uses a
/// chained list of edges per vertex, and each thread handles the edges of its own vertices. Returns false,
/// with undefined twins, if the surface is not like that, or if a vertex has so many edges that the lists
/// would cost more than sorting.
bool pair_closed_manifold(Surface& surface, const Execution& execution);

/// Glues every edge that is used exactly twice in opposite directions, and leaves the others open. Returns
/// true if there are no others: the surface is then a closed, oriented 2-manifold, except for vertices that
/// touch.
bool pair_clean_edges(Surface& surface, const EdgeTable& edges, const Execution& execution);

}  // namespace fracture::solid_detail
