// Rows for the material, the pattern, and the parameters that several patterns share.
#include "common/parameters/fields.hpp"
#include "common/parameters/rows.hpp"

namespace fracture {
namespace {

using parameter_fields::kFar;
using parameter_fields::kLeastConditioning;
using parameter_fields::pattern_name;
using parameter_fields::with_member;

ParameterSpec material_row() {
  ParameterSpec spec{
      .name = "material",
      .type = Type::kChoice,
      .doc =
          "Preset for `pattern` and most other parameters, including the look of cuts and the physics. Parameters that "
          "you give override it."};
  for (const MaterialPreset& preset : material_presets()) spec.choices.emplace_back(preset.name);
  spec.set = [](RequestParameters& r, const ParameterSpec&, const ParameterValue& value) {
    const MaterialPreset& preset = material_presets()[std::get<std::uint64_t>(value)];
    r.material = preset.name;
    r.fracture.pattern = preset.pattern;
    r.fracture.lloyd = preset.lloyd;
    r.fracture.anisotropy = {.stretch = preset.stretch,
                             .grain_of = preset.grain ? GrainOf::kSolid : GrainOf::kPart,
                             .grain = preset.grain};
    r.fracture.aggregation = preset.aggregation;
    r.fracture.roughness = preset.roughness;
    r.fracture.size.min_of_mean = kLeastOfMean;
    r.hollow = {.fraction = preset.shell_fraction, .least_ball = preset.shell_fraction > 0 ? kLeastBall : 0};
    r.physical = preset.physical;
    r.interior_color = preset.look.color;
    r.interior = {.color = linear_color(preset.look.color),
                  .roughness = preset.look.roughness,
                  .metallic = preset.look.metallic,
                  .opacity = preset.look.opacity,
                  .mix = preset.look.mix,
                  .shade = preset.look.shade,
                  .crushed = preset.look.crushed};
    r.exterior = {.choice = r.exterior.choice,
                  .color = linear_color(preset.look.color),
                  .roughness = preset.look.outside_roughness,
                  .metallic = preset.look.metallic,
                  .opacity = preset.look.opacity};
  };
  spec.get = [](const RequestParameters& r, const ParameterSpec&) {
    return r.material.empty() ? nlohmann::json() : nlohmann::json(r.material);
  };
  return spec;
}

template <std::size_t... k>
SitePattern pattern_at(std::size_t index, std::index_sequence<k...>) {
  SitePattern pattern;
  ((index == k ? void(pattern.emplace<k>()) : void()), ...);
  return pattern;
}

ParameterSpec pattern_row() {
  ParameterSpec spec{.name = "pattern",
                     .type = Type::kChoice,
                     .doc = "How the Voronoi sites are arranged. A piece forms around each site.",
                     .decides = Decides::kSites};
  for (const PatternTraits& pattern : kPatternTraits) spec.choices.emplace_back(pattern.name);
  spec.set = [](RequestParameters& r, const ParameterSpec&, const ParameterValue& value) {
    const auto index = static_cast<std::size_t>(std::get<std::uint64_t>(value));
    if (r.fracture.pattern.index() == index) return;  // keeps the values of a material
    r.fracture.pattern = default_pattern(index);
    // Relaxation moves individual sites, and slices have their own directions.
    if (!std::holds_alternative<ImpactPattern>(r.fracture.pattern) &&
        !std::holds_alternative<ClusteredPattern>(r.fracture.pattern))
      r.fracture.lloyd = 0;
    if (std::holds_alternative<SlicePattern>(r.fracture.pattern)) r.fracture.anisotropy = {};
    if (!is_scattered(r.fracture.pattern)) r.fracture.aggregation = {};
  };
  spec.get = [](const RequestParameters& r, const ParameterSpec&) {
    return kPatternTraits[r.fracture.pattern.index()].name;
  };
  return spec;
}

ParameterSpec for_patterns(std::vector<std::string> patterns, ParameterSpec spec) {
  spec.decides = Decides::kSites;
  spec.patterns = std::move(patterns);
  return spec;
}

void add_general_rows(std::vector<ParameterSpec>& rows, std::uint32_t max_sites) {
  rows.push_back(for_patterns(
      patterns_that(&PatternTraits::counted),
      with_member(
          {.name = "sites",
           .type = Type::kInteger,
           .min = 1,
           .max = max_sites,
           .doc =
               "The pattern makes `sites` times `cells_per_fragment` cells. This number is exact only with `uniform`, "
               "`impact` and `clustered`. A cell makes a fragment in each separate part of the mesh. To set the number "
               "of fragments, use `fragments`."},
          [](auto& r) -> auto& { return r.fracture.sites; })));
  rows.push_back(for_patterns({}, with_member(
                                      {.name = "seed",
                                       .type = Type::kInteger,
                                       .min = 0,
                                       .max = kMaxSeed,
                                       .doc = "Seed for random numbers. The same seed gives the same bytes."},
                                      [](auto& r) -> auto& { return r.fracture.seed; })));
  rows.push_back(for_patterns(
      patterns_that(&PatternTraits::relaxed),
      with_member(
          {.name = "lloyd",
           .type = Type::kInteger,
           .min = 0,
           .max = 50,
           .doc =
               "Number of relaxation passes. Each pass moves every site to the centre of its piece, so the pieces become "
               "more equal in size."},
          [](auto& r) -> auto& { return r.fracture.lloyd; })));
  rows.push_back(for_patterns(
      {"uniform", "impact", "clustered"},
      with_member(
          {.name = "density_from",
           .type = Type::kText,
           .doc =
               "Vertex colours (COLOR_0 to COLOR_7) or a material (name or index) that set the density of sites. Pieces "
               "are smaller in white areas, or near surfaces with the material. In black areas, or near other surfaces, "
               "sites are 1/32 as dense."},
          [](auto& r) -> auto& { return r.fracture.density_from; })));
  ParameterSpec stretch = for_patterns(
      {},
      with_member(
          {.name = "stretch",
           .type = Type::kNumber,
           .low = 0.01,
           .high = 100,
           .doc =
               "Length of the pieces along the grain, relative to their width. Use more than 1 for fibres, and less than "
               "1 for layers. Lengths such as `radius` are measured across the grain."},
          [](auto& r) -> auto& { return r.fracture.anisotropy.stretch; }));
  stretch.get = [get = stretch.get](const RequestParameters& r, const ParameterSpec& s) {
    return r.fracture.anisotropy.matrix ? nlohmann::json() : get(r, s);
  };
  rows.push_back(std::move(stretch));
  rows.push_back(
      for_patterns({}, with_member(
                           {.name = "grain",
                            .type = Type::kDirection,
                            .low = -kFar,
                            .high = kFar,
                            .doc = "Direction of the grain (see `stretch`). Default: set by `grain_of`."},
                           [](auto& r) -> auto& { return r.fracture.anisotropy.grain; })));
  ParameterSpec grain_of = for_patterns(
      {},
      with_member(
          {.name = "grain_of",
           .type = Type::kChoice,
           .choices = {"solid", "part", "node", "material"},
           .doc =
               "If `grain` is missing, each of these bodies gets its own grain, along its longest axis. Patterns other "
               "than `uniform`, `impact` and `clustered` use `solid`. `solid`: the whole mesh. `part`: each connected "
               "part. `node`: all parts of a node. `material`: all parts with the same material on most of their "
               "surface."},
          [](auto& r) -> auto& { return r.fracture.anisotropy.grain_of; }));
  grain_of.matters = [](const RequestParameters& r) {
    const Anisotropy& a = r.fracture.anisotropy;
    return a.stretch != 1 && !a.grain && !a.matrix && is_scattered(r.fracture.pattern);
  };
  grain_of.set = [set = grain_of.set](RequestParameters& r, const ParameterSpec& s,
                                      const ParameterValue& value) {
    r.fracture.anisotropy.grain.reset();  // replaces the grain of a material
    set(r, s, value);
  };
  rows.push_back(std::move(grain_of));
  ParameterSpec matrix = for_patterns(
      {},
      with_member(
          {.name = "stretch_matrix",
           .type = Type::kMatrix,
           .low = -1000,
           .high = 1000,
           .doc =
               "Matrix (row by row) that stretches and shears every piece, instead of `stretch` and `grain`."},
          [](auto& r) -> auto& { return r.fracture.anisotropy.matrix; }));
  matrix.check = [](const ParameterValue& value) -> std::optional<std::string> {
    const auto& m = std::get<Matrix3>(value);
    if (m.conditioning() >= kLeastConditioning && std::fabs(m.determinant()) >= 1e-6) return std::nullopt;
    return "have a determinant of at least 1e-6, and of at least 0.001 times the product of its rows' lengths: this "
           "matrix is singular or nearly singular";
  };
  matrix.set = [](RequestParameters& r, const ParameterSpec&, const ParameterValue& value) {
    r.fracture.anisotropy = {.matrix = std::get<Matrix3>(value)};  // replaces the stretch of a material
  };
  rows.push_back(std::move(matrix));
}

/// Rows for fragments that consist of several cells, for the patterns that support them.
void add_aggregate_rows(std::vector<ParameterSpec>& rows) {
  const std::vector<std::string> patterns{pattern_name<UniformPattern>(), pattern_name<ImpactPattern>(),
                                          pattern_name<ClusteredPattern>()};
  rows.push_back(for_patterns(
      patterns,
      with_member(
          {.name = "cells_per_fragment",
           .type = Type::kInteger,
           .min = 1,
           .max = kMostCellsPerFragment,
           .doc =
               "Mean number of cells per fragment. Values above 1 make ragged, non-convex chunks, which are longer in the "
               "direction away from an impact. `size_spread` varies their sizes."},
          [](auto& r) -> auto& {
            return r.idle_aggregation ? r.idle_aggregation->cells : r.fracture.aggregation.cells;
          })));
  rows.back().matters = [](const RequestParameters& r) {  // 1 matters if the material has more
    if (r.idle_aggregation) return false;
    const MaterialPreset* preset = find_material_preset(r.material);
    return r.fracture.aggregation.cells > 1 || (preset && preset->aggregation.cells > 1);
  };
  rows.push_back(for_patterns(
      patterns,
      with_member(
          {.name = "size_spread",
           .type = Type::kNumber,
           .low = 0,
           .high = kMostSpread,
           .doc =
               "Spread of the volumes of ragged chunks. The fraction of chunks with a volume above v is "
               "exp(-(v/s)^(1/size_spread)), where s is a constant (Weibull 1951). 0: equal volumes. 1: as in Grady and "
               "Kipp (1985). 2: as in Mott and Linfoot (1943)."},
          [](auto& r) -> auto& {
            return r.idle_aggregation ? r.idle_aggregation->spread : r.fracture.aggregation.spread;
          })));
  rows.back().matters = [](const RequestParameters& r) { return r.fracture.aggregation.cells > 1; };
}

}  // namespace

SitePattern default_pattern(std::size_t index) {
  return pattern_at(index, std::make_index_sequence<std::variant_size_v<SitePattern>>{});
}

std::vector<ParameterSpec> site_parameter_rows(std::uint32_t max_sites) {
  std::vector<ParameterSpec> rows{material_row(), pattern_row()};
  add_general_rows(rows, max_sites);
  add_aggregate_rows(rows);
  for (ParameterSpec& row : pattern_parameter_rows(max_sites)) rows.push_back(std::move(row));
  return rows;
}

std::vector<std::string> patterns_that(bool PatternTraits::*may) {
  std::vector<std::string> names;
  for (const PatternTraits& pattern : kPatternTraits)
    if (pattern.*may) names.emplace_back(pattern.name);
  return names;
}

}  // namespace fracture
