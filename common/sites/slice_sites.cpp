// Parallel planes of one family: sites along a line in the direction of their normal. A site beside the line
// tilts the planes to its two neighbours.
#include <algorithm>
#include <cmath>

#include "common/base/pacer.hpp"
#include "common/sites/arithmetic.hpp"
#include "common/sites/generators.hpp"

namespace fracture::sites_detail {
namespace {

constexpr std::uint64_t kSliceStream = 0x511c'0000'0000'0001ull;

}  // namespace

Expected<SitePlan> slice_sites(const Task& task, const SlicePattern& pattern) {
  const Vec3d normal = normalized(pattern.normals.at(0));
  const Vec3d center = task.solid.box.center();
  double low = HUGE_VAL, high = -HUGE_VAL;
  Pacer pacer(task.execution);
  for (const Vec3f& p : task.solid.positions) {
    pacer.step();
    const double along = dot(to_double(p) - center, normal);
    low = std::fmin(low, along);
    high = std::fmax(high, along);
  }
  const double length = high - low;
  double count = task.count, spacing = length / count;
  if (pattern.spacing) {
    spacing = *pattern.spacing;
    count = std::fmax(1, std::ceil(length / spacing - 1e-3));
    low = 0.5 * (low + high) - 0.5 * count * spacing;
  }
  if (count > task.most_sites) return too_many_sites(task, count);

  // Neighbouring sites are at least (1 - jitter) spacings apart along the normal, and at most twice `off`
  // across it: their plane tilts by at most the asked angle.
  const Vec2d turned = unit_at(pattern.tilt / 360);
  const double off = 0.5 * (1 - pattern.jitter) * spacing * turned.y / turned.x;
  const Across frame = across(normal);
  Random random(task.seed ^ kSliceStream);
  SitePlan plan;
  for (std::uint32_t k = 0; k < static_cast<std::uint32_t>(count); ++k) {
    pacer.step(16);
    const double along = low + (k + 0.5 + pattern.jitter * (random.uniform() - 0.5)) * spacing;
    const Vec2d across_it = unit_at(random.uniform());
    const double out = off * std::sqrt(random.uniform());
    plan.points.push_back(center + along * normal + (out * across_it.x) * frame.u +
                          (out * across_it.y) * frame.v);
  }
  return plan;
}

}  // namespace fracture::sites_detail
