// Rings and spokes. Sites are on an aligned polar grid, with the same radii r_k on every spoke direction d_b.
// The squared distance of a point x across the axis to site (k, b) is |x|² + r_k² - 2 r_k x·d_b, so for every
// ring the nearest spoke is the one with the largest x·d_b. Cells are therefore bounded by the radial planes
// half-way between neighbouring spokes, whatever their angles. Within a spoke, they are bounded by the chords
// x·d_b = (r_k + r_k+1) / 2. A chord is tangential on its spoke. Elsewhere it deviates by the angle from the
// spoke, which is at most half the widest gap between spokes. The innermost "ring" is one site on the axis.
//
// Around a point, spokes point in all directions, evenly spread (a spherical Fibonacci lattice: Swinbank &
// Purser 2006, "Fibonacci grids"). The same argument applies: cells are pyramids from the centre, cut across
// by planes. They divide the wall of a vessel into shards that are long in the direction of the hit.
//
// A ring crack that goes all the way around looks drawn, not broken. So neighbouring cells on a spoke are
// merged at random (`merge`), which gives long shards and staggered ring cracks. Near the centre, some pairs
// of neighbouring spokes are merged, so radial cracks begin at different distances.
//
// If a solid has several parts, each part breaks by its shape, with its own cells (a frame of the map). A
// plate breaks around an axis, a body around a point, and a rod across, unless that gives thin slices.
//
// Brittle and weak materials are crushed at the hit: crumbs replace the innermost rings (`crushed`).
#include <algorithm>
#include <cmath>
#include <optional>

#include "common/base/disjoint_sets.hpp"
#include "common/base/pacer.hpp"
#include "common/bvh/box_tree.hpp"
#include "common/sites/arithmetic.hpp"
#include "common/sites/generators.hpp"
#include "common/sites/rod_sites.hpp"
#include "common/sites/shapes.hpp"

