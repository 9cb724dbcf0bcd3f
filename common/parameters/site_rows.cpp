// Rows for the material, the pattern, and each pattern's parameters.
#include "common/parameters/fields.hpp"
#include "common/parameters/rows.hpp"

namespace fracture {
namespace {

using parameter_fields::kFar;
using parameter_fields::kLeastLength;
using parameter_fields::pattern_name;
using parameter_fields::with_member;
using parameter_fields::with_pattern_member;

// Matrix rows or slice normals that are closer to linear dependence than this have no usable inverse.
constexpr double kLeastConditioning = 1e-3;

ParameterSpec material_row() {
  ParameterSpec spec{
      .name = "material",
      .type = Type::kChoice,
      .doc =
          "Preset for `pattern` and most other parameters. The material sets how the mesh breaks, how the cuts look, and the "
          "density, friction, bounce and strength of the fragments. Parameters that you give override the preset."};
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
  ParameterSpec spec{
      .name = "pattern",
      .type = Type::kChoice,
      .doc =
          "How the Voronoi sites are arranged. A piece forms around each site, so the sites determine where the mesh is cut.",
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
               "Number of cells that the pattern makes. With `uniform`, `impact` and `clustered`, this is the number of Voronoi "
               "sites; with the other patterns, the number is approximate. It is multiplied by `cells_per_fragment`. A cell that "
               "extends into several parts of the mesh becomes one fragment in each part. To set the number of fragments, use "
               "`fragments`."},
          [](auto& r) -> auto& { return r.fracture.sites; })));
  rows.push_back(for_patterns(
      {},
      with_member(
          {.name = "seed",
           .type = Type::kInteger,
           .min = 0,
           .max = kMaxSeed,
           .doc =
               "Seed for all random numbers. The same seed gives the same bytes; a different seed gives different cuts."},
          [](auto& r) -> auto& { return r.fracture.seed; })));
  rows.push_back(for_patterns(
      patterns_that(&PatternTraits::relaxed),
      with_member(
          {.name = "lloyd",
           .type = Type::kInteger,
           .min = 0,
           .max = 50,
           .doc =
               "Number of relaxation passes. Each pass moves every site to the centre of its piece, so the pieces become more equal "
               "in size."},
          [](auto& r) -> auto& { return r.fracture.lloyd; })));
  rows.push_back(for_patterns(
      {"uniform", "impact", "clustered"},
      with_member(
          {.name = "density_from",
           .type = Type::kText,
           .doc =
               "The vertex colours (COLOR_0 to COLOR_7) or the material (name or index) that mark where the mesh breaks into "
               "smaller pieces. Sites are densest in white areas, or near the material's surface. In black areas, or near other "
               "surfaces, the density of sites is 1/32 of its maximum. Sites near an impact are not affected."},
          [](auto& r) -> auto& { return r.fracture.density_from; })));
  ParameterSpec stretch = for_patterns(
      {},
      with_member(
          {.name = "stretch",
           .type = Type::kNumber,
           .low = 0.01,
           .high = 100,
           .doc =
               "Length of the pieces along the grain, relative to their width across the grain. Use values above 1 for fibres and "
               "below 1 for layers. Lengths such as `radius` are then measured across the grain."},
          [](auto& r) -> auto& { return r.fracture.anisotropy.stretch; }));
  stretch.get = [get = stretch.get](const RequestParameters& r, const ParameterSpec& s) {
    return r.fracture.anisotropy.matrix ? nlohmann::json() : get(r, s);
  };
  rows.push_back(std::move(stretch));
  rows.push_back(for_patterns(
      {},
      with_member(
          {.name = "grain",
           .type = Type::kDirection,
           .low = -kFar,
           .high = kFar,
           .doc = "Direction of the grain (see `stretch`) in the whole mesh. Default: set by `grain_of`."},
          [](auto& r) -> auto& { return r.fracture.anisotropy.grain; })));
  ParameterSpec grain_of = for_patterns(
      {},
      with_member(
          {.name = "grain_of",
           .type = Type::kChoice,
           .choices = {"solid", "part", "node", "material"},
           .doc =
               "Which bodies get their own grain, along the body's longest axis, if `grain` is not given. With patterns other than "
               "`uniform`, `impact` and `clustered`, every choice has the same effect as `solid`. `solid`: the whole mesh. `part`: "
               "each connected part. `node`: all parts of a node as one body. `material`: all parts that have the same material on "
               "most of their surface, as one body."},
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
               "Matrix (row by row) that stretches and shears every piece. Use it instead of `stretch` and `grain`."},
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

/// Fragments that consist of several cells, for the patterns that support them.
void add_aggregate_rows(std::vector<ParameterSpec>& rows) {
  const std::vector<std::string> patterns{pattern_name<UniformPattern>(), pattern_name<ImpactPattern>(),
                                          pattern_name<ClusteredPattern>()};
  const std::size_t first = rows.size();
  rows.push_back(for_patterns(
      patterns,
      with_member(
          {.name = "cells_per_fragment",
           .type = Type::kInteger,
           .min = 1,
           .max = kMostCellsPerFragment,
           .doc =
               "Mean number of cells that are joined into one fragment. Values above 1 make ragged, non-convex chunks; "
               "`size_spread` controls how their sizes vary. Around an impact, chunks are longer in the direction away from it. 1: "
               "each cell is a fragment."},
          [](auto& r) -> auto& { return r.fracture.aggregation.cells; })));
  rows.back().matters = [](const RequestParameters& r) {  // 1 matters if the material has more
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
               "How uneven the volumes of ragged chunks are. The fraction of chunks that are larger than a volume v is "
               "exp(-(v/s)^(1/size_spread)), where s is a constant volume (Weibull 1951). 0: equal volumes. 1: the exponential "
               "distribution of Grady and Kipp (1985). 2: the distribution of Mott and Linfoot (1943)."},
          [](auto& r) -> auto& { return r.fracture.aggregation.spread; })));
  rows.push_back(for_patterns(
      patterns,
      with_member(
          {.name = "max_hulls",
           .type = Type::kInteger,
           .min = 1,
           .max = kMostCellsPerFragment,
           .doc =
               "Maximum number of convex hulls per ragged chunk. A hull extends beyond its fragment only at the outer surface, so "
               "the hulls of neighbouring fragments do not overlap."},
          [](auto& r) -> auto& { return r.fracture.most_hulls; })));
  rows.back().decides = Decides::kAnswer;
  for (std::size_t k = first + 1; k < rows.size(); ++k)
    rows[k].matters = [](const RequestParameters& r) { return r.fracture.aggregation.cells > 1; };
}

