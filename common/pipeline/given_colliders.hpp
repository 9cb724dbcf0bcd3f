// The collision geometry of the source as colliders of the unbroken solid.
#pragma once

#include "common/base/execution.hpp"
#include "common/pipeline/fractured_solid.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

/// Replaces the hulls of parts whose node has collision geometry (Mesh::given_hulls) by its hulls. Each belongs to the part of its
/// owners whose box has the most volume in common with its own, or else to the first one. The geometry replaces the hulls of a whole node.
/// So other parts of the same node get no hulls. Geometry that cannot be used as hulls (physics/given_hulls.hpp) changes
/// nothing, and a warning is added. `intact`: has hulls. Throws Interrupted.
void use_given_hulls(const Solid& solid, double most_excess, IntactSolid& intact, const Execution& execution);

}  // namespace fracture
