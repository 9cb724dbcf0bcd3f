#include "common/clip/restricted_diagram.hpp"

namespace fracture {

void RestrictedDiagram::place_and_cap(const Execution& execution,
                                      const std::vector<char>* cells_of_interest) {
  execution.reaches(0.45);
  positions = place_vertices(solid, seen, diagram, cuts, winding, execution);
  execution.reaches(0.55);
  caps = build_caps(solid, diagram, cuts, winding, positions, execution, cells_of_interest);
}

RestrictedDiagram restrict_to_solid(const SeenSolid& solid, const VoronoiDiagram& diagram,
                                    const Execution& execution) {
  execution.reaches(0.3);
  RestrictedDiagram r{solid.original(), solid.seen(), diagram, cut_surface(solid.seen(), diagram, execution)};
  execution.reaches(0.4);
  r.winding = wind_voronoi_edges(r.seen, diagram, r.cuts, execution);
  r.place_and_cap(execution);
  return r;
}

}  // namespace fracture
