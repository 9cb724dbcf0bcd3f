#include "common/solid/solid.hpp"

namespace fracture {

void SolidReport::add_sample(const char* figure, const Vec3f& place) {
  for (const Sample& sample : samples)
    if (sample.figure == figure) return;
  samples.push_back({figure, to_double(place)});
}

nlohmann::json SolidReport::to_json() const {
  nlohmann::json places = nlohmann::json::object();
  for (const Sample& sample : samples)
    places[sample.figure] = {sample.place.x, sample.place.y, sample.place.z};
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
          {"samples", std::move(places)},
          {"notes", notes}};
}

}  // namespace fracture
