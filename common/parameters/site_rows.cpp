// Rows of material and pattern, and of the parameters of each pattern.
#include "common/parameters/fields.hpp"
#include "common/parameters/rows.hpp"

namespace fracture {
namespace {

using parameter_fields::kFar;
using parameter_fields::kLeastLength;
using parameter_fields::pattern_name;
using parameter_fields::with_member;
using parameter_fields::with_pattern_member;

// Rows of a matrix or normals of slices that are more nearly dependent than this have no usable inverse.
constexpr double kLeastConditioning = 1e-3;

ParameterSpec material_row() {
  ParameterSpec spec{
      .name = "material",
      .type = Type::kChoice,
      .doc =
          "Preset of `pattern` and most other parameters: how it breaks, its density, friction, bounce and strength, and how cuts "
          "look. Parameters that are given replace those of the preset. GET /patterns lists what each material sets."};
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
          "Arrangement of the Voronoi sites, which decides where the cuts go. GET /patterns describes each pattern.",
      .decides = Decides::kSites};
  for (const PatternTraits& pattern : kPatternTraits) spec.choices.emplace_back(pattern.name);
  spec.set = [](RequestParameters& r, const ParameterSpec&, const ParameterValue& value) {
    const auto index = static_cast<std::size_t>(std::get<std::uint64_t>(value));
    if (r.fracture.pattern.index() == index) return;  // keeps the values of a material
    r.fracture.pattern = default_pattern(index);
    // Relaxation moves single sites, and slices have directions of their own.
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
               "Number of cells that the pattern makes: the number of Voronoi sites with `uniform`, `impact` and `clustered`, "
               "approximate with the others. `cells_per_fragment` multiplies it. A cell that meets several parts of the mesh becomes a "
               "fragment in each; use `fragments` to set the number of fragments."},
          [](auto& r) -> auto& { return r.fracture.sites; })));
  rows.push_back(for_patterns(
      {},
      with_member(
          {.name = "seed",
           .type = Type::kInteger,
           .min = 0,
           .max = kMaxSeed,
           .doc =
               "Seed of all random numbers. The same seed gives the same bytes, another gives other cuts."},
          [](auto& r) -> auto& { return r.fracture.seed; })));
  rows.push_back(for_patterns(
      patterns_that(&PatternTraits::relaxed),
      with_member(
          {.name = "lloyd",
           .type = Type::kInteger,
           .min = 0,
           .max = 50,
           .doc =
               "Passes of relaxation. Each pass moves every site to the centre of its piece, so pieces become more even in size. A "
               "pass costs as much as cutting, mostly less than a tenth of the answer."},
          [](auto& r) -> auto& { return r.fracture.lloyd; })));
  rows.push_back(for_patterns(
      {"uniform", "impact", "clustered"},
      with_member(
          {.name = "density_from",
           .type = Type::kText,
           .doc =
               "Paint that marks where the mesh breaks most: vertex colours (COLOR_0 to COLOR_7) or a material (name or number). "
               "White, or the surface of the material, gets the most sites; black, or other surfaces, a 32nd as many. It affects "
               "evenly spread sites and the centres of clusters, not sites near an impact."},
          [](auto& r) -> auto& { return r.fracture.density_from; })));
  ParameterSpec stretch = for_patterns(
      {},
      with_member(
          {.name = "stretch",
           .type = Type::kNumber,
           .low = 0.01,
           .high = 100,
           .doc =
               "How many times as long pieces are along the grain as across it. Use it for fibres (wood has 8) or, below 1, for "
               "layers. Lengths of the pattern then count across the grain."},
          [](auto& r) -> auto& { return r.fracture.anisotropy.stretch; }));
  stretch.get = [get = stretch.get](const RequestParameters& r, const ParameterSpec& s) {
    return r.fracture.anisotropy.matrix ? nlohmann::json() : get(r, s);
  };
  rows.push_back(std::move(stretch));
  rows.push_back(for_patterns(
      {}, with_member(
              {.name = "grain",
               .type = Type::kDirection,
               .low = -kFar,
               .high = kFar,
               .doc = "Direction of the grain, the same for the whole mesh. Default: as `grain_of` says."},
              [](auto& r) -> auto& { return r.fracture.anisotropy.grain; })));
  ParameterSpec grain_of = for_patterns(
      {},
      with_member(
          {.name = "grain_of",
           .type = Type::kChoice,
           .choices = {"solid", "part", "node", "material"},
           .doc =
               "Bodies that have their own grain, along their longest axis, if `grain` is not given. All but `solid` need the pattern "
               "`uniform`, `impact` or `clustered`. `solid`: the whole mesh. `part`: each connected part. `node`: the parts of a node "
               "together. `material`: the parts with the same material on most of their surface together."},
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
               "Use it instead of `stretch` and `grain`: the matrix, row by row, that every piece goes through."},
          [](auto& r) -> auto& { return r.fracture.anisotropy.matrix; }));
  matrix.check = [](const ParameterValue& value) -> std::optional<std::string> {
    const auto& m = std::get<Matrix3>(value);
    if (m.conditioning() >= kLeastConditioning && std::fabs(m.determinant()) >= 1e-6) return std::nullopt;
    return "have a determinant of at least 1e-6, and of at least 0.001 of the product of its rows' lengths: this "
           "matrix is singular or nearly so";
  };
  matrix.set = [](RequestParameters& r, const ParameterSpec&, const ParameterValue& value) {
    r.fracture.anisotropy = {.matrix = std::get<Matrix3>(value)};  // replaces the stretch of a material
  };
  rows.push_back(std::move(matrix));
}

