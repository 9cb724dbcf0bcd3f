// Masonry. Walls (masonry.hpp) are divided into bricks laid in courses along the axes of the wall. Other
// parts become rubble: flat stones of the same volume as a brick. A solid with more bricks than pieces breaks
// into lumps of bricks, with edges toothed like the courses; real walls collapse this way. The bricks nearest
// to a hit are crushed, those around them are halved, and the next ones come off singly. Lumps grow larger
// with the distance from the hit.
#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <queue>
#include <string>

#include "common/base/pacer.hpp"
#include "common/base/words.hpp"
#include "common/bvh/box_tree.hpp"
#include "common/sites/arithmetic.hpp"
#include "common/sites/courses.hpp"
#include "common/sites/masonry.hpp"

namespace fracture::sites_detail {
namespace {

constexpr std::uint64_t kBrickStream = 0x6a1d'0000'0000'0001ull;

/// Size of a real brick, m: length, height and depth of the German normal format (DIN 105), 240 x 71 x 115
/// mm.
constexpr Vec3d kReal{0.24, 0.071, 0.115};
/// Maximum number of bricks per piece, on average. Beyond it, bricks become larger than real ones, because
/// more bricks cost more time.
constexpr double kMostInPiece = 6;
/// Shares of the pieces of a solid that was hit: crushed bricks (in quarters), halved bricks, and single
/// bricks.
constexpr double kCrushed = 0.05, kHalved = 0.1, kSingle = 0.2;
constexpr std::uint32_t kCrumbs = 4;

constexpr int kMostScales = 4;  // maximum number of sizes to try
constexpr double kMostCells = 4e6;

double most_in_piece(double count) {
  return std::fmax(1, std::fmin(kMostInPiece, kMaxPatternSites / (2.5 * count)));
}

/// Size of a brick relative to a real one, so that `volume` (m³) contains about count to count *
/// most_in_piece() bricks.
double scale_for(double volume, double count) {
  const double real = volume / (kReal.x * kReal.y * kReal.z);
  const double bricks = std::fmax(count, std::fmin(real, count * most_in_piece(count)));
  return real > 0 ? power(std::fmin(1, real / bricks), 1.0 / 3) / power(std::fmin(1, bricks / real), 1.0 / 3)
                  : 1;
}

/// The parts of the solid that share courses, or that are one heap of rubble.
struct Place {
  Box box;  ///< in the image
  bool is_wall;
  double volume = 0;  ///< m³
  std::vector<bool> of_parts;
};

std::vector<Place> places_of(const Task& task, const BrickPattern& pattern) {
  const Solid& solid = task.solid;
  const Anisotropy& anisotropy = task.anisotropy;
  if (anisotropy.matrix || anisotropy.stretch != 1)
    return {{solid.box, true, solid.report.volume, std::vector<bool>(solid.parts.size(), true)}};
  const Masonry masonry =
      masonry_of(task.seen.original(), !pattern.cell, CellMap::kMostFrames, task.execution);
  std::vector<Place> places;
  const bool several = masonry.frames.size() > 1;
  for (std::size_t k = 0; k < masonry.frames.size(); ++k)
    places.push_back({several ? task.seen.map().place_of(k) : solid.box, masonry.frames[k].is_wall, 0,
                      std::vector<bool>(solid.parts.size(), false)});
  Pacer pacer(task.execution);
  for (std::size_t p = 0; p < solid.parts.size(); ++p) {
    pacer.step();
    Place& place = places[masonry.of_part[p]];
    place.of_parts[p] = true;
    place.volume += solid.parts[p].volume;
  }
  return places;
}

/// Adds rubble: stones at uniform random points of the parts that are not walls.
void add_rubble(const Task& task, ColumnSampler& sampler, const std::vector<Place>& places,
                double brick_volume, const Vec3d& brick, Bricks& bricks) {
  double volume = 0, all = 0;
  for (const Place& place : places) {
    all += place.volume;
    if (!place.is_wall) volume += place.volume;
  }
  if (!(volume > 0)) return;
  const double wanted = std::ceil(volume / brick_volume) * all / volume;
  const auto points =
      sampler.sample(static_cast<std::uint32_t>(std::fmin(std::fmax(1, wanted), kMaxPatternSites)));
  const double h =
      0.7 * brick.z;  // over half the cube root of the volume, so that neighbouring boxes overlap
  const Vec3d half{h, h, h};
  Pacer pacer(task.execution);
  for (const Vec3d& p : points) {
    pacer.step(2);
    if (places.size() > 1 && places[task.seen.map().index_at(p)].is_wall) continue;
    bricks.bricks.push_back({p, half, static_cast<std::uint32_t>(bricks.cells.size())});
    bricks.cells.push_back(p);
  }
}

/// Distance of each brick to the nearest hit, m.
std::vector<double> distances_to(const std::vector<Vec3d>& impacts, const Task& task, const Bricks& bricks) {
  const CellMap& map = task.seen.map();
  Pacer pacer(task.execution);
  std::vector<double> distances;
  for (const Bricks::Brick& brick : bricks.bricks) {
    pacer.step(impacts.size());
    const Vec3d place = map ? map.at(brick.middle).place(brick.middle) : brick.middle;
    double least = HUGE_VAL;
    for (const Vec3d& impact : impacts) least = std::fmin(least, length(place - impact));
    distances.push_back(least);
  }
  return distances;
}

/// Chooses the bricks where lumps start: `count` of order[first, …), at random; if there are hits, fewer far
/// from them.
std::vector<std::uint32_t> seeds_among(const std::vector<std::uint32_t>& order, std::size_t first,
                                       std::size_t count, const std::vector<double>& distance, Random& random,
                                       Pacer& pacer) {
  std::vector<std::uint32_t> rest;
  for (std::size_t k = first; k < order.size(); ++k) {
    pacer.step();
    rest.push_back(order[k]);
  }
  const double nearest = distance.empty() ? 1 : distance[rest.front()];
  std::vector<std::uint32_t> seeds;
  for (std::size_t patience = 64 * count; seeds.size() < count; patience -= patience > 0) {
    pacer.step(2);
    const auto k = static_cast<std::size_t>(random.below(rest.size()));
    const double keep = random.uniform();
    if (!distance.empty() && patience > 0 && keep * distance[rest[k]] > nearest) continue;
    seeds.push_back(rest[k]);
    rest[k] = rest.back();
    rest.pop_back();
  }
  return seeds;
}

/// Whether two bricks share more than an edge. For stones: whether they are near enough to touch.
bool touch(const Bricks::Brick& a, const Bricks::Brick& b) {
  constexpr double kShared = 0.01;  // share of a side
  int apart = 0;
  for (int k = 0; k < 3; ++k) {
    const double overlap = a.half[k] + b.half[k] - std::fabs(a.middle[k] - b.middle[k]);
    apart += overlap < kShared * a.half[k];
  }
  return apart <= 1;
}

/// Returns the lump of each brick in order[first, …). Lumps grow from the seeds, from brick to touching
/// brick, in order of distance from the seed. So each lump is connected. O(n log n).
std::vector<std::uint32_t> lumps_from(const std::vector<std::uint32_t>& seeds, const Bricks& bricks,
                                      const std::vector<std::uint32_t>& order, std::size_t first,
                                      const Execution& execution) {
  Pacer pacer(execution);
  std::vector<Box> boxes;
  for (const Bricks::Brick& brick : bricks.bricks) {
    pacer.step();
    const Vec3d half = 1.05 * brick.half;
    boxes.push_back({brick.middle - half, brick.middle + half});
  }
  const BoxTree tree(boxes, execution);
  std::vector<bool> free(bricks.bricks.size(), false);
  for (std::size_t k = first; k < order.size(); ++k) free[order[k]] = true;
  struct Step {
    double square;  ///< squared distance to the seed
    std::uint32_t lump, brick;
    auto operator<=>(const Step&) const = default;
  };
  std::priority_queue<Step, std::vector<Step>, std::greater<>> next;
  const auto square_to = [&](std::uint32_t lump, std::uint32_t brick) {
    const Vec3d to = bricks.bricks[seeds[lump]].middle - bricks.bricks[brick].middle;
    return dot(to, to);
  };
  std::vector<std::uint32_t> lump_of(bricks.bricks.size(), 0);
  const auto grow = [&] {
    while (!next.empty()) {
      pacer.step(32);
      const Step step = next.top();
      next.pop();
      if (!free[step.brick]) continue;
      free[step.brick] = false;
      lump_of[step.brick] = step.lump;
      tree.each_overlapping(boxes[step.brick], [&](std::uint32_t other) {
        pacer.step();
        if (free[other] && touch(bricks.bricks[step.brick], bricks.bricks[other]))
          next.push({square_to(step.lump, other), step.lump, other});
      });
    }
  };
  for (std::uint32_t s = 0; s < seeds.size(); ++s) next.push({0, s, seeds[s]});
  grow();
  // Bricks that touch no lump (in other parts of the solid, or beyond the crushed zone) join the nearest
  // lump.
  for (std::size_t k = first; k < order.size(); ++k) {
    pacer.step();
    if (!free[order[k]]) continue;
    Step nearest{HUGE_VAL, 0, order[k]};
    for (std::uint32_t s = 0; s < seeds.size(); ++s) {
      pacer.step();
      nearest = std::min(nearest, Step{square_to(s, order[k]), s, order[k]});
    }
    next.push(nearest);
    grow();
  }
  return lump_of;
}

/// Divides the bricks into pieces: returns their sites, and each site's group.
SitePlan break_up(const Task& task, const BrickPattern& pattern, Bricks bricks, Random& random) {
  Pacer pacer(task.execution);
  SitePlan plan;
  const std::size_t count = bricks.bricks.size();
  std::vector<std::uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0u);
  std::vector<double> distance;
  std::size_t crushed = 0, halved = 0, single = 0;
  if (!pattern.impacts.empty()) {
    distance = distances_to(pattern.impacts, task, bricks);
    std::vector<double> ragged;  // makes the edge of the crushed zone uneven
    for (const double d : distance) ragged.push_back(d * (0.75 + 0.5 * random.uniform()));
    sort_with_polls(task.execution, order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
      return ragged[a] != ragged[b] ? ragged[a] < ragged[b] : a < b;
    });
    const auto share = [&](double of) {
      return std::min(count, static_cast<std::size_t>(std::nearbyint(of * task.count)));
    };
    crushed = share(kCrushed);
    halved = std::min(count, crushed + share(kHalved));
    single = std::min(count, halved + share(kSingle));
  }
  std::uint32_t next = 0;
  const auto add = [&](const Vec3d& site, std::uint32_t group, std::uint32_t brick) {
    plan.points.push_back(site);
    plan.groups.push_back(group);
    if (pattern.mortar) plan.bricks.push_back(brick);
  };
  for (std::size_t k = 0; k < single; ++k) {
    pacer.step(4);
    const Bricks::Brick& brick = bricks.bricks[order[k]];
    if (k < crushed) {
      for (std::uint32_t crumb = 0; crumb < kCrumbs; ++crumb) {
        Vec3d at = brick.middle;
        for (int a = 0; a < 3; ++a) at[a] += (2 * random.uniform() - 1) * brick.half[a];
        add(at, next++, kNoIndex);  // its cuts can be anywhere, not only in the joints
      }
      continue;
    }
    for (std::uint32_t c = brick.first; c < bricks.end_of(order[k]); ++c) {
      if (k < halved && c == brick.first + 1) ++next;
      add(bricks.cells[c], next, order[k]);
    }
    ++next;
  }
  // The remaining bricks become lumps, as many as there are pieces left, or single bricks.
  const std::size_t pieces = task.count > next ? task.count - next : 1;
  const bool lumps = !pattern.cell && count - single > pieces;
  std::vector<std::uint32_t> seeds;
  if (lumps) seeds = seeds_among(order, single, pieces, distance, random, pacer);
  std::vector<std::uint32_t> lump_of;
  if (lumps) lump_of = lumps_from(seeds, bricks, order, single, task.execution);
  for (std::size_t k = single; k < count; ++k) {
    pacer.step(4);
    const std::uint32_t group = next + (lumps ? lump_of[order[k]] : static_cast<std::uint32_t>(k - single));
    for (std::uint32_t c = bricks.bricks[order[k]].first; c < bricks.end_of(order[k]); ++c)
      add(bricks.cells[c], group, order[k]);
  }
  return plan;
}

