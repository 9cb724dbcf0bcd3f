// Hulls from the collision geometry of the source.
#pragma once

#include "common/base/execution.hpp"
#include "common/mesh/given_hull.hpp"
#include "common/physics/collision_hulls.hpp"

namespace fracture {

/// Returns one convex hull for each connected piece of the geometry, in the frame of its points. Its corners are points of the
/// geometry, so they are not moved inwards: a collider that does not move needs no gap. A piece with more than kMaxHullPoints
/// extreme points gets the hull of a selection of them.
/// The result is empty if the geometry is flat. It is also empty if the surface itself should collide (GivenHull::convex), and
/// the hull of a piece has more than `most_excess` times the piece's volume. `volume` is the sum of the hulls, m³. Throws
/// Interrupted.
FragmentHulls make_given_hulls(const GivenHull& given, double most_excess, const Execution& execution);

}  // namespace fracture
