#include "common/pipeline/enough_sites.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <variant>

#include "common/base/pacer.hpp"
#include "common/base/words.hpp"
#include "common/pipeline/kept_space.hpp"
#include "common/sites/column_sampler.hpp"

namespace fracture {
namespace {

constexpr int kMostPlans = 8;
constexpr double kLeastGrowth = 1.1;  // divisions are whole numbers, so a little more may change nothing
constexpr double kMostGrowth = 2;     // if few cells are met, this says little about the next plan
// With 16 samples per fragment, a cell of average size is missed only once in e^16 times.
constexpr std::uint32_t kSamplesPerFragment = 16, kMostSamples = 1u << 14;
constexpr std::uint64_t kMostDistances = 1u << 24;  // about 20 ms

/// One family of slices has as many slices as requested, from one end of the solid to the other.
bool divides_the_box(const SitePattern& pattern) {
  if (const auto* slices = std::get_if<SlicePattern>(&pattern)) return slices->normals.size() > 1;
  return std::holds_alternative<GridPattern>(pattern) || std::holds_alternative<BrickPattern>(pattern) ||
         std::holds_alternative<RadialPattern>(pattern);
}

bool crowds(const SitePattern& pattern) {
  return std::holds_alternative<ImpactPattern>(pattern) || std::holds_alternative<ClusteredPattern>(pattern);
}

/// Share of the solid in the kept region, at most kMostKept.
double kept_share(const SeenSolid& solid, const KeptSpace& kept, const Execution& execution) {
  constexpr std::uint32_t kSamples = 512;
  constexpr double kMostKept = 0.9;
  const std::vector<Vec3d> samples = sites_detail::ColumnSampler(solid.seen(), 0, execution).spread(kSamples);
  const auto inside =
      std::count_if(samples.begin(), samples.end(), [&](const Vec3d& p) { return kept.holds(p); });
  if (samples.empty()) return 0;
  return std::fmin(kMostKept, static_cast<double>(inside) / static_cast<double>(samples.size()));
}

/// Number of groups of cells that contain one of these points.
std::size_t groups_met(const std::vector<Vec3d>& points, const SitePlan& plan, const Execution& execution) {
  Pacer pacer(execution);
  std::vector<std::uint32_t> met;
  for (const Vec3d& p : points) {
    pacer.step(plan.points.size());
    std::size_t nearest = 0;
    double least = HUGE_VAL;
    for (std::size_t k = 0; k < plan.points.size(); ++k) {
      const Vec3d to = plan.points[k] - p;
      if (const double square = dot(to, to); square < least) {
        least = square;
        nearest = k;
      }
    }
    met.push_back(plan.groups.empty() ? static_cast<std::uint32_t>(nearest) : plan.groups[nearest]);
  }
  sort_with_polls(execution, met.begin(), met.end());
  return static_cast<std::size_t>(std::unique(met.begin(), met.end()) - met.begin());
}

}  // namespace

double sites_for_fragments(const FractureParameters& parameters) {
  if (const std::uint32_t cells = cells_per_fragment(parameters); cells > 1)
    return 1.0 * parameters.sites * cells;
  const bool as_many = parameters.size.fragments > 0 && parameters.sites == parameters.size.fragments;
  const bool more = crowds(parameters.pattern) || divides_the_box(parameters.pattern);
  return as_many && more ? 2.0 * parameters.sites : parameters.sites;
}

Expected<SitePlan> plan_enough_sites(const SeenSolid& solid, const FractureParameters& parameters,
                                     const Execution& execution) {
  const std::uint32_t wanted = parameters.size.fragments;
  if (wanted == 0 || parameters.sites != wanted || cells_per_fragment(parameters) > 1)  // known
    return plan_sites(solid, parameters, execution);
  SiteParameters more = parameters;
  if (crowds(parameters.pattern)) {
    more.sites = std::max(wanted, std::min(kMaxPatternSites, 2 * wanted));
    if (more.sites > parameters.most_sites)
      return fail(ErrorCode::kTooComplex,
                  "For " + counted(wanted, "fragment", "fragments") + ", this pattern needs " +
                      grouped(more.sites) + " sites; " + site_limit(parameters.most_sites) +
                      ". Ask for fewer fragments.",
                  "fragments");
  }
  std::optional<KeptSpace> kept;
  if (parameters.keep && parameters.dual == Dual::kCircumcenter) {
    kept.emplace(*parameters.keep, solid);
    const double sites = more.sites / (1 - kept_share(solid, *kept, execution));
    more.sites = std::max(
        more.sites, static_cast<std::uint32_t>(std::fmin(std::nearbyint(sites), parameters.most_sites)));
  }
  Expected<SitePlan> plan = plan_sites(solid, more, execution);
  if (!divides_the_box(parameters.pattern)) return plan;
  std::vector<Vec3d> samples;
  std::size_t met = 0;
  bool changed = true;
  for (int plans = 1; plan && plans < kMostPlans; ++plans) {
    const std::uint64_t count = std::uint64_t{kSamplesPerFragment} * wanted;
    if (count > kMostSamples || count * plan->points.size() > kMostDistances) break;
    if (samples.empty())
      samples =
          sites_detail::ColumnSampler(solid.seen(), 0, execution).spread(static_cast<std::uint32_t>(count));
    if (kept) std::erase_if(samples, [&](const Vec3d& p) { return kept->holds(p); });
    if (samples.empty()) break;  // the solid is too thin for a column to hit it
    if (changed) met = groups_met(samples, *plan, execution);
    if (met >= wanted) break;
    // Because divisions are whole numbers, a plan for more cells may be the same or even meet fewer cells,
    // and the next one after it may meet more.
    const double growth =
        std::clamp(wanted / static_cast<double>(std::max<std::size_t>(met, 1)), kLeastGrowth, kMostGrowth);
    more.sites = static_cast<std::uint32_t>(std::fmin(std::ceil(more.sites * growth), kMaxPatternSites));
    Expected<SitePlan> next = plan_sites(solid, more, execution);
    changed = next && next->points != plan->points;
    plan = std::move(next);  // a plan with too many sites for this server is refused, not reduced
  }
  return plan;
}

}  // namespace fracture
