// Finds where a mesh edge goes from cell to cell.
#pragma once

#include <vector>

#include "common/base/pacer.hpp"
#include "common/clip/surface_cuts.hpp"

namespace fracture {

/// Walks along one edge after another, starting in the cell of its lower vertex.
class EdgeWalk {
 public:
  EdgeWalk(const Solid& solid, const VoronoiDiagram& diagram, const std::vector<SiteId>& label,
           const Execution& execution)
      : solid_(solid), diagram_(diagram), label_(label), pacer_(execution) {}

  /// Appends the cuts of edge e, in order; none if both ends are in one cell. Throws Interrupted.
  void cut(std::uint32_t e, std::vector<EdgeCut>& cuts);

 private:
  // A bisector that the edge's second end is beyond, with its values at both ends, which determine the
  // crossing. Up to their error, at_a > 0 > at_b.
  struct Exit {
    const Bisector* bisector = nullptr;
    double at_a, at_b;
  };

  Exit exit_of(SiteId cell, const Bisector& bisector) const {
    return {&bisector, diagram_.value(cell, bisector, a_), diagram_.value(cell, bisector, b_)};
  }
  static Certified value(const Exit& of, const Exit& at);
  static int certain_side(const Exit& of, const Exit& at);
  int exact_side(SiteId cell, const Exit& of, const Exit& at) const;
  SiteId first_of_all(SiteId cell);
  SiteId first_by_search(SiteId cell);
  Exit earlier_by_tree(SiteId cell, const Exit& at);

  const Solid& solid_;
  const VoronoiDiagram& diagram_;
  const std::vector<SiteId>& label_;
  Pacer pacer_;
  Vec3d a_, b_;  // ends of the current edge
  std::vector<Exit> doubts_;
  SiteId ray_cell_ = kNoSite;  // where the last ray left a cell with many neighbours; a guess for the next
  std::uint32_t ray_ = 0;
};

}  // namespace fracture
