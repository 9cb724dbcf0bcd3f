#include "common/pipeline/restrict.hpp"

namespace fracture {

RestrictedDiagram restrict_to_solid(const Solid& solid, const Solid& image, const VoronoiDiagram& diagram,
                                    const Execution& execution) {
  execution.reaches(0.3);
  RestrictedDiagram r{solid, diagram, cut_surface(image, diagram, execution), {}, {}, {}};
  execution.reaches(0.4);
  r.winding = wind_voronoi_edges(image, diagram, r.cuts, execution);
  execution.reaches(0.45);
  r.positions = place_vertices(solid, image, diagram, r.cuts, r.winding, execution);
  execution.reaches(0.55);
  r.caps = build_caps(solid, diagram, r.cuts, r.winding, r.positions, execution);
  return r;
}

}  // namespace fracture
