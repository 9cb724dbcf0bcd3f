// A mesh fractured with given parameters, for tests of the stages after the cells.
#pragma once

#include <algorithm>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/pipeline/refracture.hpp"

namespace fracture::test {

struct Fractured : FracturedSolid {
  Solid solid;
  Diagram diagram;
};

/// Throws std::runtime_error with the detail of any error.
inline Fractured fracture_solid(Solid solid, const FractureParameters& parameters, int threads = 1) {
  Execution execution;
  execution.threads = threads;
  StageTimings timings;
  Expected<Diagram> diagram = make_diagram(solid, parameters, execution, timings);
  if (!diagram) throw std::runtime_error(diagram.error().detail);
  Expected<FracturedSolid> made = fracture(solid, *diagram, parameters, execution, timings);
  if (!made) throw std::runtime_error(made.error().detail);
  return {std::move(*made), std::move(solid), std::move(*diagram)};
}
/// Uses no contact graph, so there are no bonds across parts.
inline Fractured fracture_mesh(const Mesh& mesh, const FractureParameters& parameters, int threads = 1) {
  Expected<Solid> solid = make_solid(std::make_shared<Mesh>(mesh), {}, {.threads = threads});
  if (!solid) throw std::runtime_error(solid.error().detail);
  return fracture_solid(std::move(*solid), parameters, threads);
}

/// The parts of one fragment of the answer. Throws in the same cases as fracture_mesh().
inline FracturedSolid fracture_mesh_again(const Mesh& mesh, const FractureParameters& parameters,
                                          const Refracture& again) {
  const Fractured whole = fracture_mesh(mesh, parameters);
  StageTimings timings;
  Expected<FracturedSolid> made = refracture(whole.solid, whole.diagram, parameters, again, {}, timings);
  if (!made) throw std::runtime_error(made.error().detail);
  return std::move(*made);
}

inline bool any_has(const std::vector<std::string>& sentences, std::string_view text) {
  return std::any_of(sentences.begin(), sentences.end(),
                     [&](const std::string& sentence) { return sentence.find(text) != std::string::npos; });
}
/// Whether one of the report's warnings, or one of its notes, contains this text.
inline bool warns(const Report& report, std::string_view of) { return any_has(report.remarks.warnings, of); }
inline bool has_note(const Report& report, std::string_view of) { return any_has(report.remarks.notes, of); }

/// The sites of a row of n equally long cells along x in the box.
inline std::vector<Vec3d> row_of_sites(const Box& box, int n) {
  std::vector<Vec3d> sites;
  for (int k = 0; k < n; ++k) {
    Vec3d p = box.center();
    p.x = box.min.x + (k + 0.5) * (box.max.x - box.min.x) / n;
    sites.push_back(p);
  }
  return sites;
}

}  // namespace fracture::test