/// Fragments of several cells, for the patterns that support them.
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
               "Mean number of cells that grow together into a fragment. Use it for ragged chunks that are not convex; `size_spread` "
               "sets their sizes. After an impact they are longer in the outward direction. 1: each cell is a fragment. The materials "
               "stone, concrete and metal have 6, which costs twice as much as 1 with flat cuts."},
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
               "How uneven the volumes of ragged chunks are: a share of exp(-(v/s)^(1/size_spread)) is larger than v, with a scale s "
               "(Weibull 1951). 0: all alike. 1: the exponential of Grady and Kipp (1985), as published for blasted granitic gneiss "
               "(Astrom et al. 2004). 2: Mott and Linfoot (1943)."},
          [](auto& r) -> auto& { return r.fracture.aggregation.spread; })));
  rows.push_back(for_patterns(
      patterns,
      with_member(
          {.name = "max_hulls",
           .type = Type::kInteger,
           .min = 1,
           .max = kMostCellsPerFragment,
           .doc =
               "Most convex collision hulls of a ragged chunk. Hulls leave their fragment only at its outer surface, so those of "
               "neighbours do not overlap."},
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
       .doc = "The Voronoi sites, in the frame of the answer (y up). Required by this pattern."}));
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
           "Places where the mesh is hit, in the frame of the answer (y up). Use them to break the whole mesh, with the smallest "
           "pieces at the hit. Use `local_point` to break only what is near. `radial`: the first place is the centre. `brick`: "
           "bricks at the hit are crushed, the next ones break in halves; without a hit none do. Default: the centre of the box; "
           "for spokes in all directions the centre of its +z side. With a material of the pattern `uniform` or `clustered`, the "
           "pattern becomes `impact`."}));
  rows.push_back(with_pattern_member<&ImpactPattern::radius, &ClusteredPattern::radius>(
      {.name = "radius",
       .type = Type::kNumber,
       .unit = "m",
       .low = kLeastLength,
       .high = kFar,
       .doc =
           "Reach of an impact, or approximate reach of a cluster, within which its sites are. Default: a third of the box's "
           "longest side for an impact, 0.12 of its mean side for a cluster."}));
  rows.push_back(with_pattern_member<&ImpactPattern::exponent, &ClusteredPattern::exponent>(
      {.name = "exponent",
       .type = Type::kNumber,
       .low = 0,
       .high = 2.9,
       .doc =
           "How fast the density of sites falls with distance: as distance to the power of minus this. 0: even within the radius. "
           "Default: 2 for `impact`, 1.5 for `clustered`."}));
  rows.push_back(with_pattern_member<&ImpactPattern::share, &ClusteredPattern::share>(
      {.name = "share",
       .type = Type::kNumber,
       .low = 0,
       .high = 1,
       .doc =
           "Share of the sites that are near an impact or in a cluster; the others are uniform. Default: 0.8 for `impact`, 0.88 "
           "for `clustered`."}));
  rows.push_back(with_pattern_member<&ClusteredPattern::clusters>(
      {.name = "clusters",
       .type = Type::kInteger,
       .min = 1,
       .max = 10'000,
       .doc = "Number of clusters. Default: one for forty sites."}));
  rows.push_back(with_pattern_member<&RadialPattern::around>(
      {.name = "around",
       .type = Type::kChoice,
       .choices = {"axis", "point", "shape"},
       .doc =
           "Centre of rings and spokes. `axis`: a line, for a pane. `point`: a point with spokes in all directions, for a vessel "
           "or a lump. `shape`: an axis if `axis` is given or the mesh is a plate in any position (at most a fifth as thick as it "
           "is wide), else a point. Without `axis`, `spokes`, `rings` and a stretch, each of several parts breaks by its own "
           "shape, and parts four times as long as wide break across. If there are more than eight parts, only the seven largest "
           "do so. With `dual=barycenter` or a kept region, all parts break as one."}));
  rows.push_back(with_pattern_member<&RadialPattern::axis>(
      {.name = "axis",
       .type = Type::kDirection,
       .low = -kFar,
       .high = kFar,
       .doc =
           "Axis that rings and spokes go around. Default: through a plate, else along the shortest side of the box. With "
           "`crushed`, unless the mesh is a plate: from the hit to the centre of the box."}));
  rows.push_back(with_pattern_member<&RadialPattern::spokes>(
      {.name = "spokes",
       .type = Type::kInteger,
       .min = 3,
       .max = 720,
       .doc =
           "Number of spokes. Default: as many as `sites` needs, at least 14, in all directions at least 6."}));
  rows.push_back(with_pattern_member<&RadialPattern::rings>(
      {.name = "rings",
       .type = Type::kInteger,
       .min = 1,
       .max = 1000,
       .doc = "Number of rings. Default: as many as `sites` needs."}));
  rows.push_back(with_pattern_member<&RadialPattern::growth>(
      {.name = "growth",
       .type = Type::kNumber,
       .low = 1,
       .high = 10,
       .doc = "How many times as wide each ring is as the ring inside it."}));
  rows.push_back(with_pattern_member<&RadialPattern::merge>(
      {.name = "merge",
       .type = Type::kNumber,
       .low = 0,
       .high = 0.9,
       .doc = "Share of the ring cracks that are left out, which makes long shards."}));
  rows.push_back(with_pattern_member<&RadialPattern::crushed>(
      {.name = "crushed",
       .type = Type::kNumber,
       .low = 0,
       .high = 0.9,
       .doc = "Share of the pieces that are crumbs at the hit."}));
  rows.push_back(with_pattern_member<&RadialPattern::jitter, &GridPattern::jitter, &BrickPattern::jitter,
                                     &SlicePattern::jitter>(
      {.name = "jitter",
       .type = Type::kNumber,
       .low = 0,
       .high = 1,
       .doc =
           "Unevenness. With `grid`, `brick` and `slice` whole planes move by up to this share of half their spacing. Default: 0.5 "
           "for `radial`, 0.2 for `slice`, else 0."}));
  ParameterSpec cell = with_pattern_member<&GridPattern::cell, &BrickPattern::cell>(
      {.name = "cell",
       .type = Type::kVector,
       .unit = "m",
       .low = kLeastLength,
       .high = kFar,
       .doc =
           "Size of a cell. `grid`: sides of a box along x, y and z. `brick`: length, height and depth of a brick with its joint, "
           "with the length along the longer horizontal side of the wall. Each brick is then a piece, and everything counts as a "
           "wall. Default: as `sites` needs. Bricks then have their real size (0.24 x 0.071 x 0.115 m), several in a piece, and "
           "are scaled if a piece would have less than one or more than six."});
  rows.push_back(std::move(cell));
  rows.push_back(with_pattern_member<&BrickPattern::bond>(
      {.name = "bond",
       .type = Type::kChoice,
       .choices = {"stack", "half", "third"},
       .doc = "Shift of each course of bricks against the one below, in bricks."}));
  ParameterSpec mortar{
      .name = "mortar",
      .type = Type::kColor,
      .doc =
          "Colour of the joints, sRGB as #rrggbb (lime and cement: #b9b4a8). Cuts along joints get a matt material of their own, "
          "whose name ends with _Mortar; cuts through a brick or a stone of rubble show its inside. Joints have no width. With "
          "`dual=barycenter` there are none. Default: all cuts look alike.",
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
           "One to three linearly independent directions, each the normal of a family of parallel planes."});
  normals.check = [](const ParameterValue& value) -> std::optional<std::string> {
    const auto& given = std::get<std::vector<Vec3d>>(value);
    Matrix3 rows_of;
    for (std::size_t k = 0; k < given.size(); ++k) rows_of.rows[k] = given[k];
    if (given.size() == 1 && !(length(given[0]) > 1e-9)) return "be directions, none of them zero";
    if (given.size() == 1) return std::nullopt;
    if (given.size() == 2) rows_of.rows[2] = cross(given[0], given[1]);
    if (rows_of.conditioning() >= kLeastConditioning) return std::nullopt;
    return "be linearly independent directions: these lie in one plane or line, or nearly so";
  };
  rows.push_back(std::move(normals));
  rows.push_back(with_pattern_member<&SlicePattern::spacing>(
      {.name = "spacing",
       .type = Type::kNumber,
       .unit = "m",
       .low = kLeastLength,
       .high = kFar,
       .doc = "Distance between the planes of a family. Default: as `sites` needs."}));
  rows.push_back(with_pattern_member<&SlicePattern::tilt>(
      {.name = "tilt",
       .type = Type::kNumber,
       .unit = "degrees",
       .low = 0,
       .high = 45,
       .doc = "How far planes lean at random, if there is a single family."}));
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
