// Rings and spokes. Sites stand on an aligned polar grid: the same radii r_k on every spoke direction d_b.
// The distance of a point x across the axis to site (k, b) is |x|² + r_k² - 2 r_k x·d_b, so whatever the ring
// the nearest spoke is the one with the largest x·d_b: cells are bounded by the radial planes half-way
// between neighbouring spokes, at whatever angles those stand, and, within a spoke, by the chords
// x·d_b = (r_k + r_k+1) / 2. A chord is tangential on its spoke and off by the angle from it elsewhere, at
// most half the widest gap between spokes. The innermost "ring" is one site on the axis.
//
// A ring crack that goes all around looks drawn, not broken. So neighbouring cells of a spoke stay together
// at random (`merge`), which leaves long shards and staggered ring cracks, and near the centre some pairs of
// neighbouring spokes do, so that radial cracks begin at different distances.
#include <algorithm>
#include <cmath>

#include "common/base/disjoint_sets.hpp"
#include "common/base/pacer.hpp"
#include "common/sites/arithmetic.hpp"
#include "common/sites/generators.hpp"

namespace fracture::sites_detail {
namespace {

constexpr std::uint64_t kRadialStream = 0x4ad1'0000'0000'0001ull;
constexpr double kLeastSpokes = 14, kMostSpokes = 64;

/// The shortest side of the box; of equal ones z, then x, then y: a pane mostly faces z.
Vec3d shortest_side(const Box& box) {
  const Vec3d size = box.size();
  int axis = 2;
  for (const int a : {0, 1})
    if (size[a] < size[axis]) axis = a;
  Vec3d direction;
  direction[axis] = 1;
  return direction;
}

/// How far the box reaches from the axis through the centre.
double reach_across(const Box& box, const Vec3d& center, const Across& frame) {
  double reach = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3d p{corner & 1 ? box.max.x : box.min.x, corner & 2 ? box.max.y : box.min.y,
                  corner & 4 ? box.max.z : box.min.z};
    const double x = dot(p - center, frame.u), y = dot(p - center, frame.v);
    reach = std::fmax(reach, std::sqrt(x * x + y * y));
  }
  return reach;
}

}  // namespace

double expected_sites(const RadialPattern& pattern, double count, const Vec3d&) {
  // A ring crack that stays away leaves one piece of several cells.
  if (pattern.spokes && pattern.rings) return static_cast<double>(*pattern.spokes) * *pattern.rings;
  return 2 * count;
}

Expected<SitePlan> generate(const Task& task, const RadialPattern& pattern, const ImageMap& map) {
  const Box& box = task.solid.box;
  const std::vector<Vec3d> impacts = mapped(pattern.impacts, map);
  const Vec3d center = impacts.empty() ? box.center() : impacts[0];
  const std::optional<Vec3d> axis =
      map && pattern.axis ? map.of_part(0).matrix * *pattern.axis : pattern.axis;
  const Across frame = across(axis.value_or(shortest_side(box)));
  const double reach = reach_across(box, center, frame);

  // About 0.7 of the cells of a disc around a square meet the square, and `merge` of those go.
  const double cells = task.count / (0.7 * (1 - pattern.merge));
  const auto spokes = pattern.spokes.value_or(static_cast<std::uint32_t>(
      std::nearbyint(std::fmin(kMostSpokes, std::fmax(kLeastSpokes, std::sqrt(2 * cells))))));
  const auto rings = pattern.rings.value_or(
      static_cast<std::uint32_t>(std::nearbyint(std::fmin(1000, std::fmax(2, cells / spokes)))));
  if (static_cast<double>(spokes) * rings > task.most_sites)
    return too_many_sites(task, static_cast<double>(spokes) * rings);

  Random random(task.seed ^ kRadialStream);
  std::vector<double> width(rings);
  double sum = 0, w = 1;
  for (double& ring : width) {
    ring = w;
    sum += w;
    w = std::fmin(w * pattern.growth, 1e100);
  }
  std::vector<double> radius;
  double inner = 0;
  for (std::uint32_t k = 0; k < rings; ++k) {
    const double wide = width[k] / sum * reach, off = (random.uniform() - 0.5) * 0.5 * pattern.jitter;
    radius.push_back(k == 0 ? 0 : inner + (0.5 + off) * wide);
    inner += wide;
  }
  std::vector<Vec3d> direction;
  for (std::uint32_t b = 0; b < spokes; ++b) {
    const Vec2d d = unit_at((b + 0.6 * pattern.jitter * (random.uniform() - 0.5)) / spokes);
    direction.push_back(d.x * frame.u + d.y * frame.v);
  }

  Pacer pacer(task.execution);
  SitePlan plan;
  plan.points.push_back(center);
  for (std::uint32_t b = 0; b < spokes; ++b) {
    pacer.step(rings);
    for (std::uint32_t k = 1; k < rings; ++k) plan.points.push_back(center + radius[k] * direction[b]);
  }

  const auto at = [&](std::uint32_t b, std::uint32_t k) { return 1 + (b % spokes) * (rings - 1) + (k - 1); };
  DisjointSets together(plan.points.size());
  for (std::uint32_t b = 0; b < spokes; ++b) {
    pacer.step(4 * rings);
    for (std::uint32_t k = 2; k < rings; ++k)
      if (random.uniform() < pattern.merge) together.unite(at(b, k - 1), at(b, k));
  }
  for (std::uint32_t b = 0; b + 1 < spokes; b += 2) {
    const double length = pattern.merge * random.uniform() * rings / 2;
    for (std::uint32_t k = 1; k < rings && k < length; ++k) together.unite(at(b, k), at(b + 1, k));
  }
  for (std::uint32_t k = 0; k < plan.points.size(); ++k) plan.groups.push_back(together.find(k));
  return plan;
}

}  // namespace fracture::sites_detail
