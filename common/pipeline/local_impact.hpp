// A hit that breaks only what is near it.
#pragma once

#include "common/base/error.hpp"
#include "common/base/execution.hpp"
#include "common/sites/pattern.hpp"

namespace fracture {

/// Further sites within a sphere, on top of the pattern's.
struct LocalImpact {
  enum class Rest {
    kWhole,      ///< all cells whose sites lie outside of the sphere stay together: an exact union
    kFractured,  ///< they stay what the pattern makes of them
  };
  Vec3d point;               ///< m
  double radius = 0;         ///< m, > 0
  std::uint32_t sites = 30;  ///< drawn as ImpactPattern draws them, density falling as 1 / distance
  Rest rest = Rest::kWhole;
};

/// Appends the sites of the impact to the plan of the same parameters, behind those of the pattern, and
/// groups the rest. Errors of plan_sites().
Expected<void> add_local_impact(const Solid& solid, const SiteParameters& parameters,
                                const LocalImpact& impact, SitePlan& plan, const Execution& execution);

}  // namespace fracture
