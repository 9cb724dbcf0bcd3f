// Which material, which pattern, and the parameters of each.
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
          "How it breaks, what it weighs, how it rubs, bounces, holds and looks inside: a preset of "
          "`pattern` and of most other parameters, each of which may still be given. See GET /patterns."};
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
                     .doc = "Where the Voronoi sites go; see GET /patterns.",
                     .decides = Decides::kSites};
  for (const PatternTraits& pattern : kPatternTraits) spec.choices.emplace_back(pattern.name);
  spec.set = [](RequestParameters& r, const ParameterSpec&, const ParameterValue& value) {
    const auto index = static_cast<std::size_t>(std::get<std::uint64_t>(value));
    if (r.fracture.pattern.index() == index) return;  // keeps what a material has set
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
               "How many cells the pattern makes: Voronoi sites for uniform, impact and clustered, about so "
               "many for the others; times `cells_per_fragment`, where these grow together. Each part of a mesh that a "
               "cell meets gets a fragment of it, so that there may be more of those: see `fragments`."},
          [](auto& r) -> auto& { return r.fracture.sites; })));
  rows.push_back(
      for_patterns({}, with_member(
                           {.name = "seed",
                            .type = Type::kInteger,
                            .min = 0,
                            .max = kMaxSeed,
                            .doc = "Seed of everything random: the same seed gives the same bytes."},
                           [](auto& r) -> auto& { return r.fracture.seed; })));
  rows.push_back(for_patterns(
      patterns_that(&PatternTraits::relaxed),
      with_member(
          {.name = "lloyd",
           .type = Type::kInteger,
           .min = 0,
           .max = 50,
           .doc = "Passes of relaxation: each moves every site to the middle of its piece, for pieces of "
                  "more even size. A pass costs what cutting costs: mostly less than a tenth of the answer."},
          [](auto& r) -> auto& { return r.fracture.lloyd; })));
  rows.push_back(for_patterns(
      {"uniform", "impact", "clustered"},
      with_member(
          {.name = "density_from",
           .type = Type::kText,
           .doc =
               "Where it is painted to break: COLOR_0 (to COLOR_7), vertex colours whose white gets most sites and whose "
               "black a 32nd of them, or a material by its name or number, whose surface gets most. Of sites that are "
               "even without, and of the middles of clusters; those near an impact stay."},
          [](auto& r) -> auto& { return r.fracture.density_from; })));
  ParameterSpec stretch = for_patterns(
      {},
      with_member(
          {.name = "stretch",
           .type = Type::kNumber,
           .low = 0.01,
           .high = 100,
           .doc = "How many times as long pieces are along the grain as across it. Lengths of the pattern "
                  "are then those across the grain."},
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
               .doc = "Direction of the stretch, the same for all. Without it: as `grain_of` says."},
              [](auto& r) -> auto& { return r.fracture.anisotropy.grain; })));
  ParameterSpec grain_of = for_patterns(
      {},
      with_member(
          {.name = "grain_of",
           .type = Type::kChoice,
           .choices = {"solid", "part", "node", "material"},
           .doc =
               "What has a grain of its own, along its longest axis, where `grain` does not say it: the solid, "
               "each connected part, or together the parts of each node, or those with the same material on "
               "most of their surface. All but `solid` with patterns of scattered sites: uniform, impact, "
               "clustered."},
          [](auto& r) -> auto& { return r.fracture.anisotropy.grain_of; }));
  grain_of.matters = [](const RequestParameters& r) {
    const Anisotropy& a = r.fracture.anisotropy;
    return a.stretch != 1 && !a.grain && !a.matrix && is_scattered(r.fracture.pattern);
  };
  grain_of.set = [set = grain_of.set](RequestParameters& r, const ParameterSpec& s,
                                      const ParameterValue& value) {
    r.fracture.anisotropy.grain.reset();  // in the place of a material's
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
           .doc = "Instead of `stretch` and `grain`: the matrix that every piece goes through, row by row."},
          [](auto& r) -> auto& { return r.fracture.anisotropy.matrix; }));
  matrix.check = [](const ParameterValue& value) -> std::optional<std::string> {
    const auto& m = std::get<Matrix3>(value);
    if (m.conditioning() >= kLeastConditioning && std::fabs(m.determinant()) >= 1e-6) return std::nullopt;
    return "have a determinant of at least 1e-6, and of at least 0.001 of the product of its rows' lengths: this "
           "matrix is singular or nearly so";
  };
  matrix.set = [](RequestParameters& r, const ParameterSpec&, const ParameterValue& value) {
    r.fracture.anisotropy = {.matrix = std::get<Matrix3>(value)};  // in the place of a material's stretch
  };
  rows.push_back(std::move(matrix));
}

