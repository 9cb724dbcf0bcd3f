// A hit that breaks only what is near it.
#pragma once

#include <cstddef>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/execution.hpp"
#include "common/sites/pattern.hpp"

namespace fracture {

/// Further sites within a sphere, on top of the pattern's.
struct LocalImpact {
  Vec3d point;               ///< m
  double radius = 0;         ///< m, > 0
  std::uint32_t sites = 30;  ///< drawn as ImpactPattern draws them, density falling as 1 / distance
};

/// What becomes of what no hit is near to.
enum class LocalRest {
  kWhole,      ///< all cells whose sites lie outside of every sphere stay together: an exact union
  kFractured,  ///< they stay what the pattern makes of them
};

/// Appends the sites of hits[first], hits[first + 1], ... to plan.points; they depend on the number of the
/// hit, so that a second one at the same place breaks further. Sites for which the solid has no room near the
/// hit are left out, with a note. `already`: sites that are there and not in the plan. Errors: of plan_sites(), and
/// kTooComplex where there would be more than SiteParameters::most_sites of all together.
Expected<void> append_hits(const Solid& solid, const SiteParameters& parameters,
                           const std::vector<LocalImpact>& hits, std::size_t first, std::uint64_t already,
                           SitePlan& plan, const Execution& execution);

/// The groups of a plan whose points from `first_of_hits` on are those of the hits. Throws Interrupted.
void group_hits(const std::vector<LocalImpact>& hits, LocalRest rest, std::size_t first_of_hits,
                SitePlan& plan, const Execution& execution = {});

}  // namespace fracture
