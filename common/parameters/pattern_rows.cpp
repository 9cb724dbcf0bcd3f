// Rows for the parameters of single patterns.
#include "common/parameters/fields.hpp"
#include "common/parameters/rows.hpp"

namespace fracture {

using parameter_fields::kFar;
using parameter_fields::kFarPlace;
using parameter_fields::kLeastConditioning;
using parameter_fields::kLeastLength;
using parameter_fields::pattern_name;
using parameter_fields::with_pattern_member;

std::vector<ParameterSpec> pattern_parameter_rows(std::uint32_t max_sites) {
  std::vector<ParameterSpec> rows;
  rows.push_back(with_pattern_member<&PointsPattern::points>(
      {.name = "points",
       .type = Type::kVectors,
       .unit = "m",
       .min = 1,
       .max = max_sites,
       .low = -kFarPlace,
       .high = kFarPlace,
       .doc =
           "Positions of the Voronoi sites, measured from the file's origin. `pattern=points` requires them."}));
  rows.push_back(with_pattern_member<&ImpactPattern::impacts, &RadialPattern::impacts,
                                     &BrickPattern::impacts>(
      {.name = "impacts",
       .type = Type::kVectors,
       .unit = "m",
       .min = 1,
       .max = 64,
       .low = -kFarPlace,
       .high = kFarPlace,
       .doc =
           "Points where the mesh is hit, measured from the file's origin. The whole mesh breaks, with the smallest "
           "pieces near these points. To break only the area around a hit, use `local_point`. `radial`: the first point "
           "is the centre of the rings. `brick`: bricks at a point are crushed. Points far outside the mesh are moved "
           "to its surface. Default: the centre of the bounding box; with `brick`, no points. If you give no `pattern`, "
           "`impact` replaces `uniform` or `clustered` set by default or by `material`."}));
  rows.push_back(with_pattern_member<&ImpactPattern::radius, &ClusteredPattern::radius>(
      {.name = "radius",
       .type = Type::kNumber,
       .unit = "m",
       .low = kLeastLength,
       .high = kFar,
       .doc =
           "Radius of the area that contains the sites of an impact, or approximate radius of a cluster. Default: a "
           "third of the longest side of the bounding box; for a cluster, 0.12 times the geometric mean of the box's "
           "sides."}));
  rows.push_back(with_pattern_member<&ImpactPattern::exponent, &ClusteredPattern::exponent>(
      {.name = "exponent",
       .type = Type::kNumber,
       .low = 0,
       .high = 2.9,
       .doc =
           "The density of sites around an impact or cluster centre is proportional to distance^-exponent. 0: uniform within "
           "`radius`. Default: 2 for `impact`, 1.5 for `clustered`."}));
  rows.push_back(with_pattern_member<&ImpactPattern::share, &ClusteredPattern::share>(
      {.name = "share",
       .type = Type::kNumber,
       .low = 0,
       .high = 1,
       .doc =
           "Fraction of the sites near an impact or in a cluster. The other sites are spread uniformly. Default: 0.8 for "
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
           "Centre of the rings and spokes. `axis`: a line (for a pane). `point`: a point from which spokes run in all "
           "directions (for a vessel or a lump). `shape`: plates break as with `axis`, rods break across their "
           "length, and other parts break as with `point`."}));
  rows.push_back(with_pattern_member<&RadialPattern::axis>(
      {.name = "axis",
       .type = Type::kDirection,
       .low = -kFar,
       .high = kFar,
       .doc =
           "Axis of the rings and spokes. Default: perpendicular to a plate. For other shapes: along the shortest side of "
           "the bounding box or, with `crushed`, from the hit to the box's centre."}));
  rows.push_back(with_pattern_member<&RadialPattern::spokes>(
      {.name = "spokes",
       .type = Type::kInteger,
       .min = 3,
       .max = 720,
       .doc =
           "Number of spokes. Default: enough for about `sites` pieces, but at least 14 (6 if spokes run in all "
           "directions)."}));
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
       .doc = "Width of each ring, as a multiple of the width of the ring inside it."}));
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
           "Irregularity of the pattern. With `grid`, `brick` and `slice`, planes are shifted by up to this fraction of half "
           "the distance between them. Default: 0.5 for `radial`, 0.2 for `slice`, otherwise 0."}));
  ParameterSpec cell = with_pattern_member<&GridPattern::cell, &BrickPattern::cell>(
      {.name = "cell",
       .type = Type::kVector,
       .unit = "m",
       .low = kLeastLength,
       .high = kFar,
       .doc =
           "Size of a box along x, y and z (`grid`), or length, height and depth of a brick with its joint (`brick`). "
           "Bricks lie along the longer horizontal side of the wall. If you give a size, each brick is one piece. "
           "Default: a size that makes about `sites` pieces; with `brick`, each of these has one to six bricks."});
  rows.push_back(std::move(cell));
  rows.push_back(with_pattern_member<&BrickPattern::bond>(
      {.name = "bond",
       .type = Type::kChoice,
       .choices = {"stack", "half", "third"},
       .doc = "Offset of each row of bricks: none (`stack`), half a brick (`half`) or a third (`third`)."}));
  ParameterSpec mortar{
      .name = "mortar",
      .type = Type::kColor,
      .doc =
          "Colour of the joints in sRGB (`#b9b4a8` for lime and cement). Cuts along joints have a matt material of this "
          "colour, named ..._Mortar. Default: all cuts look the same.",
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
           "Normals of one to three families of parallel cutting planes. They must be linearly independent."});
  normals.check = [](const ParameterValue& value) -> std::optional<std::string> {
    const auto& given = std::get<std::vector<Vec3d>>(value);
    Matrix3 rows_of;
    for (std::size_t k = 0; k < given.size(); ++k) rows_of.rows[k] = given[k];
    if (given.size() == 1 && !(length(given[0]) > 1e-9)) return "have a direction other than 0,0,0";
    if (given.size() == 1) return std::nullopt;
    if (given.size() == 2) rows_of.rows[2] = cross(given[0], given[1]);
    if (rows_of.conditioning() >= kLeastConditioning) return std::nullopt;
    return "be linearly independent directions: these lie (at least nearly) in one plane or on one line";
  };
  rows.push_back(std::move(normals));
  rows.push_back(with_pattern_member<&SlicePattern::spacing>(
      {.name = "spacing",
       .type = Type::kNumber,
       .unit = "m",
       .low = kLeastLength,
       .high = kFar,
       .doc =
           "Distance between neighbouring planes of a family. Default: enough for about `sites` pieces."}));
  rows.push_back(with_pattern_member<&SlicePattern::tilt>(
      {.name = "tilt",
       .type = Type::kNumber,
       .unit = "degrees",
       .low = 0,
       .high = 45,
       .doc = "Maximum random tilt of each plane. Planes are tilted only if there is a single family."}));
  return rows;
}

}  // namespace fracture
