// The solid before it breaks: the repaired mesh, with its own collision hulls.
#pragma once

#include "common/base/error.hpp"
#include "common/base/execution.hpp"
#include "common/pipeline/fracture.hpp"
#include "common/pipeline/fractured_solid.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

/// Returns the parts of the solid as uncut fragments, which are made with a single site. They have the same vertices,
/// attributes and materials as the outside of the fragments. Their hulls are those of the source, if it has any
/// (given_colliders.hpp). The only parameters used are hulls, hull_limits and parts.
/// Errors: kNoFragments, kUnsound. Throws Interrupted.
Expected<IntactSolid> make_intact(const Solid& solid, const FractureParameters& parameters,
                                  const Execution& execution);

}  // namespace fracture
