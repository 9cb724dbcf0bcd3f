// Several hulls for a fragment whose single hull would close its openings: the hulls of convex parts of its surface.
#pragma once

#include "common/base/execution.hpp"
#include "common/fragment/fragments.hpp"
#include "common/physics/collision_hulls.hpp"
#include "common/physics/hull_maker.hpp"

namespace fracture {

/// Replaces the hulls in `out` by those of the fragment's convex parts (convex_parts.hpp), if these exceed its volume by
/// less. `maker` has the fragment's corners. The parts of a rough fragment are cut back to its hull in `out`, so they do not
/// reach into other cells either. Hulls stay unchanged if the fragment is open, has pieces of several parts or too many
/// triangles. They also stay unchanged if it was cut and
/// - has several cells, because its surface does not tell which part lies in which cell, or
/// - has no opening, like the curved shards of a vase: there may be hundreds of them, and nothing can fly through them.
/// Throws Interrupted.
void divide_hulls(const Fragment& f, const HullLimits& limits, HullMaker& maker, FragmentHulls& out,
                  const Execution& execution);

}  // namespace fracture
