// Parallel planes of one family: sites along a line in the direction of their normal. Moving a site off the
// line tilts the planes to its two neighbours.
#include <algorithm>
#include <cmath>

#include "common/base/pacer.hpp"
#include "common/sites/arithmetic.hpp"
#include "common/sites/generators.hpp"

namespace fracture::sites_detail {
namespace {

constexpr std::uint64_t kSliceStream = 0x511c'0000'0000'0001ull;

/// The grid that represents the slices in their image: cells of the given spacing. With two families, the
/// third direction is not divided.
GridPattern grid_of(const SlicePattern& slices, const Task& task) {
  const Vec3d size = task.solid.box.size();
  GridPattern grid;
  grid.jitter = slices.jitter;
  const auto families = slices.normals.size();
  if (slices.spacing) {
    grid.cell = Vec3d{*slices.spacing, *slices.spacing, *slices.spacing};
  } else if (families == 3) {
    return grid;  // as many cubes as requested
  } else {
    // As many squares as requested fill the rectangle of the first two coordinates.
    const double side = std::sqrt(size.x * size.y / task.count);
    grid.cell = Vec3d{side, side, side};
  }
  if (families == 2) grid.cell->z = size.z > 0 ? 2 * size.z : 1;
  return grid;
}

}  // namespace

double expected_sites(const SlicePattern& pattern, double count, const Vec3d& sides) {
  if (!pattern.spacing) return count;
  double n = 1;
  for (const Vec3d& normal : pattern.normals) {
    const double length = std::sqrt(dot(normal, normal));
    const double width =
        (std::fabs(normal.x) * sides.x + std::fabs(normal.y) * sides.y + std::fabs(normal.z) * sides.z) /
        length;
    n *= std::fmax(1, std::ceil(width / *pattern.spacing));
  }
  return n;
}

/// Several families are the product grid of their coordinates; the map has transformed the solid to these
/// coordinates.
Expected<SitePlan> generate(const Task& task, const SlicePattern& pattern, const ImageMap& map) {
  if (pattern.normals.size() > 1) {
    const GridPattern grid = grid_of(pattern, task);
    Expected<SitePlan> plan = generate(task, grid, map);
    if (!plan && plan.error().code == ErrorCode::kTooComplex && pattern.spacing)
      return too_many_sites(task, boxes_in(task.solid.box.size(), *grid.cell), "slice", "spacing",
                            "a larger");
    return plan;
  }
  // The plane n·q = c is A^-T n · A q = c.
  const Vec3d given = pattern.normals.at(0);
  const Vec3d normal = normalized(map ? map.of_part(0).inverse.transposed_times(given) : given);
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
  if (count > task.most_sites)
    return pattern.spacing ? too_many_sites(task, count, "slice", "spacing", "a larger")
                           : too_many_sites(task, count, "slice");

  // Neighbouring sites are at least (1 - jitter) spacings apart along the normal, and at most twice `off`
  // across it. So the plane between them tilts by at most the requested angle.
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
