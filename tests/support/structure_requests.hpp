// One request for every way to bound, join, keep, hold and hit, for a given solid. The invariants must hold
// for each.
#pragma once

#include "common/solid/solid.hpp"
#include "tests/support/pattern_requests.hpp"

namespace fracture::test {

inline std::vector<NamedParameters> structure_requests(const Solid& solid, std::uint32_t sites,
                                                       std::uint64_t seed) {
  std::vector<NamedParameters> all;
  const Box& box = solid.box;
  const Vec3d size = box.size(), corner = box.max - 0.1 * size;
  const double side = box.longest_side(), volume = solid.report.volume;
  const auto add = [&](std::string name) -> FractureParameters& {
    NamedParameters& made = all.emplace_back();
    made.name = std::move(name);
    made.parameters.sites = sites;
    made.parameters.seed = seed;
    return made.parameters;
  };
  add("min_fraction").size.min_fraction = 1.5 / sites;
  add("max_volume").max_volume = volume / (2 * sites);
  add("max_fragments").size.max_fragments = sites / 3 + 1;
  add("fragments").size.fragments = sites / 2 + 1;
  add("min_of_mean").size.min_of_mean = 0.3;
  add("max_triangles").size.max_triangles = 2 * solid.triangles.size() + 20 * sites;
  FractureParameters& brick = add("brick_max_fragments");
  brick.pattern = BrickPattern{.jitter = 0.3};
  brick.size.max_fragments = sites / 2 + 1;
  FractureParameters& grain = add("grain_min_fraction");
  grain.anisotropy = {.stretch = 5, .grain = Vec3d{1, 2, -0.5}};
  grain.size.min_fraction = 0.7 / sites;
  add("keep_sphere").keep = Region{.center = corner, .radius = 0.3 * side};
  add("keep_box").keep = Region{.shape = Region::Shape::kBox, .box = {box.min, box.min + 0.4 * size}};
  FractureParameters& levels = add("levels");
  levels.levels = {2, sites / 4 + 3, sites + 5};
  levels.sites = sites + 5;
  levels.anchors.planes = {{.normal = {0, 1, 0}, .offset = box.min.y + 0.1 * size.y}};
  levels.anchors.points = {corner};
  levels.hulls = Hulls::kConvex;
  const auto vertex_near = [&](const Vec3d& p) {
    Vec3d best = to_double(solid.positions[0]);
    for (const Vec3f& v : solid.positions)
      if (length(to_double(v) - p) < length(best - p)) best = to_double(v);
    return best;
  };
  const LocalImpact hit{.point = vertex_near(corner), .radius = 0.2 * side, .sites = sites / 2 + 1};
  add("local_whole").hits = {hit};
  FractureParameters& hits = add("local_fractured");
  hits.hits = {hit, {.point = vertex_near(box.min), .radius = 0.2 * side, .sites = sites / 4 + 1}, hit};
  hits.rest = LocalRest::kFractured;
  const std::vector<LocalImpact> three = hits.hits;
  const auto add_aggregates = [&](std::string name) -> FractureParameters& {
    FractureParameters& made = add(std::move(name));
    made.sites = sites / 4 + 1;
    made.aggregation = {5, 1};
    made.hulls = Hulls::kConvex;
    return made;
  };
  add_aggregates("aggregates_max_volume").max_volume = volume / sites;
  add_aggregates("aggregates_fragments").size.fragments = sites / 4 + 1;
  add_aggregates("aggregates_keep").keep = Region{.center = corner, .radius = 0.3 * side};
  add_aggregates("aggregates_local_whole").hits = {hit};
  FractureParameters& local = add_aggregates("aggregates_local_fractured");
  local.hits = three;
  local.rest = LocalRest::kFractured;
  return all;
}

}  // namespace fracture::test
