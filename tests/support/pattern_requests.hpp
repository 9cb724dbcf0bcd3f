// One request for every pattern and every material, for a given box. The invariants must hold for each.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "common/materials/materials.hpp"
#include "common/pipeline/fracture.hpp"

namespace fracture::test {

struct NamedParameters {
  std::string name;
  FractureParameters parameters;
};

/// The material's preset with this many sites.
inline FractureParameters of_material(const MaterialPreset& preset, std::uint32_t sites, std::uint64_t seed) {
  FractureParameters p;
  p.sites = sites;
  p.seed = seed;
  p.pattern = preset.pattern;
  p.lloyd = preset.lloyd;
  p.anisotropy = {.stretch = preset.stretch, .grain_of = GrainOf::kPart};
  p.roughness = preset.roughness;
  p.aggregation = preset.aggregation;
  return p;
}

inline std::vector<NamedParameters> pattern_requests(const Box& box, std::uint32_t sites,
                                                     std::uint64_t seed) {
  std::vector<NamedParameters> all;
  const Vec3d size = box.size(), corner = box.max - 0.1 * size;
  const double side = box.longest_side();
  const auto add = [&](std::string name, SitePattern pattern, Anisotropy anisotropy = {},
                       std::uint32_t lloyd = 0) {
    FractureParameters p;
    p.sites = sites;
    p.seed = seed;
    p.pattern = std::move(pattern);
    p.anisotropy = anisotropy;
    p.lloyd = lloyd;
    all.push_back({std::move(name), std::move(p)});
  };
  add("uniform", UniformPattern{});
  add("uniform_lloyd", UniformPattern{}, {}, 3);
  add("uniform_grain", UniformPattern{}, {.stretch = 6, .grain = Vec3d{1, 2, -0.5}});
  add("uniform_matrix", UniformPattern{},
      {.matrix = Matrix3{{Vec3d{2, 0.3, 0}, Vec3d{-0.4, 0.7, 1}, Vec3d{0, 1.5, -0.2}}}});
  add("uniform_grain_lloyd", UniformPattern{}, {.stretch = 4, .grain = Vec3d{0, 1, 1}}, 2);
  add("uniform_grains_lloyd", UniformPattern{}, {.stretch = 4, .grain_of = GrainOf::kPart}, 2);
  add("impact_grains", ImpactPattern{.impacts = {corner}}, {.stretch = 0.3, .grain_of = GrainOf::kPart});
  add("clustered_grains", ClusteredPattern{}, {.stretch = 3, .grain_of = GrainOf::kNode});
  add("impact", ImpactPattern{.impacts = {corner, box.center()}});
  add("impact_small", ImpactPattern{.impacts = {corner}, .radius = 0.02 * side, .exponent = 2.5, .share = 1});
  add("impact_outside", ImpactPattern{.impacts = {box.max + size}, .radius = 0.1 * side});
  add("radial", RadialPattern{});
  add("radial_in_all_directions", RadialPattern{.around = RadialPattern::Around::kPoint});
  add("radial_around_a_corner",
      RadialPattern{.around = RadialPattern::Around::kShape, .impacts = {corner}, .merge = 0});
  add("radial_crushed",
      RadialPattern{.around = RadialPattern::Around::kShape, .impacts = {corner}, .crushed = 0.4});
  add("radial_oblique", RadialPattern{.impacts = {corner}, .axis = Vec3d{1, 1, 1}, .spokes = 17, .rings = 5});
  add("grid", GridPattern{});
  add("grid_jitter", GridPattern{.jitter = 0.7});
  add("grid_stretched", GridPattern{.jitter = 0.3}, {.stretch = 0.4, .grain = Vec3d{1, 1, 0}});
  add("brick", BrickPattern{});
  add("brick_third", BrickPattern{.cell = Vec3d{0.3 * side, 0.1 * side, 0.15 * side},
                                  .bond = BrickPattern::Bond::kThird,
                                  .jitter = 0.4});
  add("brick_stack", BrickPattern{.bond = BrickPattern::Bond::kStack});
  add("brick_hit", BrickPattern{.impacts = {corner}});
  add("brick_mortar", BrickPattern{.jitter = 0.3, .impacts = {corner}, .mortar = true});
  add("slice", SlicePattern{});
  add("slice_tilted", SlicePattern{.normals = {{1, 0.5, 0.2}}, .jitter = 0.6, .tilt = 20});
  add("slice_two", SlicePattern{.normals = {{1, 0.3, 0}, {0, 1, 0.2}}});
  add("slice_three",
      SlicePattern{.normals = {{1, 0.3, 0}, {0, 1, 0.2}, {0.4, -0.2, 1}}, .spacing = 0.21 * side});
  add("clustered", ClusteredPattern{});
  const auto add_aggregates = [&](std::string name, SitePattern pattern, Anisotropy anisotropy,
                                  Aggregation aggregation) {
    add(std::move(name), std::move(pattern), anisotropy);
    all.back().parameters.sites = std::max(2u, sites / 4);
    all.back().parameters.aggregation = aggregation;
    all.back().parameters.hulls = Hulls::kConvex;
  };
  add_aggregates("aggregates", UniformPattern{}, {}, {6, 1});
  add_aggregates("aggregates_grain", UniformPattern{}, {.stretch = 3, .grain_of = GrainOf::kPart}, {3, 0});
  add_aggregates("aggregates_impact", ImpactPattern{.impacts = {corner, box.center()}}, {}, {8, 2});
  add_aggregates("aggregates_clustered", ClusteredPattern{}, {}, {12, 0.5});
  // Adds a pattern without an entry above, with its defaults. (Points are given by the caller.)
  const auto add_if_missing = [&](const auto& pattern, const PatternTraits& traits) {
    const SitePattern missing = pattern;
    if (!std::holds_alternative<PointsPattern>(missing) &&
        std::none_of(all.begin(), all.end(), [&](const NamedParameters& request) {
          return request.parameters.pattern.index() == missing.index();
        }))
      add(traits.name, missing);
  };
  [&]<std::size_t... k>(std::index_sequence<k...>) {
    (add_if_missing(std::variant_alternative_t<k, SitePattern>{}, kPatternTraits[k]), ...);
  }
  (std::make_index_sequence<std::variant_size_v<SitePattern>>{});
  for (const MaterialPreset& preset : material_presets())
    all.push_back({preset.name, of_material(preset, sites, seed)});
  return all;
}

}  // namespace fracture::test
