#include "common/pipeline/local_impact.hpp"

#include <algorithm>
#include <numeric>

namespace fracture {

Expected<void> add_local_impact(const Solid& solid, const SiteParameters& parameters,
                                const LocalImpact& impact, SitePlan& plan, const Execution& execution) {
  SiteParameters near = parameters;
  near.sites = impact.sites;
  near.seed = parameters.seed ^ 0x696d70616374ull;  // not the pattern's own sequence
  near.pattern = ImpactPattern{.impacts = {impact.point}, .radius = impact.radius, .exponent = 1, .share = 1};
  near.lloyd = 0;
  Expected<SitePlan> further = plan_sites(solid, near, execution);
  if (!further) return tl::unexpected(further.error());

  const std::size_t before = plan.points.size();
  plan.points.insert(plan.points.end(), further->points.begin(), further->points.end());
  const bool whole = impact.rest == LocalImpact::Rest::kWhole;
  if (plan.groups.empty() && !whole) return {};
  if (plan.groups.empty()) {
    plan.groups.resize(before);
    std::iota(plan.groups.begin(), plan.groups.end(), 0u);
  }
  std::uint32_t next = 0;
  for (const std::uint32_t g : plan.groups) next = std::max(next, g + 1);
  if (whole) {
    const Matrix3 back = plan.map ? plan.map->inverse() : Matrix3();
    for (std::size_t k = 0; k < before; ++k)
      if (length(back * plan.points[k] - impact.point) > impact.radius) plan.groups[k] = next;
    ++next;
  }
  while (plan.groups.size() < plan.points.size()) plan.groups.push_back(next++);
  return {};
}

}  // namespace fracture