namespace fracture::sites_detail {
namespace {

constexpr std::uint64_t kRadialStream = 0x4ad1'0000'0000'0001ull;
constexpr double kLeastSpokes = 14, kMostSpokes = 64;

/// The shortest side of the box; of equal sides z, then x, then y, because panes usually face z.
Vec3d shortest_side(const Box& box) {
  const Vec3d size = box.size();
  int axis = 2;
  for (const int a : {0, 1})
    if (size[a] < size[axis]) axis = a;
  Vec3d direction;
  direction[axis] = 1;
  return direction;
}

/// If a hit is nearer to the middle than this share of the longest side, it has no direction.
constexpr double kInwards = 0.1;

/// The largest distance(p) among the corners of the box.
template <class Distance>
double reach(const Box& box, const Distance& distance) {
  double reach = 0;
  for (int corner = 0; corner < 8; ++corner)
    reach = std::fmax(reach, distance({corner & 1 ? box.max.x : box.min.x, corner & 2 ? box.max.y : box.min.y,
                                       corner & 4 ? box.max.z : box.min.z}));
  return reach;
}

/// The directions of the spokes, the number of rings, and the radius of the wheel.
struct Wheel {
  Vec3d center;
  std::vector<Vec3d> spokes;
  std::uint32_t rings;
  double reach;  ///< m
};

/// Radii of rings that grow outwards. Each radius is at or near the middle of its ring.
std::vector<double> radii(const RadialPattern& pattern, const Wheel& wheel, Random& random) {
  std::vector<double> width(wheel.rings);
  double sum = 0, w = 1;
  for (double& ring : width) {
    ring = w;
    sum += w;
    w = std::fmin(w * pattern.growth, 1e100);
  }
  std::vector<double> radius;
  double inner = 0;
  for (std::uint32_t k = 0; k < wheel.rings; ++k) {
    const double wide = width[k] / sum * wheel.reach, off = (random.uniform() - 0.5) * 0.5 * pattern.jitter;
    radius.push_back(k == 0 ? 0 : inner + (0.5 + off) * wide);
    inner += wide;
  }
  return radius;
}

/// Returns the sites, innermost first, and the groups of cells that stay together. `paired`: every second
/// spoke is merged with the next, from the centre out to a random distance.
SitePlan plan_of(const RadialPattern& pattern, const Wheel& wheel, const std::vector<double>& radius,
                 bool paired, Random& random, const Execution& execution) {
  const auto spokes = static_cast<std::uint32_t>(wheel.spokes.size());
  const std::uint32_t rings = wheel.rings;
  Pacer pacer(execution);
  SitePlan plan;
  plan.points.push_back(wheel.center);
  for (const Vec3d& direction : wheel.spokes) {
    pacer.step(rings);
    for (std::uint32_t k = 1; k < rings; ++k) plan.points.push_back(wheel.center + radius[k] * direction);
  }
  const auto at = [&](std::uint32_t b, std::uint32_t k) { return 1 + (b % spokes) * (rings - 1) + (k - 1); };
  DisjointSets together(plan.points.size());
  for (std::uint32_t b = 0; b < spokes; ++b) {
    pacer.step(4 * rings);
    for (std::uint32_t k = 2; k < rings; ++k)
      if (random.uniform() < pattern.merge) together.unite(at(b, k - 1), at(b, k));
  }
  for (std::uint32_t b = 0; paired && b + 1 < spokes; b += 2) {
    const double length = pattern.merge * random.uniform() * rings / 2;
    for (std::uint32_t k = 1; k < rings && k < length; ++k) together.unite(at(b, k), at(b + 1, k));
  }
  for (std::uint32_t k = 0; k < plan.points.size(); ++k) plan.groups.push_back(together.find(k));
  return plan;
}

/// Radius of the crushed zone / radius of the wheel; exponent of the crumbs' density; share without ring
/// sites.
constexpr double kCrushedZone = 0.3, kCrushedExponent = 1.5, kWithoutRings = 0.6;

/// Returns the plan with crumbs in place of the innermost cells. With `inwards`, a cell behind the crumbs is
/// kept; otherwise, their cells would extend through the body. If the wheel does not break the `whole` solid
/// and none of it is near the centre, there are no crumbs, because they would be in other parts.
SitePlan with_crumbs(const Task& task, const Wheel& wheel, std::uint32_t crumbs, const SitePlan& rings,
                     const Vec3d* inwards, bool whole) {
  if (crumbs == 0) return rings;
  const Cloud zone{wheel.center, kCrushedZone * wheel.reach};
  ColumnSampler sampler(task.solid, task.seed, task.execution);
  const std::vector<std::uint32_t> cloud_of(crumbs, 0);
  std::vector<Vec3d> points =
      points_in_clouds(task, sampler, std::span(&zone, 1), cloud_of, kCrushedExponent);
  if (whole) {  // the others are anywhere in the solid
    const std::vector<Vec3d> rest = sampler.sample(crumbs - static_cast<std::uint32_t>(points.size()));
    points.insert(points.end(), rest.begin(), rest.end());
  }
  if (points.empty()) return rings;
  Pacer pacer(task.execution);
  SitePlan plan;
  std::uint32_t next = 0;
  for (std::size_t k = 0; k < rings.points.size(); ++k) {
    pacer.step();
    next = std::max(next, rings.groups[k] + 1);
    if (length(rings.points[k] - zone.center) < kWithoutRings * zone.radius) continue;
    plan.points.push_back(rings.points[k]);
    plan.groups.push_back(rings.groups[k]);
  }
  if (inwards) {
    plan.points.push_back(zone.center + zone.radius * normalized(*inwards));
    plan.groups.push_back(rings.groups[0]);
  }
  for (const Vec3d& p : points) {
    plan.points.push_back(p);
    plan.groups.push_back(next++);
  }
  return plan;
}

/// The position of a wheel.
struct WheelPlace {
  Box box;                      ///< the box of the solid or part that breaks
  std::optional<Vec3d> thin{};  ///< for a plate: the direction in which it is thin
  std::optional<Vec3d> center{}, axis{};
  std::uint32_t count = 1;  ///< number of pieces
  double least_spokes = kLeastSpokes;
  bool whole = true;  ///< the wheel breaks the whole solid
};

/// Error of a wheel with too many sites.
tl::unexpected<Error> too_many(const Task& task, double sites, const RadialPattern& pattern) {
  if (pattern.rings) return too_many_sites(task, sites, "radial", "rings", "fewer");
  if (pattern.spokes) return too_many_sites(task, sites, "radial", "spokes", "fewer");
  return too_many_sites(task, sites, "radial");
}

Expected<SitePlan> wheel_in(const Task& task, const RadialPattern& pattern, const WheelPlace& place,
                            Random& random) {
  using Around = RadialPattern::Around;
  const Box& box = place.box;
  const bool around_point =
      pattern.around == Around::kPoint || (pattern.around == Around::kShape && !place.axis && !place.thin);
  // About 0.7 of the cells of a disc around a square meet the square, and half of the cells around a point on
  // a body meet the body. The share `merge` of them is lost to merging.
  const auto crumbs = static_cast<std::uint32_t>(std::nearbyint(pattern.crushed * place.count));
  const double cells = (place.count - crumbs) / ((around_point ? 0.5 : 0.7) * (1 - pattern.merge));
  const auto count = [](const std::optional<std::uint32_t>& given, double wanted, double least, double most) {
    return given.value_or(
        static_cast<std::uint32_t>(std::nearbyint(std::fmin(most, std::fmax(least, wanted)))));
  };
  const std::uint32_t spokes =
      around_point ? count(pattern.spokes, power(1 / std::fmax(1, cells), 1.0 / 3) * cells * 1.5, 6, 100'000)
                   : count(pattern.spokes, std::sqrt(2 * cells), place.least_spokes, kMostSpokes);
  const std::uint32_t rings = count(pattern.rings, cells / spokes, 2, 1000);
  if (static_cast<double>(spokes) * rings > task.most_sites)
    return too_many(task, static_cast<double>(spokes) * rings, pattern);

  // Without an impact, the centre for a body is the middle of the side that faces the viewer (+z).
  const bool body = around_point || (pattern.crushed > 0 && !place.thin);
  const Vec3d center = place.center.value_or(box.center() + Vec3d{0, 0, body ? 0.5 * box.size().z : 0});
  if (around_point) {
    Wheel wheel{center, {}, rings, reach(box, [&](const Vec3d& p) { return length(p - center); })};
    const std::vector<double> radius = radii(pattern, wheel, random);
    // Each step turns further by the golden section of a turn.
    constexpr double kGolden = 0.6180339887498949;
    const double apart = std::sqrt(12.6 / spokes);  // distance of neighbours on the sphere, about
    for (std::uint32_t b = 0; b < spokes; ++b) {
      const double z = 1 - (2 * b + 1.0) / spokes, across = std::sqrt(std::fmax(0, 1 - z * z));
      const double turns = b * kGolden;
      const Vec2d d = unit_at(turns - std::floor(turns));
      // Draw in separate statements: compilers differ in which operand of a product they evaluate first.
      const double far = 0.5 * pattern.jitter * apart * random.uniform();
      const Vec3d off = far * random_direction(random);
      wheel.spokes.push_back(normalized(Vec3d{across * d.x, z, across * d.y} + off));
    }
    return with_crumbs(task, wheel, crumbs, plan_of(pattern, wheel, radius, false, random, task.execution),
                       nullptr, place.whole);
  }

  Vec3d axis = place.axis ? *place.axis : place.thin ? *place.thin : shortest_side(box);
  // A crushed solid splits along the direction of the hit.
  if (const Vec3d inwards = box.center() - center;
      !place.axis && body && length(inwards) > kInwards * box.longest_side())
    axis = inwards;
  const Across frame = across(axis);
  Wheel wheel{center, {}, rings, reach(box, [&](const Vec3d& p) {
                const double x = dot(p - center, frame.u), y = dot(p - center, frame.v);
                return std::sqrt(x * x + y * y);
              })};
  const std::vector<double> radius = radii(pattern, wheel, random);
  for (std::uint32_t b = 0; b < spokes; ++b) {
    const Vec2d d = unit_at((b + 0.6 * pattern.jitter * (random.uniform() - 0.5)) / spokes);
    wheel.spokes.push_back(d.x * frame.u + d.y * frame.v);
  }
  return with_crumbs(task, wheel, crumbs, plan_of(pattern, wheel, radius, true, random, task.execution),
                     &axis, place.whole);
}

/// Minimum length of a piece of a rod / the rod's width. Shorter pieces would be slices.
constexpr double kShortest = 0.5;

/// Number of pieces of the part that was hit (without a hit, the largest). Ensures that this part breaks even
/// if there are so many parts that each would get less than one piece.
constexpr std::uint32_t kLeastOfOne = 8;

Vec3d nearest_in(const Box& box, Vec3d p) {
  for (int k = 0; k < 3; ++k) p[k] = std::clamp(p[k], box.min[k], box.max[k]);
  return p;
}

/// Leaves out sites that are nearer to another part of the frame, but always keeps the one nearest to `part`.
void keep_at(const Box& part, const BoxTree& tree, const std::vector<Box>& parts, Pacer& pacer,
             SitePlan& plan) {
  SitePlan kept;
  std::size_t nearest = 0;
  double least = HUGE_VAL;
  for (std::size_t k = 0; k < plan.points.size(); ++k) {
    pacer.step(16);
    const Vec3d& p = plan.points[k];
    const double away = std::sqrt(square_distance(part, p));
    if (away < least) {
      least = away;
      nearest = k;
    }
    const auto from = [&](std::uint32_t i) { return std::sqrt(square_distance(parts[i], p)); };
    if (tree.nearest(p, away, 0, from) < away) continue;
    kept.points.push_back(p);
    kept.groups.push_back(plan.groups[k]);
  }
  if (kept.points.empty()) kept = {{plan.points[nearest]}, {0}, {}, {}};
  plan = std::move(kept);
}

/// Breaks each part separately: a plate around an axis, a body around a point, a rod across. Every part is hit
/// at its point nearest to the hit. The number of pieces is proportional to volume, or with a hit, to
/// PartShares::share.
Expected<SitePlan> by_parts(const Task& task, const RadialPattern& pattern) {
  const Solid& solid = task.seen.original();
  const CellMap& map = task.seen.map();
  const auto [shares, shapes] = shapes_for(solid, pattern, task.execution);
  const Vec3d* const hit = pattern.impacts.empty() ? nullptr : pattern.impacts.data();
  Pacer pacer(task.execution);
  double volume = 0;
  std::vector<std::uint32_t> in_frame(shapes.frames, 0);
  // The part that is hit: the nearest to the hit or, without a hit, the largest.
  std::size_t crushed = shares ? shares->nearest : 0;
  const auto later = [&](std::size_t p) {
    return hit ? square_distance(solid.parts[p].box, *hit) : -solid.parts[p].volume;
  };
  for (std::size_t p = 0; p < solid.parts.size(); ++p) {
    pacer.step(4);
    volume += solid.parts[p].volume;
    ++in_frame[shapes.frame_of_part[p]];
    if (!shares && later(p) < later(crushed)) crushed = p;
  }
  // Boxes of the parts that share a frame.
  std::vector<Box> beside;
  for (std::size_t p = 0; p < solid.parts.size(); ++p) {
    const Box& box = solid.parts[p].box;
    const CellMap::Frame& frame = map.of_part(static_cast<std::uint32_t>(p));
    pacer.step(4);
    if (in_frame[shapes.frame_of_part[p]] > 1) beside.push_back({frame.image(box.min), frame.image(box.max)});
  }
  const BoxTree tree(beside, task.execution);
  SitePlan plan;
  std::uint32_t groups = 0;
  for (std::size_t p = 0; p < solid.parts.size(); ++p) {
    pacer.step(16);
    const PartShape& shape = shapes.of_part[p];
    const CellMap::Frame& frame = map.of_part(static_cast<std::uint32_t>(p));
    const Box& box = solid.parts[p].box;
    const double share = shares ? shares->share[p] : solid.parts[p].volume / volume;
    auto count = static_cast<std::uint32_t>(std::nearbyint(task.count * share));
    if (p == crushed && count < 2) count = std::min(task.count, kLeastOfOne);
    const bool alone = in_frame[shapes.frame_of_part[p]] == 1;
    // Parts that share a frame and are too small for a piece belong to the cells of their neighbours in it.
    if (count == 0 && !alone) continue;
    Random random(mix64(task.seed ^ kRadialStream, p));
    Expected<SitePlan> own = SitePlan{{frame.image(shape.middle)}, {0}, {}, {}};
    if (count > 1 && shape.rod && shape.rod->to - shape.rod->from >= kShortest * count * shape.rod->width) {
      own = across_rod(task, pattern, shape, frame, hit, count, random);
    } else if (count > 1) {
      RadialPattern of_part = pattern;
      if (p != crushed) of_part.crushed = 0;
      WheelPlace place;
      place.box.add(frame.image(box.min));
      place.box.add(frame.image(box.max));
      place.thin = shape.thin;
      if (hit) place.center = frame.image(nearest_in(box, *hit));
      place.count = count;
      place.least_spokes = std::fmin(kLeastSpokes, std::fmax(4, count));
      place.whole = false;
      own = wheel_in(task, of_part, place, random);
      if (own && !alone) keep_at(place.box, tree, beside, pacer, *own);
    }
    if (!own) return own;
    std::uint32_t most = 0;
    for (std::size_t k = 0; k < own->points.size(); ++k) {
      pacer.step();
      plan.points.push_back(own->points[k]);
      plan.groups.push_back(groups + own->groups[k]);
      most = std::max(most, own->groups[k]);
    }
    groups += most + 1;
    if (plan.points.size() > task.most_sites)
      return too_many(task, static_cast<double>(plan.points.size()), pattern);
  }
  return plan;
}

}  // namespace

double expected_sites(const RadialPattern& pattern, double count, const Vec3d&) {
  // Omitting a ring crack merges several cells into one piece.
  if (pattern.spokes && pattern.rings)
    return static_cast<double>(*pattern.spokes) * *pattern.rings + pattern.crushed * count;
  return 2 * count;
}

Expected<SitePlan> generate(const Task& task, const RadialPattern& pattern, const ImageMap& map) {
  if (breaks_by_parts(pattern) && map.frames().size() > 1) return by_parts(task, pattern);
  const std::vector<Vec3d> impacts = mapped(pattern.impacts, map);
  // If an axis is given, the shape only affects where the crushed zone begins.
  const bool shape_matters =
      pattern.around != RadialPattern::Around::kPoint && (!pattern.axis || pattern.crushed > 0);
  WheelPlace place;
  place.box = task.solid.box;
  if (shape_matters) place.thin = thin_axis(task.solid, task.execution);
  place.count = task.count;
  if (!impacts.empty()) place.center = impacts[0];
  if (pattern.axis) place.axis = map ? map.of_part(0).matrix * *pattern.axis : *pattern.axis;
  Random random(task.seed ^ kRadialStream);
  return wheel_in(task, pattern, place, random);
}

}  // namespace fracture::sites_detail
