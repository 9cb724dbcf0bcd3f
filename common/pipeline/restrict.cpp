#include "common/pipeline/restrict.hpp"

namespace fracture {

RestrictedDiagram restrict_to_solid(const Solid& solid, const Solid& image, const VoronoiDiagram& diagram,
                                    const Execution& execution) {
  RestrictedDiagram r{solid, diagram, cut_surface(image, diagram, execution), {}, {}, {}};
  r.winding = wind_voronoi_edges(image, diagram, r.cuts, execution);
  r.positions = place_vertices(solid, image, diagram, r.cuts, r.winding, execution);
  r.caps = build_caps(solid, diagram, r.cuts, r.winding, r.positions, execution);
  return r;
}

}  // namespace fracture
