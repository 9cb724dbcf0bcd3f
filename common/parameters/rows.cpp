#include "common/parameters/rows.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "common/parameters/assignments.hpp"
#include "common/parameters/fields.hpp"
#include "common/parameters/values.hpp"

namespace fracture {
namespace {

using parameter_fields::with_member;

void add_output_rows(std::vector<ParameterSpec>& rows) {
  rows.push_back(with_member(
      {.name = "dual",
       .type = Type::kChoice,
       .choices = {"circumcenter", "barycenter"},
       .doc =
           "How cells are made. `circumcenter`: Voronoi cells, which divide the mesh exactly. `barycenter`: convex hulls "
           "of the barycentres of Delaunay tetrahedra. Fragments look softer but overlap and leave gaps. Small ones are "
           "not merged."},
      [](auto& r) -> auto& { return r.fracture.dual; }));
  rows.push_back(with_member(
      {.name = "drop_above",
       .type = Type::kNumber,
       .unit = "m³",
       .low = 0,
       .high = 1e18,
       .doc = "Fragments larger than this are left out. Only with `dual=barycenter`. 0: no limit."},
      [](auto& r) -> auto& { return r.fracture.drop_above; }));
  rows.back().matters = [](const RequestParameters& r) { return r.fracture.drop_above > 0; };
  rows.push_back(with_member(
      {.name = "physics",
       .type = Type::kChoice,
       .choices = {"khr", "omi", "none"},
       .doc =
           "Format of the fragments' physics data. `khr`: KHR_physics_rigid_bodies, with collision filters for overlapping "
           "hulls. `omi`: OMI_physics_body and OMI_physics_shape, for Godot. This format has no filters; a warning gives the "
           "number of overlaps. `none`: no physics; hulls only with `ue_collision=ucx`."},
      [](auto& r) -> auto& { return r.physics; }));
  rows.push_back(with_member(
      {.name = "ue_collision",
       .type = Type::kChoice,
       .choices = {"none", "ucx"},
       .doc = "`ucx`: the collision hulls are also written as nodes named UCX_..., for Unreal."},
      [](auto& r) -> auto& { return r.ue_collision; }));
  for (ParameterSpec& spec : hull_parameter_rows()) rows.push_back(std::move(spec));
  rows.push_back(with_member(
      {.name = "pivot",
       .type = Type::kChoice,
       .choices = {"center_of_mass", "source"},
       .doc =
           "Origin of each fragment's node. `center_of_mass`: the fragment's centre of mass. `source`: the mesh's origin, so "
           "positions stay the same."},
      [](auto& r) -> auto& { return r.fracture.pivot; }));
  ParameterSpec intact = with_member(
      {.name = "intact",
       .type = Type::kChoice,
       .choices = {"false", "true"},
       .doc =
           "`true`: the file has a second scene named Intact, which contains the unbroken mesh with hulls. Answers with "
           "`delta` omit it."},
      [](auto& r) -> auto& { return r.fracture.intact; });
  intact.get = [](const RequestParameters& r, const ParameterSpec& s) -> nlohmann::json {
    return s.choices.at(r.fracture.intact ? 1 : 0);
  };
  intact.matters = [](const RequestParameters& r) { return r.fracture.intact; };
  rows.push_back(std::move(intact));
}

void add_exterior_row(std::vector<ParameterSpec>& rows) {
  ParameterSpec exterior = with_member(
      {.name = "exterior",
       .type = Type::kChoice,
       .choices = {"auto", "asset", "material"},
       .doc =
           "Appearance of the outer surface. `auto`: surfaces without a material get the colour, roughness, metalness "
           "and opacity of `material`. `asset`: all surfaces stay as they are. `material`: all fragments get the "
           "roughness, metalness and opacity of `material`, but keep their own colours and textures."},
      [](auto& r) -> auto& { return r.exterior.choice; });
  exterior.matters = [](const RequestParameters& r) { return r.exterior.any(); };
  rows.push_back(std::move(exterior));
}

void add_interior_rows(std::vector<ParameterSpec>& rows) {
  rows.push_back(with_member(
      {.name = "interior",
       .type = Type::kChoice,
       .choices = {"auto", "plain", "texture"},
       .doc =
           "Colour of the cut faces. `auto`: `interior_mix` blends in the colour that covers most of the part's surface. "
           "`plain`: all cuts have the same colour. `texture`: like `auto`, but textures of `interior_material` are shown even "
           "if they do not repeat on the mesh."},
      [](auto& r) -> auto& { return r.interior.choice; }));
  ParameterSpec reused = with_member(
      {.name = "interior_material",
       .type = Type::kText,
       .doc =
           "Name or index of a material in the mesh. The cut faces look like this material, including textures that "
           "repeat on the mesh. If a texture is an atlas or a palette, only its mean colour is used."},
      [](auto& r) -> auto& { return r.interior.material; });
  reused.set = [](RequestParameters& r, const ParameterSpec&, const ParameterValue& value) {
    r.interior = {.material = std::get<std::string>(value),
                  .choice = r.interior.choice,  // drops everything else that `material` has set
                  .mortar = r.interior.mortar};
    r.interior_color.clear();
  };
  rows.push_back(std::move(reused));
  rows.push_back(with_member(
      {.name = "interior_name",
       .type = Type::kText,
       .doc =
           "Name of the cut faces' material. Default: Interior, or Interior_ followed by the name of `interior_material`."},
      [](auto& r) -> auto& { return r.interior.name; }));
  ParameterSpec color = with_member(
      {.name = "interior_color",
       .type = Type::kColor,
       .doc = "Base colour of the cut faces in sRGB. It replaces the colour texture of `interior_material`."},
      [](auto& r) -> auto& { return r.interior_color; });
  color.set = [](RequestParameters& r, const ParameterSpec&, const ParameterValue& value) {
    r.interior_color = std::get<std::string>(value);
    r.interior.color = linear_color(r.interior_color);
    r.interior.mix.reset();
  };
  rows.push_back(std::move(color));
  rows.push_back(with_member(
      {.name = "interior_mix",
       .type = Type::kNumber,
       .low = 0,
       .high = 1,
       .doc =
           "How much of the surface's colour is blended into the colour of the cut faces. Above 0, the blended colour "
           "replaces the texture of cut faces. Default: 0 with `interior_color` or `interior_material`; otherwise the "
           "value that `material` sets, or 1 without `material`."},
      [](auto& r) -> auto& { return r.interior.mix; }));
  rows.push_back(with_member(
      {.name = "interior_shade",
       .type = Type::kNumber,
       .low = 0,
       .high = 10,
       .doc =
           "Factor for the brightness of the surface's colour that `interior_mix` blends into the cut faces."},
      [](auto& r) -> auto& { return r.interior.shade; }));
  rows.push_back(with_member(
      {.name = "interior_opacity",
       .type = Type::kNumber,
       .low = 0,
       .high = 1,
       .doc =
           "Opacity of the cut faces. Default: set by the materials glass, crystal and ice; otherwise 0.5 in parts with a "
           "translucent surface and 1 in others."},
      [](auto& r) -> auto& { return r.interior.opacity; }));
  ParameterSpec crushed = with_member(
      {.name = "interior_crushed",
       .type = Type::kNumber,
       .low = 0,
       .high = 1,
       .doc =
           "Fragments smaller than this fraction of the mean volume get white, opaque cut faces, like crushed ice. The "
           "mean is the mesh's volume divided by `fragments` or `sites`."},
      [](auto& r) -> auto& { return r.interior.crushed; });
  crushed.matters = [](const RequestParameters& r) { return r.interior.crushed > 0; };
  rows.push_back(std::move(crushed));
  rows.push_back(with_member(
      {.name = "interior_roughness",
       .type = Type::kNumber,
       .low = 0,
       .high = 1,
       .doc = "Roughness of the cut faces."},
      [](auto& r) -> auto& { return r.interior.roughness; }));
  rows.push_back(with_member(
      {.name = "interior_metallic",
       .type = Type::kNumber,
       .low = 0,
       .high = 1,
       .doc = "Metalness of the cut faces."},
      [](auto& r) -> auto& { return r.interior.metallic; }));
  ParameterSpec detail = with_member(
      {.name = "interior_detail",
       .type = Type::kChoice,
       .doc =
           "Normal and roughness maps of the cut faces. They repeat once per metre unless `interior_uv_scale` is given. "
           "Answers with `delta=only` do not contain them."},
      [](auto& r) -> auto& { return r.interior.detail; });
  for (const std::string_view name : kCutDetailNames) detail.choices.emplace_back(name);
  detail.matters = [](const RequestParameters& r) { return r.interior.detail != CutDetail::kNone; };
  rows.push_back(std::move(detail));
  rows.push_back(with_member(
      {.name = "interior_uv_scale",
       .type = Type::kNumber,
       .low = 1e-3,
       .high = 1e3,
       .doc = "Texture repetitions per metre of cut face."},
      [](auto& r) -> auto& { return r.interior.uvs.scale; }));
  rows.push_back(with_member(
      {.name = "interior_uv_u",
       .type = Type::kNumber,
       .low = -1e3,
       .high = 1e3,
       .doc = "Offset of the first texture coordinate."},
      [](auto& r) -> auto& { return r.interior.uvs.u; }));
  rows.push_back(with_member(
      {.name = "interior_uv_v",
       .type = Type::kNumber,
       .low = -1e3,
       .high = 1e3,
       .doc = "Offset of the second texture coordinate."},
      [](auto& r) -> auto& { return r.interior.uvs.v; }));
  for (std::size_t k = rows.size() - 3; k < rows.size(); ++k)
    rows[k].matters = [](const RequestParameters& r) { return r.interior.uvs != CutUvs{}; };
}

ParameterSpec format_row(const FormatSet& formats) {
  ParameterSpec spec{.name = "format",
                     .type = Type::kChoice,
                     .choices = formats.names(),
                     .doc = "Format of the mesh. It overrides the Content-Type."};
  spec.set = [](RequestParameters& r, const ParameterSpec& s, const ParameterValue& value) {
    r.format = format_from_extension(s.choices.at(std::get<std::uint64_t>(value)));
  };
  spec.get = [](const RequestParameters&, const ParameterSpec&) { return nlohmann::json(); };
  return spec;
}

}  // namespace

Error bad_parameter(std::string name, std::string detail) {
  return {ErrorCode::kBadParameter, std::move(detail), std::move(name)};
}

bool belongs(const ParameterSpec& spec, const SitePattern& pattern) {
  return spec.patterns.empty() || std::find(spec.patterns.begin(), spec.patterns.end(),
                                            kPatternTraits[pattern.index()].name) != spec.patterns.end();
}

std::vector<ParameterSpec> parameter_rows(std::uint32_t max_sites, const FormatSet& formats) {
  std::vector<ParameterSpec> rows = site_parameter_rows(max_sites);
  for (ParameterSpec& row : structure_parameter_rows(max_sites)) rows.push_back(std::move(row));
  for (ParameterSpec& row : rough_parameter_rows()) rows.push_back(std::move(row));
  std::vector<ParameterSpec> solid = solid_parameter_rows();
  std::move(solid.begin(), solid.end(), std::back_inserter(rows));
  add_output_rows(rows);
  add_exterior_row(rows);
  add_interior_rows(rows);
  for (ParameterSpec& row : physical_parameter_rows()) rows.push_back(std::move(row));
  rows.push_back(assign_row());
  rows.push_back(format_row(formats));
  for (ParameterSpec& row : rows) {
    std::vector<nlohmann::json> defaults;  // one for each pattern
    RequestParameters request;
    for (std::size_t k = 0; k < std::size(kPatternTraits); ++k) {
      request.fracture.pattern = default_pattern(k);
      if (belongs(row, request.fracture.pattern)) defaults.push_back(row.get(request, row));
    }
    const bool one =
        std::all_of(defaults.begin(), defaults.end(), [&](const auto& d) { return d == defaults[0]; });
    if (row.name == "pattern")
      row.default_value = kPatternTraits[RequestParameters().fracture.pattern.index()].name;
    else if (one)
      row.default_value = defaults[0];
  }
  return rows;
}

}  // namespace fracture
