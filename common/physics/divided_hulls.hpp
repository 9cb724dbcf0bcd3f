// Several hulls for a fragment whose single hull would close its openings: the hulls of convex parts of its surface.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "common/base/execution.hpp"
#include "common/base/pacer.hpp"
#include "common/fragment/fragments.hpp"
#include "common/physics/collision_hulls.hpp"
#include "common/physics/hull_maker.hpp"

namespace fracture {

/// A fragment with more triangles is not divided. One with this many takes 20 to 60 ms.
inline constexpr std::size_t kMostDividedTriangles = 10'000;

/// Whether a fragment's convex parts can have hulls: it is closed, has at most kMostDividedTriangles, and has pieces of only
/// one part. With several parts, each piece keeps its hull, so that the fragment's hulls stay in its cells.
bool may_be_divided(const Fragment& f);

/// Whether hulls close an opening of a surface that things can fly through. Then their shadows through their largest face are
/// larger than that of the surface, by more than the factor `excess`. A curved shard has about the same shadow as its hull.
/// Throws Interrupted.
bool close_an_opening(std::span<const CollisionHull> hulls, std::span<const Vec3f> points,
                      std::span<const std::array<std::uint32_t, 3>> triangles, double excess, Pacer& pacer);

/// Replaces the hulls in `out` by those of the fragment's convex parts (convex_parts.hpp), if these exceed its volume by
/// less. `maker` has the fragment's corners. The parts of a rough fragment are cut back to its hull in `out`, so they do not
/// reach into other cells either. Hulls stay unchanged if may_be_divided() is false. They also stay unchanged if it was cut and
/// - has several cells: aggregate_hulls.hpp divides it, because that needs the cells, or
/// - has no opening, like the curved shards of a vase: there may be hundreds of them, and nothing can fly through them.
/// Throws Interrupted.
void divide_hulls(const Fragment& f, const HullLimits& limits, HullMaker& maker, FragmentHulls& out,
                  const Execution& execution);

}  // namespace fracture
