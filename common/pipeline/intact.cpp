#include "common/pipeline/intact.hpp"

#include <utility>

namespace fracture {

Expected<IntactSolid> make_intact(const Solid& solid, const FractureParameters& parameters,
                                  const Execution& execution) {
  FractureParameters whole;
  whole.pattern = PointsPattern{{solid.box.center()}};
  whole.pivot = Pivot::kSource;
  whole.hulls = parameters.hulls;
  whole.hull_limits = parameters.hull_limits;
  whole.parts = Parts::kApart;
  whole.contact_strength = 0;
  Execution within = execution;
  within.progress = {};  // it is that of the fragments
  within.within = nullptr;
  StageTimings timings;
  Expected<Diagram> diagram = make_diagram(solid, whole, within, timings);
  if (!diagram) return tl::unexpected(std::move(diagram.error()));
  Expected<FracturedSolid> made = fracture(solid, *diagram, whole, within, timings);
  if (!made) return tl::unexpected(std::move(made.error()));
  return IntactSolid{std::move(made->set.fragments), std::move(made->hulls)};
}

}  // namespace fracture