/// Fragments of several cells, with the patterns that know them.
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
               "How many cells grow together into a fragment, on average: ragged chunks that are not convex, of the "
               "sizes that `size_spread` says; after an impact longer on the way outwards. The pattern makes so many "
               "times `sites` cells: with flat cuts 6 cost twice as much as 1, which makes each cell a fragment. stone "
               "and concrete have 6."},
          [](auto& r) -> auto& { return r.fracture.aggregation.cells; })));
  rows.back().matters = [](const RequestParameters& r) {  // 1 beside a material that has more says something
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
               "With `cells_per_fragment`: how uneven the volumes are. Of all fragments exp(-(v/s)^(1/size_spread)) are "
               "larger than v (Weibull 1951). 0: all alike. 1: the exponential of Grady and Kipp (1985), as published "
               "for blasted granitic gneiss (Astrom et al. 2004). 2: Mott and Linfoot (1943)."},
          [](auto& r) -> auto& { return r.fracture.aggregation.spread; })));
  rows.push_back(for_patterns(
      patterns,
      with_member(
          {.name = "max_hulls",
           .type = Type::kInteger,
           .min = 1,
           .max = kMostCellsPerFragment,
           .doc =
               "With `cells_per_fragment`: most convex collision hulls of a fragment. They lie within it but for its "
               "outer surface, so that those of neighbours do not overlap."},
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
       .doc = "The Voronoi sites themselves, in the frame of the answer (y up). Required by this pattern."}));
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
           "Where it was hit, in the frame of the answer (y up). radial: the first is the centre. brick: what is near is "
           "crushed, around it bricks break in halves; without it none do. Without it: the middle of the box; of spokes "
           "in all directions the middle of its side towards +z. With a material whose pattern knows of no hits the pattern "
           "is `impact`."}));
  rows.push_back(with_pattern_member<&ImpactPattern::radius, &ClusteredPattern::radius>(
      {.name = "radius",
       .type = Type::kNumber,
       .unit = "m",
       .low = kLeastLength,
       .high = kFar,
       .doc = "How far from an impact, or about how far from the middle of a cluster, its sites lie. Without "
              "it: a third of the box's longest side for an impact, 0.12 of the mean side for a cluster."}));
  rows.push_back(with_pattern_member<&ImpactPattern::exponent, &ClusteredPattern::exponent>(
      {.name = "exponent",
       .type = Type::kNumber,
       .low = 0,
       .high = 2.9,
       .doc =
           "The density of sites falls as distance to the power of minus this: 0 is even within the radius. "
           "Without it: 2 for impact, 1.5 for clustered."}));
  rows.push_back(with_pattern_member<&ImpactPattern::share, &ClusteredPattern::share>(
      {.name = "share",
       .type = Type::kNumber,
       .low = 0,
       .high = 1,
       .doc =
           "Share of the sites that go near an impact or into a cluster; the others are uniform. Without it: "
           "0.8 for impact, 0.88 for clustered."}));
  rows.push_back(with_pattern_member<&ClusteredPattern::clusters>(
      {.name = "clusters",
       .type = Type::kInteger,
       .min = 1,
       .max = 10'000,
       .doc = "How many clusters. Without it: one for forty sites."}));
  rows.push_back(with_pattern_member<&RadialPattern::around>(
      {.name = "around",
       .type = Type::kChoice,
       .choices = {"axis", "point", "shape"},
       .doc =
           "What rings and spokes go around. axis: of a pane. point: spokes in all directions, through a vessel or a "
           "lump. shape: an axis where one is given or the solid is a plate (however it stands, at most a fifth as thick "
           "as it is wide), else a point; of several parts, where neither axis nor spokes nor rings nor a stretch are given, each "
           "for itself (of more than eight the seven largest), and what is four times as long as it is wide across; with "
           "dual=barycenter or a region that is kept all as one."}));
  rows.push_back(with_pattern_member<&RadialPattern::axis>(
      {.name = "axis",
       .type = Type::kDirection,
       .low = -kFar,
       .high = kFar,
       .doc =
           "The axis that rings and spokes go around. Without it: through a plate, else along the shortest side of the box; "
           "with `crushed`, of what is no plate, from where it was hit to its middle."}));
  rows.push_back(
      with_pattern_member<&RadialPattern::spokes>({.name = "spokes",
                                                   .type = Type::kInteger,
                                                   .min = 3,
                                                   .max = 720,
                                                   .doc = "Without it: as `sites` needs, at least 14; in all "
                                                          "directions at least 6."}));
  rows.push_back(with_pattern_member<&RadialPattern::rings>({.name = "rings",
                                                             .type = Type::kInteger,
                                                             .min = 1,
                                                             .max = 1000,
                                                             .doc = "Without it: as `sites` needs."}));
  rows.push_back(with_pattern_member<&RadialPattern::growth>(
      {.name = "growth",
       .type = Type::kNumber,
       .low = 1,
       .high = 10,
       .doc = "Each ring is so many times as wide as the one inside it."}));
  rows.push_back(with_pattern_member<&RadialPattern::merge>(
      {.name = "merge",
       .type = Type::kNumber,
       .low = 0,
       .high = 0.9,
       .doc = "Share of the ring cracks that stay away, which makes long shards."}));
  rows.push_back(with_pattern_member<&RadialPattern::crushed>(
      {.name = "crushed",
       .type = Type::kNumber,
       .low = 0,
       .high = 0.9,
       .doc = "Share of the pieces that are crumbs where it was hit. Without it: none, with ice 0.4."}));
  rows.push_back(with_pattern_member<&RadialPattern::jitter, &GridPattern::jitter, &BrickPattern::jitter,
                                     &SlicePattern::jitter>(
      {.name = "jitter",
       .type = Type::kNumber,
       .low = 0,
       .high = 1,
       .doc = "How uneven it is. grid, brick, slice: whole planes move by up to this share of half their "
              "spacing. Without it: 0.5 for radial, 0.2 for slice, else 0."}));
  ParameterSpec cell = with_pattern_member<&GridPattern::cell, &BrickPattern::cell>(
      {.name = "cell",
       .type = Type::kVector,
       .unit = "m",
       .low = kLeastLength,
       .high = kFar,
       .doc =
           "grid: the sides of a box along x, y and z. brick: length, height and depth of a brick with its joint, the length "
           "along the longer horizontal side of the wall; each brick is a piece, and everything is a wall. Without it: as "
           "`sites` needs; bricks of their real size (0.24 x 0.071 x 0.115), of which pieces are lumps, in proportion where "
           "a piece would be less than one or more than six."});
  rows.push_back(std::move(cell));
  rows.push_back(with_pattern_member<&BrickPattern::bond>(
      {.name = "bond",
       .type = Type::kChoice,
       .choices = {"stack", "half", "third"},
       .doc = "By how much of a brick each course is shifted against the one below."}));
  ParameterSpec mortar{
      .name = "mortar",
      .type = Type::kColor,
      .doc =
          "Colour of the joints, sRGB as #rrggbb (lime and cement: #b9b4a8): cuts between bricks, or stones of rubble, that "
          "parted where they were laid have a matt material of their own, whose name ends with _Mortar; what broke shows "
          "its inside. Joints have no width, and there are none with dual=barycenter. Without it: all cuts look alike.",
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
       .doc = "One to three directions, each of a family of parallel planes."});
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
  rows.push_back(
      with_pattern_member<&SlicePattern::spacing>({.name = "spacing",
                                                   .type = Type::kNumber,
                                                   .unit = "m",
                                                   .low = kLeastLength,
                                                   .high = kFar,
                                                   .doc = "Between planes of a family. Without it: as "
                                                          "`sites` needs."}));
  rows.push_back(with_pattern_member<&SlicePattern::tilt>(
      {.name = "tilt",
       .type = Type::kNumber,
       .unit = "degrees",
       .low = 0,
       .high = 45,
       .doc = "By how much planes of a single family lean at random."}));
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
