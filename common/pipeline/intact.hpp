// The solid as it is before it breaks: what the repairs made of the mesh, with collision hulls of its own.
#pragma once

#include "common/base/error.hpp"
#include "common/base/execution.hpp"
#include "common/pipeline/fracture.hpp"
#include "common/pipeline/fractured_solid.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

/// The parts of the solid as fragments that nothing cuts: its fragments with a single site. They have the vertices,
/// attributes and materials that the outside of the fragments has. Only the parameters of hulls matter. Errors:
/// kNoFragments, kUnsound. Throws Interrupted.
Expected<IntactSolid> make_intact(const Solid& solid, const FractureParameters& parameters,
                                  const Execution& execution);

}  // namespace fracture
