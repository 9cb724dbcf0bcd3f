// Sites that gather around points: the impact and clustered patterns.
#include <algorithm>
#include <cmath>

#include "common/base/pacer.hpp"
#include "common/base/words.hpp"
#include "common/bvh/box_tree.hpp"
#include "common/bvh/surface_tree.hpp"
#include "common/sites/arithmetic.hpp"
#include "common/sites/generators.hpp"

namespace fracture::sites_detail {
namespace {

constexpr std::uint64_t kCloudStream = 0xc10d'0000'0000'0001ull, kClusterStream = 0xc10d'0000'0000'0002ull;

std::uint32_t part_of(double share, std::uint32_t count) {
  return static_cast<std::uint32_t>(std::nearbyint(share * count));
}

/// Geometric mean of the sides of the box.
double mean_side(const Box& box) {
  const Vec3d size = box.size();
  const double longest = box.longest_side();
  return longest > 0 ? longest * power(size.x / longest * (size.y / longest) * (size.z / longest), 1.0 / 3)
                     : 1;
}

/// Returns the points of the clouds, followed by uniform points up to the requested number.
SitePlan with_rest(const Task& task, ColumnSampler& sampler, std::vector<Vec3d> points) {
  SitePlan plan;
  plan.points = std::move(points);
  const std::vector<Vec3d> rest =
      even_points(task, sampler, task.count - static_cast<std::uint32_t>(plan.points.size()));
  plan.points.insert(plan.points.end(), rest.begin(), rest.end());
  return plan;
}

/// Returns the images of `place`, one for each frame of the map whose parts have surface within the radius
/// (m, in the frame of the answer). If there is no such frame, uses the frame of the part with the nearest
/// box.
std::vector<Vec3d> images_near(const Task& task, const Vec3d& place, double radius) {
  const CellMap& map = task.seen.map();
  const Solid& solid = task.seen.original();
  const auto frame_of = [&](std::uint32_t part) {
    return static_cast<std::size_t>(&map.of_part(part) - map.frames().data());
  };
  Pacer pacer(task.execution);
  std::vector<bool> is_near(solid.parts.size()), meets(map.frames().size(), false);
  double least = HUGE_VAL;
  std::size_t nearest = 0;
  for (std::uint32_t p = 0; p < solid.parts.size(); ++p) {
    pacer.step(2);
    const double d = std::sqrt(square_distance(solid.parts[p].box, place));
    is_near[p] = d <= radius;
    if (d >= least) continue;
    least = d;
    nearest = frame_of(p);
  }
  for (std::size_t t = 0; t < solid.triangles.size(); ++t) {
    const std::uint32_t p = solid.part[t];
    pacer.step(is_near[p] ? 4 : 1);
    if (!is_near[p] || meets[frame_of(p)]) continue;
    const auto& [a, b, c] = solid.triangles[t];
    meets[frame_of(p)] =
        distance_to_triangle(place, to_double(solid.positions[a]), to_double(solid.positions[b]),
                             to_double(solid.positions[c])) <= radius;
  }
  if (std::find(meets.begin(), meets.end(), true) == meets.end()) meets[nearest] = true;
  std::vector<Vec3d> images;
  for (std::size_t k = 0; k < meets.size(); ++k)
    if (meets[k]) images.push_back(map.frames()[k].image(place));
  return images;
}

}  // namespace

std::vector<Vec3d> points_in_clouds(const Task& task, ColumnSampler& sampler, std::span<const Cloud> clouds,
                                    std::span<const std::uint32_t> cloud_of, double exponent) {
  // A density of r^-e in space is a density of r^(2-e) in distance, and its inverse distribution is u^(1 / (3
  // - e)).
  const double inverse = 1 / (3 - exponent);
  std::vector<Vec3d> found(cloud_of.size());
  std::vector<bool> done(cloud_of.size(), false);
  std::vector<std::uint32_t> open(cloud_of.size());
  for (std::uint32_t k = 0; k < open.size(); ++k) open[k] = k;
  // The draws of each site are made in rounds, each with its own generator, and the first draw inside the
  // solid is used. The number of rounds tested together affects only the time. It grows as fewer sites remain
  // open.
  constexpr int kDrawsPerRound = 4, kRounds = kDraws / kDrawsPerRound, kDrawsAtOnce = 512;
  Pacer pacer(task.execution);
  std::vector<Vec3d> draws;
  for (int round = 0, rounds; round < kRounds && !open.empty(); round += rounds) {
    rounds = std::clamp(kDrawsAtOnce / (kDrawsPerRound * static_cast<int>(open.size())), 1, kRounds - round);
    draws.clear();
    for (const std::uint32_t k : open) {
      Random seeder(task.seed ^ kCloudStream);
      const std::uint64_t seed = seeder() + k * 0xd1b54a32d192ed03ull;
      const Cloud& cloud = clouds[cloud_of[k]];
      for (int r = round; r < round + rounds; ++r) {
        Random random(seed + static_cast<std::uint64_t>(r) * 0x9e6c63d0876a9a47ull);
        for (int d = 0; d < kDrawsPerRound; ++d) {
          pacer.step(32);
          const double distance = cloud.radius * power(random.uniform(), inverse);
          draws.push_back(cloud.center + distance * random_direction(random));
        }
      }
    }
    const std::vector<bool> inside = sampler.inside(draws);
    const auto each = static_cast<std::ptrdiff_t>(rounds) * kDrawsPerRound;
    std::vector<std::uint32_t> still_open;
    auto first = inside.begin();
    for (const std::uint32_t k : open) {
      pacer.step(4);
      const auto hit = std::find(first, first + each, true);
      done[k] = hit != first + each;
      if (done[k])
        found[k] = draws[static_cast<std::size_t>(hit - inside.begin())];
      else
        still_open.push_back(k);
      first += each;
    }
    open.swap(still_open);
  }
  std::vector<Vec3d> points;
  for (std::size_t k = 0; k < found.size(); ++k)
    if (done[k]) points.push_back(found[k]);
  return points;
}

/// Reports sites that did not fit near an impact. If the request names no impact (a material chose the
/// pattern, for example), this is only a note, because the middle of the box may well be empty.
void add_remark(std::size_t missing, std::size_t near, const ImpactPattern& pattern, double radius,
                Remarks& remarks) {
  const std::string within = " within " + short_number(radius) + " m of ",
                    no_place = "The solid has no room for " + grouped(missing) + " of " +
                               counted(near, "site", "sites") + within,
                    evenly = missing == 1 ? "; it is placed elsewhere instead."
                                          : "; they are spread evenly instead.";
  if (pattern.impacts.empty())
    remarks.note(
        "No impact point is set ('impacts'), so the mesh breaks around the centre of its bounding box. " +
        no_place + "this centre" + evenly);
  else if (missing == near)
    remarks.warn(
        "The solid has no room for sites" + within +
        "the impacts, so pieces are not smaller there than elsewhere. Move 'impacts' onto the mesh, or "
        "give a larger 'radius'.");
  else
    remarks.note(no_place + "the impacts" + evenly);
}

double expected_sites(const ImpactPattern&, double count, const Vec3d&) { return count; }
double expected_sites(const ClusteredPattern&, double count, const Vec3d&) { return count; }

Expected<SitePlan> generate(const Task& task, const ImpactPattern& pattern, const ImageMap& map) {
  ColumnSampler sampler(task.solid, task.seed, task.execution);
  const double radius = pattern.radius.value_or(box_in_image(task).longest_side() / 3);
  if (const auto shares = shares_of_parts(task.seen.original(), pattern, task.execution)) {
    const std::uint32_t count = part_of(pattern.share, task.count);
    std::vector<Vec3d> near =
        points_near_parts(task, pattern.impacts, radius, pattern.exponent, *shares, count);
    const std::size_t missing = count - near.size();
    SitePlan plan = with_rest(task, sampler, std::move(near));
    if (missing > 0) add_remark(missing, count, pattern, radius, plan.remarks);
    return plan;
  }
  std::vector<Vec3d> impacts;
  if (map.frames().size() > 1) {
    const Vec3d middle = task.seen.original().box.center();
    for (const Vec3d& impact : pattern.impacts.empty() ? std::vector{middle} : pattern.impacts)
      for (const Vec3d& image : images_near(task, impact, radius)) impacts.push_back(image);
  } else {
    impacts = mapped(pattern.impacts, map);
    if (impacts.empty()) impacts.push_back(task.solid.box.center());
  }
  std::vector<Cloud> clouds;
  for (const Vec3d& impact : impacts) clouds.push_back({impact, radius});
  // Assign sites to impacts in turn, so that every impact gets its share.
  std::vector<std::uint32_t> cloud_of(part_of(pattern.share, task.count));
  for (std::uint32_t k = 0; k < cloud_of.size(); ++k)
    cloud_of[k] = k % static_cast<std::uint32_t>(clouds.size());
  std::vector<Vec3d> near = points_in_clouds(task, sampler, clouds, cloud_of, pattern.exponent);
  const std::size_t missing = cloud_of.size() - near.size();
  SitePlan plan = with_rest(task, sampler, std::move(near));
  if (missing > 0) add_remark(missing, cloud_of.size(), pattern, radius, plan.remarks);
  return plan;
}

Expected<SitePlan> generate(const Task& task, const ClusteredPattern& pattern, const ImageMap&) {
  // Make few clusters of many sites, because a cluster's outer cells extend half-way to the sites around the
  // cluster.
  const std::uint32_t count =
      pattern.clusters.value_or(std::max(1u, task.count / task.cells_per_fragment / 40));
  ColumnSampler sampler(task.solid, task.seed, task.execution);
  Random random(task.seed ^ kClusterStream);
  const std::uint64_t center_seed = random();
  ColumnSampler of_centers(task.solid, center_seed, task.execution);
  const std::vector<Vec3d> centers = even_points(task, of_centers, count);
  const double radius = pattern.radius.value_or(0.12 * mean_side(box_in_image(task)));
  // Make uneven clusters: their shares of the sites vary by a factor of about ten.
  std::vector<Cloud> clouds;
  std::vector<double> weight;  // running sums
  double sum = 0;
  for (const Vec3d& center : centers) {
    const double size = random.uniform();
    clouds.push_back({center, radius * (0.5 + size)});
    sum += 0.1 + size * size;
    weight.push_back(sum);
  }
  std::vector<std::uint32_t> cloud_of(part_of(pattern.share, task.count));
  Pacer pacer(task.execution);
  for (std::uint32_t& cloud : cloud_of) {
    pacer.step(4);
    const double pick = random.uniform() * sum;
    cloud = static_cast<std::uint32_t>(
        std::min<std::ptrdiff_t>(std::upper_bound(weight.begin(), weight.end(), pick) - weight.begin(),
                                 static_cast<std::ptrdiff_t>(weight.size()) - 1));
  }
  std::vector<Vec3d> points = points_in_clouds(task, sampler, clouds, cloud_of, pattern.exponent);
  return with_rest(task, sampler, std::move(points));
}

}  // namespace fracture::sites_detail
