// The sites of impacts on a solid of several parts: each part near an impact gets its share
// (part_shares.hpp), however thin it is.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/base/pacer.hpp"
#include "common/sites/arithmetic.hpp"
#include "common/sites/generators.hpp"
#include "common/sites/part_shares.hpp"

namespace fracture::sites_detail {
namespace {

constexpr std::uint64_t kPartStream = 0x9a27'0000'0000'0001ull;
/// Points drawn in a part for each site that is chosen from them.
constexpr std::uint32_t kCandidates = 16, kLeastCandidates = 256;
/// Within this share of the radius, the density no longer grows.
constexpr double kFlatTop = 1.0 / 256;

/// Divides `count` in proportion to the shares, which add up to 1 (largest remainders, ties to the first).
std::vector<std::uint32_t> divided(std::uint32_t count, const std::vector<double>& shares,
                                   const Execution& execution) {
  std::vector<std::uint32_t> counts(shares.size()), order(shares.size());
  std::iota(order.begin(), order.end(), 0u);
  std::uint32_t given = 0;
  for (std::size_t p = 0; p < shares.size(); ++p) {
    counts[p] = static_cast<std::uint32_t>(std::floor(count * shares[p]));
    given += counts[p];
  }
  const auto remainder = [&](std::uint32_t p) { return count * shares[p] - std::floor(count * shares[p]); };
  sort_with_polls(execution, order.begin(), order.end(), [&](std::uint32_t x, std::uint32_t y) {
    return remainder(x) != remainder(y) ? remainder(x) > remainder(y) : x < y;
  });
  for (std::size_t k = 0; k < order.size() && given < count; ++k)
    if (shares[order[k]] > 0) ++counts[order[k]], ++given;
  return counts;
}

/// The surface of a part of the image: positions, triangles and box.
Solid surface_of(const Solid& solid, std::uint32_t part, std::size_t begin, std::size_t end, Pacer& pacer) {
  Solid alone;
  alone.box = solid.parts[part].box;
  std::vector<VertexId> vertices;
  for (std::size_t t = begin; t < end; ++t) {
    pacer.step(2);
    vertices.insert(vertices.end(), solid.triangles[t].begin(), solid.triangles[t].end());
  }
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  for (const VertexId v : vertices) alone.positions.push_back(solid.positions[v]);
  const auto number = [&](VertexId v) {
    return static_cast<VertexId>(std::lower_bound(vertices.begin(), vertices.end(), v) - vertices.begin());
  };
  for (std::size_t t = begin; t < end; ++t) {
    pacer.step(8);
    const auto& [a, b, c] = solid.triangles[t];
    alone.triangles.push_back({number(a), number(b), number(c)});
  }
  return alone;
}

/// Chooses `count` of the candidates, with a probability that falls with the distance to the nearest cloud's
/// centre as the density of the cloud does: weighted sampling without replacement (Efraimidis & Spirakis 2006,
/// in the form with exponential keys). Candidates outside all clouds are never chosen.
std::vector<Vec3d> chosen(const std::vector<Vec3d>& candidates, std::span<const Cloud> clouds,
                          double exponent, std::uint32_t count, Random& random, Pacer& pacer) {
  std::vector<std::pair<double, std::uint32_t>> keys;
  for (std::uint32_t k = 0; k < candidates.size(); ++k) {
    pacer.step(16 + clouds.size());
    const double draw = random.uniform();
    double nearest = HUGE_VAL;  // in radii
    for (const Cloud& cloud : clouds)
      nearest = std::fmin(nearest, length(candidates[k] - cloud.center) / cloud.radius);
    if (!(nearest <= 1)) continue;
    const double weight = power(kFlatTop / std::fmax(nearest, kFlatTop), exponent);
    keys.emplace_back(-logarithm(1 - draw) / weight, k);
  }
  std::sort(keys.begin(), keys.end());
  if (keys.size() > count) keys.resize(count);
  std::vector<Vec3d> points;
  for (const auto& [key, k] : keys) points.push_back(candidates[k]);
  return points;
}

}  // namespace

std::vector<Vec3d> points_near_parts(const Task& task, std::span<const Vec3d> impacts, double radius,
                                     double exponent, const PartShares& shares, std::uint32_t count) {
  const CellMap& map = task.seen.map();
  const std::vector<std::uint32_t> counts = divided(count, shares.near, task.execution);
  Pacer pacer(task.execution);
  std::vector<Vec3d> points;
  std::size_t begin = 0;
  for (std::uint32_t p = 0; p < counts.size(); ++p) {
    std::size_t end = begin;
    while (end < task.solid.part.size() && task.solid.part[end] == p) ++end;
    pacer.step(end - begin);
    if (counts[p] > 0 && begin < end) {
      const Solid alone = surface_of(task.solid, p, begin, end, pacer);
      Task own = task;
      own.seed = mix64(task.seed ^ kPartStream, p);
      std::vector<Cloud> clouds;
      for (const Vec3d& impact : impacts)
        clouds.push_back({map ? map.of_part(p).image(impact) : impact, radius});
      std::vector<std::uint32_t> cloud_of(counts[p]);
      for (std::uint32_t k = 0; k < counts[p]; ++k)
        cloud_of[k] = k % static_cast<std::uint32_t>(clouds.size());
      ColumnSampler sampler(alone, own.seed, task.execution);
      const std::vector<Vec3d> drawn = points_in_clouds(own, sampler, clouds, cloud_of, exponent);
      points.insert(points.end(), drawn.begin(), drawn.end());
      // Few draws are in a thin part. The other sites are chosen from points that are spread in it.
      if (const auto missing = counts[p] - static_cast<std::uint32_t>(drawn.size()); missing > 0) {
        Random random(own.seed);
        const std::vector<Vec3d> more =
            chosen(sampler.spread(std::max(kLeastCandidates, kCandidates * missing)), clouds, exponent,
                   missing, random, pacer);
        points.insert(points.end(), more.begin(), more.end());
      }
    }
    begin = end;
  }
  return points;
}

}  // namespace fracture::sites_detail