void add_remarks(const std::vector<Place>& places, double scale, SitePlan& plan) {
  std::size_t none = 0, parts = 0;
  for (const Place& place : places) {
    const auto n = static_cast<std::size_t>(std::count(place.of_parts.begin(), place.of_parts.end(), true));
    parts += n;
    if (!place.is_wall) none += n;
  }
  if (none > 0 && none == parts)
    plan.remarks.warn(
        (parts == 1 ? "The mesh is not a wall" : "None of the " + grouped(parts) + " parts is a wall") +
        std::string(
            ": less than 60 % of the surface is aligned with three perpendicular axes. So the mesh breaks like "
            "masonry rubble, without courses of bricks. If you want bricks, give their size with "
            "'cell'; otherwise, choose another material or pattern."));
  else if (none > 0)
    plan.remarks.note(grouped(none) + " of " + grouped(parts) + " parts " +
                      (none == 1 ? "is not a wall" : "are not walls") +
                      " (less than 60 % of the surface is aligned with three perpendicular axes) and " +
                      (none == 1 ? "becomes" : "become") + " masonry rubble instead of courses of bricks.");
  if (std::fabs(scale - 1) > 0.05)
    plan.remarks.note(
        "Bricks are " + short_number(std::nearbyint(100 * scale)) +
        " % of the size of real ones. This size gives at least one brick, and at most six, for each "
        "requested piece.");
}

}  // namespace