void add_pattern_rows(std::vector<ParameterSpec>& rows, std::uint32_t max_sites) {
  rows.push_back(with_pattern_member<&PointsPattern::points>(
      {.name = "points",
       .type = Type::kVectors,
       .unit = "m",
       .min = 1,
       .max = max_sites,
       .low = -kFar,
       .high = kFar,
       .doc =
           "Positions of the Voronoi sites, in the answer's coordinate frame (y up). The `points` pattern requires this parameter."}));
  rows.push_back(with_pattern_member<&ImpactPattern::impacts, &RadialPattern::impacts,
                                     &BrickPattern::impacts>(
      {.name = "impacts",
       .type = Type::kVectors,
       .unit = "m",
       .min = 1,
       .max = 64,
       .low = -kFar,
       .high = kFar,
       .doc =
           "Points where the mesh is hit, in the answer's coordinate frame. The whole mesh breaks, with the smallest pieces at "
           "these points; to break only the area around a hit, use `local_point`. `radial`: the first point is the centre of the "
           "rings and spokes. `brick`: bricks at a point are crushed, and the bricks around it break in half; without points, no "
           "bricks break. Default: the centre of the bounding box, or the centre of the box's +z side if spokes run in all "
           "directions. If the material's pattern is `uniform` or `clustered`, `impacts` changes it to `impact`."}));
  rows.push_back(with_pattern_member<&ImpactPattern::radius, &ClusteredPattern::radius>(
      {.name = "radius",
       .type = Type::kNumber,
       .unit = "m",
       .low = kLeastLength,
       .high = kFar,
       .doc =
           "Radius of the area around an impact in which the impact's sites are placed, or approximate radius of a cluster. "
           "Default: for an impact, a third of the longest side of the bounding box; for a cluster, 0.12 times the mean side length "
           "of the box."}));
  rows.push_back(with_pattern_member<&ImpactPattern::exponent, &ClusteredPattern::exponent>(
      {.name = "exponent",
       .type = Type::kNumber,
       .low = 0,
       .high = 2.9,
       .doc =
           "How fast the density of sites falls with the distance from an impact or cluster centre: the density is proportional to "
           "distance^-exponent. 0: uniform within `radius`. Default: 2 for `impact`, 1.5 for `clustered`."}));
  rows.push_back(with_pattern_member<&ImpactPattern::share, &ClusteredPattern::share>(
      {.name = "share",
       .type = Type::kNumber,
       .low = 0,
       .high = 1,
       .doc =
           "Fraction of the sites that are near an impact or in a cluster; the other sites are spread uniformly. Default: 0.8 for "
           "`impact`, 0.88 for `clustered`."}));
  rows.push_back(with_pattern_member<&ClusteredPattern::clusters>(
      {.name = "clusters",
       .type = Type::kInteger,
       .min = 1,
       .max = 10'000,
       .doc = "Number of clusters. Default: one per 40 sites."}));
  rows.push_back(with_pattern_member<&RadialPattern::around>(
      {.name = "around",
       .type = Type::kChoice,
       .choices = {"axis", "point", "shape"},
       .doc =
           "Centre of the rings and spokes. `axis`: a line (for a pane). `point`: a point from which spokes run in all directions "
           "(for a vessel or a lump). `shape`: like `axis` if the parameter `axis` is given or the mesh is a plate (at most a fifth "
           "as thick as it is wide), otherwise like `point`. If the mesh has several parts, each part breaks according to its own "
           "shape; rods (at least four times as long as they are wide) break across their length. If there are more than eight "
           "parts, this applies only to the seven largest. If `axis`, `spokes`, `rings`, a stretch, a kept region or "
           "`dual=barycenter` is given, all parts break as one."}));
  rows.push_back(with_pattern_member<&RadialPattern::axis>(
      {.name = "axis",
       .type = Type::kDirection,
       .low = -kFar,
       .high = kFar,
       .doc =
           "Axis of the rings and spokes. Default: perpendicular to a plate; in other meshes, along the shortest side of the "
           "bounding box or, if `crushed` is given, from the hit to the centre of the box."}));
  rows.push_back(with_pattern_member<&RadialPattern::spokes>(
      {.name = "spokes",
       .type = Type::kInteger,
       .min = 3,
       .max = 720,
       .doc =
           "Number of spokes. Default: enough for about `sites` pieces, but at least 14 (6 if they run in all directions)."}));
  rows.push_back(with_pattern_member<&RadialPattern::rings>(
      {.name = "rings",
       .type = Type::kInteger,
       .min = 1,
       .max = 1000,
       .doc = "Number of rings. Default: enough for about `sites` pieces."}));
  rows.push_back(with_pattern_member<&RadialPattern::growth>(
      {.name = "growth",
       .type = Type::kNumber,
       .low = 1,
       .high = 10,
       .doc = "Width of each ring, as a multiple of the width of the ring just inside it."}));
  rows.push_back(with_pattern_member<&RadialPattern::merge>(
      {.name = "merge",
       .type = Type::kNumber,
       .low = 0,
       .high = 0.9,
       .doc = "Fraction of the cracks along rings that is left out. Higher values make longer shards."}));
  rows.push_back(with_pattern_member<&RadialPattern::crushed>(
      {.name = "crushed",
       .type = Type::kNumber,
       .low = 0,
       .high = 0.9,
       .doc = "Fraction of the pieces that become crumbs around the hit."}));
  rows.push_back(with_pattern_member<&RadialPattern::jitter, &GridPattern::jitter, &BrickPattern::jitter,
                                     &SlicePattern::jitter>(
      {.name = "jitter",
       .type = Type::kNumber,
       .low = 0,
       .high = 1,
       .doc =
           "Irregularity of the pattern. With `grid`, `brick` and `slice`, each cutting plane is shifted by up to this fraction of "
           "half the distance between planes. Default: 0.5 for `radial`, 0.2 for `slice`, otherwise 0."}));
  ParameterSpec cell = with_pattern_member<&GridPattern::cell, &BrickPattern::cell>(
      {.name = "cell",
       .type = Type::kVector,
       .unit = "m",
       .low = kLeastLength,
       .high = kFar,
       .doc =
           "Size of a cell. `grid`: the lengths of a box along x, y and z. `brick`: the length, height and depth of a brick "
           "including its joint. Bricks lie along the longer horizontal side of the wall. If you give their size, each brick is one "
           "piece, and the whole mesh is treated as a wall. Default: chosen to make about `sites` pieces. With `brick`, each piece "
           "then contains several bricks of real size (0.24 x 0.071 x 0.115 m). The bricks are scaled if a piece would contain less "
           "than one brick or more than six."});
  rows.push_back(std::move(cell));
  rows.push_back(with_pattern_member<&BrickPattern::bond>(
      {.name = "bond",
       .type = Type::kChoice,
       .choices = {"stack", "half", "third"},
       .doc =
           "Offset of each row of bricks from the row below: none (`stack`), half a brick (`half`) or a third of a brick (`third`)."}));
  ParameterSpec mortar{
      .name = "mortar",
      .type = Type::kColor,
      .doc =
          "Colour of the joints in sRGB, as #rrggbb (for example #b9b4a8 for lime and cement). Cuts along joints get their own matt "
          "material, whose name ends with _Mortar; cuts through bricks and rubble stones keep the material of other cuts. Joints "
          "have no width. With `dual=barycenter`, there are no joints. Default: all cuts look the same.",
      .decides = Decides::kSites,
      .patterns = {pattern_name<BrickPattern>()}};
  mortar.set = [](RequestParameters& r, const ParameterSpec&, const ParameterValue& value) {
    auto* bricks = std::get_if<BrickPattern>(&r.fracture.pattern);
    if (!bricks) return;
    bricks->mortar = true;
    r.mortar = std::get<std::string>(value);
    r.interior.mortar = linear_color(r.mortar);
  };
  mortar.get = [](const RequestParameters& r, const ParameterSpec&) {
    return r.mortar.empty() ? nlohmann::json() : nlohmann::json(r.mortar);
  };
  rows.push_back(std::move(mortar));
  ParameterSpec normals = with_pattern_member<&SlicePattern::normals>(
      {.name = "normals",
       .type = Type::kVectors,
       .min = 1,
       .max = 3,
       .low = -kFar,
       .high = kFar,
       .doc =
           "One to three linearly independent directions. Each is the normal of one family of parallel cutting planes."});
  normals.check = [](const ParameterValue& value) -> std::optional<std::string> {
    const auto& given = std::get<std::vector<Vec3d>>(value);
    Matrix3 rows_of;
    for (std::size_t k = 0; k < given.size(); ++k) rows_of.rows[k] = given[k];
    if (given.size() == 1 && !(length(given[0]) > 1e-9)) return "be directions that are not zero";
    if (given.size() == 1) return std::nullopt;
    if (given.size() == 2) rows_of.rows[2] = cross(given[0], given[1]);
    if (rows_of.conditioning() >= kLeastConditioning) return std::nullopt;
    return "be linearly independent directions: these are, at least nearly, in one plane or on one line";
  };
  rows.push_back(std::move(normals));
  rows.push_back(with_pattern_member<&SlicePattern::spacing>(
      {.name = "spacing",
       .type = Type::kNumber,
       .unit = "m",
       .low = kLeastLength,
       .high = kFar,
       .doc =
           "Distance between neighbouring planes of a family. Default: chosen to make about `sites` pieces."}));
  rows.push_back(with_pattern_member<&SlicePattern::tilt>(
      {.name = "tilt",
       .type = Type::kNumber,
       .unit = "degrees",
       .low = 0,
       .high = 45,
       .doc =
           "Maximum angle by which each plane is tilted at random. This applies only if there is a single family of planes."}));
}

}  // namespace

SitePattern default_pattern(std::size_t index) {
  return pattern_at(index, std::make_index_sequence<std::variant_size_v<SitePattern>>{});
}

std::vector<ParameterSpec> site_parameter_rows(std::uint32_t max_sites) {
  std::vector<ParameterSpec> rows{material_row(), pattern_row()};
  add_general_rows(rows, max_sites);
  add_aggregate_rows(rows);
  add_pattern_rows(rows, max_sites);
  return rows;
}

std::vector<std::string> patterns_that(bool PatternTraits::*may) {
  std::vector<std::string> names;
  for (const PatternTraits& pattern : kPatternTraits)
    if (pattern.*may) names.emplace_back(pattern.name);
  return names;
}

}  // namespace fracture
