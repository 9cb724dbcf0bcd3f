#include "common/pipeline/intact.hpp"

#include <utility>

#include "common/physics/collision_hulls.hpp"
#include "common/pipeline/given_colliders.hpp"
#include "common/pipeline/overlaps.hpp"
#include "common/pipeline/part_sets.hpp"

namespace fracture {

Expected<IntactSolid> make_intact(const Solid& solid, const FractureParameters& parameters,
                                  const Execution& execution) {
  FractureParameters whole;
  whole.pattern = PointsPattern{{solid.box.center()}};
  whole.pivot = Pivot::kSource;
  whole.parts = Parts::kApart;
  whole.contact_strength = 0;
  Execution within = execution;
  within.progress = {};  // the fragments report progress
  within.within = nullptr;
  StageTimings timings;
  Expected<Diagram> diagram = make_diagram(solid, whole, within, timings);
  if (!diagram) return tl::unexpected(std::move(diagram.error()));
  Expected<FracturedSolid> made = fracture(solid, *diagram, whole, within, timings);
  if (!made) return tl::unexpected(std::move(made.error()));
  FragmentSet& set = made->set;
  const bool together = parameters.parts == Parts::kTogether;
  count_overlaps_once(solid, together, set, execution);
  if (!parameters.assigned.empty())
    weigh_assigned(solid, parameters, choose_assigned(solid, parameters, execution), together, set,
                   made->whole_bonds, execution);
  // Static colliders never collide with each other, so their hulls need no rest.
  IntactSolid intact;
  if (parameters.hulls == Hulls::kConvex)
    intact.hulls = make_collision_hulls(set, {}, parameters.hull_limits, execution);
  intact.parts = std::move(set.fragments);
  if (parameters.hulls == Hulls::kConvex)
    use_given_hulls(solid, parameters.hull_limits.excess, intact, execution);
  return intact;
}

}  // namespace fracture
