// Determines the order of a triangle's cuts.
#include <algorithm>

#include "common/clip/polygon_clipper.hpp"

namespace fracture {

// Cuts are found by a walk. If only some cells are known (in a hit's part of a diagram), it goes other ways.
void PolygonClipper::number_cuts_by_sites(std::size_t first_vertex) {
  const auto first = out_.triangle_cuts.begin() + static_cast<std::ptrdiff_t>(first_c_);
  const auto by_sites = [](const TriangleCut& a, const TriangleCut& b) { return a.sites < b.sites; };
  if (std::is_sorted(first, out_.triangle_cuts.end(), by_sites)) return;
  cuts_before_.assign(first, out_.triangle_cuts.end());
  sort_with_polls(execution_, first, out_.triangle_cuts.end(), by_sites);
  number_now_.clear();
  for (const TriangleCut& cut : cuts_before_) {
    pacer_.step(4);
    number_now_.push_back(static_cast<std::uint32_t>(
        std::lower_bound(first, out_.triangle_cuts.end(), cut, by_sites) - out_.triangle_cuts.begin()));
  }
  pacer_.each(first_vertex, out_.vertices.size(), [&](std::size_t k) {
    CutVertexId& v = out_.vertices[k];
    if (v & kBlockLocalC) v = CutVertexId{kBlockLocalC | number_now_[(v & ~kBlockLocalC) - first_c_]};
  });
}

}  // namespace fracture
