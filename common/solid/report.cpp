#include <nlohmann/json.hpp>
#include <type_traits>

#include "common/solid/polled.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

void SolidReport::add_sample(const char* figure, const Vec3f& place) {
  for (const Sample& sample : samples)
    if (sample.figure == figure) return;
  samples.push_back({figure, to_double(place)});
}

Remarks Solid::remarks() const {
  Remarks all = source ? source->remarks : Remarks{};
  all.add(report.remarks);
  return all;
}

void measure_edges(Solid& solid, const Execution& execution) {
  double sum = 0;
  solid_detail::for_each_polled(execution, solid.edge_vertices.size(), [&](std::size_t e) {
    const auto& [a, b] = solid.edge_vertices[e];
    sum += length(to_double(solid.positions[b]) - to_double(solid.positions[a]));
  });
  solid.report.edge_length = sum;
}

nlohmann::json SolidReport::to_json() const {
  nlohmann::json document;
  each_figure([&](const char* name, const auto& figure) {
    if constexpr (std::is_same_v<decltype(figure), const std::vector<Sample>&>) {
      nlohmann::json& places = document[name] = nlohmann::json::object();
      for (const Sample& sample : figure)
        places[sample.figure] = {sample.place.x, sample.place.y, sample.place.z};
    } else {
      document[name] = figure;
    }
  });
  return document;
}

}  // namespace fracture
