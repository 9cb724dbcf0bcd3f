#include "common/solid/solid.hpp"

namespace fracture {

nlohmann::json SolidReport::to_json() const {
  return {{"source_triangles", source_triangles},
          {"source_vertices", source_vertices},
          {"welded", welded},
          {"welded_tolerant", welded_tolerant},
          {"degenerate_dropped", degenerate_dropped},
          {"duplicates_dropped", duplicates_dropped},
          {"flipped", flipped},
          {"open_edges", open_edges},
          {"nonmanifold_edges", nonmanifold_edges},
          {"holes_filled", holes_filled},
          {"fill_triangles", fill_triangles},
          {"filled_area", filled_area},
          {"sheets_thickened", sheets_thickened},
          {"shells", shells},
          {"parts", parts},
          {"cavities", cavities},
          {"shells_dropped", shells_dropped},
          {"volume", volume},
          {"area", area},
          {"notes", notes}};
}

}  // namespace fracture
