// Who uses which edge: every half-edge sorted by its two vertices. The basis of pairing, of duplicate search
// and of every count of open and non-manifold edges.
#pragma once

#include <span>
#include <vector>

#include "common/base/execution.hpp"
#include "common/base/pacer.hpp"
#include "common/solid/surface.hpp"

namespace fracture::solid_detail {

/// One use of an edge {a, b}, a < b: the half-edge, and whether it runs from b to a.
struct EdgeUse {
  std::uint64_t bits;  ///< b << 32 | half-edge << 1 | backward: sorting by it groups the uses of an edge
  HalfEdge half_edge() const { return static_cast<std::uint32_t>(bits) >> 1; }
  bool backward() const { return bits & 1; }
  VertexId high_vertex() const { return VertexId{bits >> 32}; }
};

class EdgeTable {
 public:
  /// Sorts all half-edges: a counting sort by the lower vertex, then each bucket by (higher vertex,
  /// half-edge), so the cost is linear for surfaces and n log n for a vertex that all triangles share. At
  /// most 2^31 half-edges.
  EdgeTable(const Surface& surface, const Execution& execution);

  /// Calls visit(a, b, uses) for every edge {a, b}, a < b, in ascending order; uses ascend by half-edge.
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

/// The fast path: glues a surface whose every edge is used exactly twice in opposite directions, by chained
/// lists of edges per vertex; each thread has the edges of its own vertices. Returns false, with the twins
/// undefined, when the surface is not such a one (or a vertex has so many edges that the lists would cost more
/// than sorting).
bool pair_closed_manifold(Surface& surface, const Execution& execution);

/// Glues every edge that is used exactly twice in opposite directions and leaves the others open. Returns
/// true when that was all of them: the surface is a closed, oriented 2-manifold but for touching vertices.
bool pair_clean_edges(Surface& surface, const EdgeTable& edges, const Execution& execution);

}  // namespace fracture::solid_detail
