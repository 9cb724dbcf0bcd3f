#include "common/pipeline/local_impact.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include "common/base/pacer.hpp"
#include "common/base/random.hpp"
#include "common/base/words.hpp"
#include "common/pipeline/aggregate.hpp"

namespace fracture {
namespace {

/// Maximum distance of a site beyond the radius, as a fraction, because sites are rounded to a lattice of
/// 2^-21 of the box.
constexpr double kRounding = 1e-5;

/// Groups a hit's sites into fragments of about `cells` sites each: each site joins the nearest seed.
/// Distances in the direction away from the hit count less than across it. The hit's sites are in the order
/// of a curve through the solid: sites that are near in space are near in it. So every `cells`-th site
/// serves as a seed in the middle of some others.
void group_hit(const LocalImpact& hit, const SitePlan& further, std::uint32_t cells, SitePlan& plan,
               const Execution& execution) {
  const std::vector<Vec3d>& points = further.points;
  std::uint32_t next = 0;
  for (const std::uint32_t g : plan.groups_of_hits) next = std::max(next, g + 1);
  const auto seeds = static_cast<std::int64_t>((points.size() + cells - 1) / cells);
  constexpr std::int64_t kReach = 16;  // number of seeds before and after a site's own that are tested
  Pacer pacer(execution);
  for (std::size_t k = 0; k < points.size(); ++k) {
    pacer.step(2 * kReach);
    const Vec3d& p = points[k];
    const Vec3d from = p - (further.map ? further.map.at(p).image(hit.point) : hit.point);
    const double far = length(from);
    const Vec3d out = far > 0 ? (1 / far) * from : Vec3d{};
    const auto own = static_cast<std::int64_t>(k / cells);
    std::int64_t best = own;
    double least = HUGE_VAL;
    for (std::int64_t seed = std::max<std::int64_t>(0, own - kReach);
         seed < std::min(seeds, own + kReach + 1); ++seed) {
      const std::size_t middle =
          std::min(static_cast<std::size_t>(seed) * cells + cells / 2, points.size() - 1);
      const Vec3d to = points[middle] - p;
      const double along = dot(to, out),
                   square = dot(to, to) - (1 - 1 / (kOutwards * kOutwards)) * along * along;
      if (square < least) {
        least = square;
        best = seed;
      }
    }
    plan.groups_of_hits.push_back(next + static_cast<std::uint32_t>(best));
  }
}

/// Adds a remark about sites of a hit that did not fit near it.
void add_remark(std::size_t hit, std::size_t missing, std::size_t asked, double radius, Remarks& remarks) {
  const std::string where = " in the solid within " + short_number(radius) + " m of it";
  if (missing == asked)
    remarks.warn("Hit " + grouped(hit) + " breaks nothing off, because there is no room for its sites" +
                 where + ". Move 'local_point' onto the mesh, or give a larger 'local_radius'.");
  else
    remarks.note("Hit " + grouped(hit) + ": " + grouped(missing) + " of " + counted(asked, "site", "sites") +
                 (missing == 1 ? " was" : " were") + " left out, because there is no more room" + where +
                 ".");
}

}  // namespace

Expected<void> append_hits(const Solid& solid, const SiteParameters& parameters,
                           const std::vector<LocalImpact>& hits, std::size_t first, std::uint64_t already,
                           SitePlan& plan, const Execution& execution) {
  for (std::size_t k = first; k < hits.size(); ++k) {
    const LocalImpact& hit = hits[k];
    SiteParameters near = parameters;
    near.sites = hit.sites;
    // Uses a sequence that differs from the pattern's and from that of every other hit.
    near.seed = (parameters.seed ^ 0x696d70616374ull) + k * kGoldenGamma;
    near.pattern = ImpactPattern{
        .impacts = {hit.point}, .radius = hit.radius, .exponent = 1, .share = 1, .by_parts = false};
    near.lloyd = 0;
    near.aggregation.cells = cells_per_fragment(parameters);  // from the original pattern
    near.density_from.clear();
    // Hits use the pattern's map, except with slices, whose map would make a grid of the hits' sites.
    const bool as_seen = !std::holds_alternative<SlicePattern>(parameters.pattern);
    Expected<SitePlan> further = as_seen ? plan_sites(SeenSolid(solid, plan.map, execution), near, execution)
                                         : plan_sites(solid, near, execution);
    if (!further) return tl::unexpected(further.error());
    // Sites that did not fit near the point were placed elsewhere and are not part of the hit.
    const std::size_t asked = further->points.size();
    const double reach = hit.radius + kRounding * (hit.radius + solid.box.longest_side());
    std::erase_if(further->points, [&](const Vec3d& p) {
      const Vec3d center = further->map ? further->map.at(p).image(hit.point) : hit.point;
      return length(p - center) > reach;
    });
    // Oblique slices have a map of their own that hits do not use.
    if (further->map != plan.map) {
      for (Vec3d& p : further->points) {
        const Vec3d place = further->map ? further->map.at(p).place(p) : p;
        p = plan.map ? plan.map.of_part(0).image(place) : place;
      }
    }
    if (const std::uint64_t all = already + plan.points.size() + further->points.size();
        all > parameters.most_sites)
      return fail(ErrorCode::kTooComplex,
                  "With hit " + std::to_string(k + 1) + " there would be " + std::to_string(all) +
                      " sites. The limit for the pattern and all hits together is " +
                      std::to_string(parameters.most_sites) + ".",
                  "local_sites");
    if (const std::uint32_t cells = cells_per_fragment(near); cells > 1)
      group_hit(hit, *further, cells, plan, execution);
    plan.points.insert(plan.points.end(), further->points.begin(), further->points.end());
    if (const std::size_t missing = asked - further->points.size(); missing > 0)
      add_remark(k + 1, missing, asked, hit.radius, plan.remarks);
  }
  return {};
}

void group_hits(const std::vector<LocalImpact>& hits, LocalRest rest, std::size_t first_of_hits,
                SitePlan& plan, const Execution& execution) {
  const bool whole = rest == LocalRest::kWhole;
  if (plan.groups.empty() && !whole) return;
  if (plan.groups.empty()) {
    plan.groups.resize(first_of_hits);
    std::iota(plan.groups.begin(), plan.groups.end(), 0u);
  }
  std::uint32_t next = 0;
  for (const std::uint32_t g : plan.groups) next = std::max(next, g + 1);
  if (whole) {
    Pacer pacer(execution);
    for (std::size_t k = 0; k < first_of_hits; ++k) {
      pacer.step(1 + hits.size());
      const Vec3d& p = plan.points[k];
      const Vec3d site = plan.map ? plan.map.at(p).place(p) : p;
      if (std::all_of(hits.begin(), hits.end(),
                      [&](const LocalImpact& hit) { return length(site - hit.point) > hit.radius; }))
        plan.groups[k] = next;
    }
    ++next;
  }
  for (const std::uint32_t g : plan.groups_of_hits) plan.groups.push_back(next + g);
  while (plan.groups.size() < plan.points.size()) plan.groups.push_back(next++);
}

}  // namespace fracture
