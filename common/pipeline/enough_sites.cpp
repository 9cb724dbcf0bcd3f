#include "common/pipeline/enough_sites.hpp"

#include <algorithm>
#include <cmath>
#include <variant>

#include "common/base/pacer.hpp"
#include "common/sites/column_sampler.hpp"

namespace fracture {
namespace {

constexpr int kMostPlans = 8;
constexpr double kLeastGrowth = 1.1;  // divisions are whole numbers: a little more may be the same

bool divides_the_box(const SitePattern& pattern) {
  return std::holds_alternative<GridPattern>(pattern) || std::holds_alternative<BrickPattern>(pattern) ||
         std::holds_alternative<SlicePattern>(pattern) || std::holds_alternative<RadialPattern>(pattern);
}

bool crowds(const SitePattern& pattern) {
  return std::holds_alternative<ImpactPattern>(pattern) || std::holds_alternative<ClusteredPattern>(pattern);
}

/// How many groups of cells have a site in the solid: each of them is at least one fragment.
std::size_t groups_inside(const SeenSolid& solid, const SitePlan& plan, const Execution& execution) {
  sites_detail::ColumnSampler sampler(solid.seen(), 0, execution);
  const std::vector<bool> inside = sampler.inside(plan.points);
  if (plan.groups.empty()) return static_cast<std::size_t>(std::count(inside.begin(), inside.end(), true));
  std::vector<std::uint32_t> met;
  for (std::size_t k = 0; k < inside.size(); ++k)
    if (inside[k]) met.push_back(plan.groups[k]);
  sort_with_polls(execution, met.begin(), met.end());
  return static_cast<std::size_t>(std::unique(met.begin(), met.end()) - met.begin());
}

}  // namespace

Expected<SitePlan> plan_enough_sites(const SeenSolid& solid, const FractureParameters& parameters,
                                     const Execution& execution) {
  const std::uint32_t wanted = parameters.size.fragments;
  SiteParameters more = parameters;
  if (wanted > 0 && crowds(parameters.pattern) && parameters.size.any_least())
    more.sites = std::max(more.sites, std::min(kMaxPatternSites, 2 * wanted));
  Expected<SitePlan> plan = plan_sites(solid, more, execution);
  if (!plan || wanted == 0 || !divides_the_box(parameters.pattern)) return plan;
  for (int plans = 1; plans < kMostPlans; ++plans) {
    const std::size_t inside = groups_inside(solid, *plan, execution);
    if (inside >= wanted) break;
    const double growth =
        std::fmax(kLeastGrowth, wanted / static_cast<double>(std::max<std::size_t>(inside, 1)));
    more.sites = static_cast<std::uint32_t>(std::fmin(std::ceil(more.sites * growth), kMaxPatternSites));
    Expected<SitePlan> next = plan_sites(solid, more, execution);
    if (!next || (next->points.size() <= plan->points.size() && more.sites == kMaxPatternSites)) break;
    plan = std::move(next);
  }
  return plan;
}

}  // namespace fracture