double expected_sites(const BrickPattern& pattern, double count, const Vec3d& sides) {
  const Vec3d brick = pattern.cell ? *pattern.cell : scale_for(sides.x * sides.y * sides.z, count) * kReal;
  return cells_of_brick(pattern.bond) * boxes_in(sides, brick);
}

Expected<SitePlan> generate(const Task& task, const BrickPattern& pattern, const ImageMap&) {
  const std::vector<Place> places = places_of(task, pattern);
  ColumnSampler sampler(task.solid, task.seed, task.execution);
  double scale = scale_for(task.solid.report.volume, task.count);
  Bricks bricks;
  Random random(task.seed ^ kBrickStream);
  bool is_spread_out = false;  // bricks of the intended size would be too many, so they were enlarged
  for (int tried = 1;; ++tried) {
    bricks = {};
    random = Random(task.seed ^ kBrickStream);
    const Vec3d brick = pattern.cell ? *pattern.cell : scale * kReal;
    double cells = 0;
    for (const Place& place : places) {
      if (!place.is_wall) continue;
      const Courses courses(place.box, brick, pattern.bond, pattern.cell.has_value());
      cells += courses.cells();
      if (cells > (pattern.cell ? task.most_sites : kMostCells)) {
        if (pattern.cell || tried == kMostScales)
          return pattern.cell ? too_many_sites(task, cells, "brick", "cell", "a larger")
                              : too_many_sites(task, cells, "brick");
        break;
      }
      courses.lay(task, sampler, place.of_parts, pattern.jitter, random, bricks);
    }
    if (cells > kMostCells) {
      is_spread_out = true;
      scale *= 1.05 * power(cells / kMostCells, 1.0 / 3);
      continue;
    }
    add_rubble(task, sampler, places, brick.x * brick.y * brick.z, brick, bricks);
    // A hollow or crooked solid meets more bricks than its volume suggests, and rounding to whole bricks can
    // give too few.
    const auto count = static_cast<double>(bricks.bricks.size()), least = static_cast<double>(task.count),
               most = 1.25 * least * most_in_piece(least);
    if (pattern.cell || is_spread_out || tried == kMostScales || (count >= least && count <= most)) break;
    scale *= count < least ? std::fmin(0.95, power(count / least, 1.0 / 3))
                           : std::fmax(1.05, 1 / power(most / count, 1.0 / 3));
  }
  if (bricks.cells.size() > task.most_sites)
    return pattern.cell
               ? too_many_sites(task, static_cast<double>(bricks.cells.size()), "brick", "cell", "a larger")
               : too_many_sites(task, static_cast<double>(bricks.cells.size()), "brick");
  SitePlan plan = break_up(task, pattern, std::move(bricks), random);
  add_remarks(places, pattern.cell ? 1 : scale, plan);
  return plan;
}

}  // namespace fracture::sites_detail
