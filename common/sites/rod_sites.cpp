#include "common/sites/rod_sites.hpp"

#include <algorithm>
#include <cmath>

#include "common/base/pacer.hpp"
#include "common/sites/arithmetic.hpp"

namespace fracture::sites_detail {
namespace {

/// Exponent that maps a share of a rod's pieces to a position: how much denser pieces are near the hit.
constexpr double kTowardsHit = 1.7;
/// Maximum offset of sites from the axis / the lesser of rod width and piece length. Makes cuts oblique.
constexpr double kBeside = 0.15;

}  // namespace

SitePlan across_rod(const Task& task, const RadialPattern& pattern, const PartShape& shape,
                    const CellMap::Frame& frame, const Vec3d* hit, std::uint32_t count, Random& random) {
  const PartShape::Rod& rod = *shape.rod;
  const double whole = rod.to - rod.from;
  const double at = !hit ? 0 : std::clamp((dot(*hit - shape.middle, rod.axis) - rod.from) / whole, 0.0, 1.0);
  const auto along = [&](double share) {
    if (!hit) return share;
    const double side = share < at ? at : 1 - at, from_hit = std::fabs(share - at);
    const double far = side > 0 ? side * power(std::fmin(1, from_hit / side), kTowardsHit) : 0;
    return share < at ? at - far : at + far;
  };
  const Across frame_across = across(rod.axis);
  const double aside = 2 * kBeside * std::fmin(rod.width, whole / count);
  Pacer pacer(task.execution);
  SitePlan plan;
  for (std::uint32_t k = 0; k < count; ++k) {
    pacer.step(4);
    const double off = pattern.jitter * (random.uniform() - 0.5), x = random.uniform() - 0.5;
    const double y = random.uniform() - 0.5;
    const Vec3d beside = aside * (x * frame_across.u + y * frame_across.v);
    const double share = along((k + 0.5 + off) / count);
    plan.points.push_back(frame.image(shape.middle + (rod.from + share * whole) * rod.axis + beside));
    plan.groups.push_back(k);
  }
  return plan;
}

}  // namespace fracture::sites_detail
