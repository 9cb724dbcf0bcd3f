// A hit that breaks only the area near it.
#pragma once

#include <cstddef>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/execution.hpp"
#include "common/sites/pattern.hpp"

namespace fracture {

/// Further sites within a sphere, in addition to the pattern's.
struct LocalImpact {
  Vec3d point;               ///< m
  double radius = 0;         ///< m, > 0
  std::uint32_t sites = 30;  ///< drawn as by ImpactPattern: their density falls as 1 / distance
};

/// Treatment of cells that no hit is near.
enum class LocalRest {
  kWhole,      ///< all cells whose sites lie outside every sphere stay together: an exact union
  kFractured,  ///< they stay as the pattern makes them
};

/// Appends the sites of hits[first], hits[first + 1], ... to plan.points. The sites depend on the number of
/// the hit, so a second hit at the same place breaks more. Sites that do not fit into the solid near the
/// hit are left out, with a note. `already`: number of existing sites that are not in the plan. Errors:
/// those of plan_sites(), and kTooComplex if there would be more than SiteParameters::most_sites in total.
Expected<void> append_hits(const Solid& solid, const SiteParameters& parameters,
                           const std::vector<LocalImpact>& hits, std::size_t first, std::uint64_t already,
                           SitePlan& plan, const Execution& execution);

/// Sets the groups of a plan whose points from `first_of_hits` on belong to the hits. Throws Interrupted.
void group_hits(const std::vector<LocalImpact>& hits, LocalRest rest, std::size_t first_of_hits,
                SitePlan& plan, const Execution& execution = {});

}  // namespace fracture
