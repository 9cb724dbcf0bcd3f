#include "server/service/parameters.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include "server/service/parameter_values.hpp"

namespace fracture {
namespace {

std::string expectation(const ParameterSpec& spec) {
  switch (spec.type) {
    case ParameterSpec::Type::kInteger:
      return "must be a whole number from " + std::to_string(spec.min) + " to " + std::to_string(spec.max);
    case ParameterSpec::Type::kNumber:
      return "must be a number from " + shortest(spec.low) + " to " + shortest(spec.high);
    case ParameterSpec::Type::kNames:
      return "must be names or indices separated by commas, in UTF-8, none of them empty";
    case ParameterSpec::Type::kText:
      return "must be 1 to 63 bytes of text";
    case ParameterSpec::Type::kColor:
      return "must be an sRGB colour as #rrggbb";
    case ParameterSpec::Type::kChoice:
      break;
  }
  return "must be " + join(spec.choices);
}

void set_integer(RequestParameters& result, std::string_view name, std::uint64_t value) {
  if (name == "sites") result.fracture.sites = static_cast<std::uint32_t>(value);
  if (name == "seed") result.fracture.seed = value;
}

void set_number(RequestParameters& result, std::string_view name, double value) {
  if (name == "thickness") result.solid.thickness = value;
  if (name == "weld_tolerance") result.solid.weld_tolerance = value;
  if (name == "density") result.density = value;
  if (name == "mass") result.mass = value;
  if (name == "interior_roughness") result.interior.roughness = value;
  if (name == "interior_metallic") result.interior.metallic = value;
}

void set_text(RequestParameters& result, std::string_view name, std::string value) {
  if (name == "interior_name") result.interior.name = std::move(value);
  if (name == "interior_material") result.interior.material = std::move(value);
}

void set_names(RequestParameters& result, std::string_view name, std::vector<std::string> value) {
  (name == "nodes" ? result.parts.nodes : result.parts.materials) = std::move(value);
}

// The spellings of each choice, in the order of the table.
constexpr const char* kDuals[] = {"circumcenter", "barycenter"};
constexpr const char* kRepairs[] = {"fill", "strict"};
constexpr const char* kUnits[] = {"file", "m", "cm", "mm", "inch"};
constexpr const char* kAxes[] = {"file", "y", "z"};
constexpr const char* kPhysics[] = {"khr", "omi", "none"};
constexpr const char* kUeCollisions[] = {"none", "ucx"};
constexpr const char* kPivots[] = {"center_of_mass", "source"};

/// The enumerators stand in the order of their spellings.
template <std::size_t n>
std::vector<std::string> spellings(const char* const (&names)[n]) {
  return {names, names + n};
}
template <class Enum, std::size_t n>
const char* spelling(Enum value, const char* const (&names)[n]) {
  return names[static_cast<std::size_t>(value)];
}

void set_choice(RequestParameters& result, const ParameterSpec& spec, const std::string& choice) {
  const auto index = std::find(spec.choices.begin(), spec.choices.end(), choice) - spec.choices.begin();
  if (spec.name == "dual") result.fracture.dual = static_cast<Dual>(index);
  if (spec.name == "repair") result.solid.repair = static_cast<Repair>(index);
  if (spec.name == "unit") result.frame.unit = static_cast<LengthUnit>(index);
  if (spec.name == "up") result.frame.up = static_cast<UpAxis>(index);
  if (spec.name == "physics") result.physics = static_cast<Physics>(index);
  if (spec.name == "ue_collision") result.ue_collision = static_cast<UeCollision>(index);
  if (spec.name == "pivot") result.fracture.pivot = static_cast<Pivot>(index);
  if (spec.name == "format") result.format = format_from_extension(choice);
}

}  // namespace

FormatSet::FormatSet() {
  for (const FormatInfo& info : all_formats())
    if (info.enabled_by_default) formats_.push_back(info.format);
}

FormatSet FormatSet::all() {
  FormatSet set;
  for (const FormatInfo& info : all_formats()) set.enable(info.format);
  return set;
}

void FormatSet::enable(MeshFormat format) {
  if (contains(format)) return;
  formats_.push_back(format);
  std::sort(formats_.begin(), formats_.end());
}

bool FormatSet::contains(MeshFormat format) const {
  return std::find(formats_.begin(), formats_.end(), format) != formats_.end();
}

std::vector<std::string> FormatSet::names() const {
  std::vector<std::string> names;
  for (const MeshFormat format : formats_) names.emplace_back(extension_of(format));
  return names;
}

ParameterTable::ParameterTable(std::uint32_t max_sites, FormatSet formats) : formats_(std::move(formats)) {
  using Type = ParameterSpec::Type;
  const RequestParameters request;
  const FractureParameters& defaults = request.fracture;
  specs_ = {
      {.name = "sites",
       .type = Type::kInteger,
       .min = 1,
       .max = max_sites,
       .default_value = defaults.sites,
       .doc = "How many random Voronoi sites are placed uniformly inside the solid."},
      {.name = "seed",
       .type = Type::kInteger,
       .min = 0,
       .max = kMaxSeed,
       .default_value = defaults.seed,
       .doc = "Seed of the random sites: the same seed gives the same bytes."},
      {.name = "dual",
       .type = Type::kChoice,
       .choices = spellings(kDuals),
       .default_value = kDuals[0],
       .doc = "circumcenter: Voronoi cells, an exact partition. barycenter: hulls of the tetrahedra's "
              "barycentres, a softer look that is no partition."},
      {.name = "repair",
       .type = Type::kChoice,
       .choices = spellings(kRepairs),
       .default_value = kRepairs[0],
       .doc = "fill: holes are closed and what is turned is turned back. strict: a mesh that is not closed "
              "and consistently oriented is refused."},
      {.name = "thickness",
       .type = Type::kNumber,
       .low = 0,
       .high = 1000,
       .default_value = request.solid.thickness,
       .doc = "Metres; makes open sheets (panes, leaves) slabs of this thickness. 0: they are dropped."},
      {.name = "weld_tolerance",
       .type = Type::kNumber,
       .low = 0,
       .high = 0.01,
       .default_value = request.solid.weld_tolerance,
       .doc = "Vertices closer than this fraction of the box's diagonal are merged where that closes open "
              "edges. 0: only equal ones."},
      {.name = "unit",
       .type = Type::kChoice,
       .choices = spellings(kUnits),
       .default_value = kUnits[0],
       .doc = "Unit of the mesh's coordinates. file: as the file or its format says, else metres."},
      {.name = "up",
       .type = Type::kChoice,
       .choices = spellings(kAxes),
       .default_value = kAxes[0],
       .doc = "Axis of the mesh that points up; the answer is y up. file: as the file or its format says, "
              "else y."},
      {.name = "nodes",
       .type = Type::kNames,
       .doc = "Fracture only these nodes (names or indices, separated by commas); the others pass through "
              "whole."},
      {.name = "materials",
       .type = Type::kNames,
       .doc = "Fracture only triangles with these materials (names or indices, separated by commas); the "
              "others pass through whole."},
      {.name = "physics",
       .type = Type::kChoice,
       .choices = spellings(kPhysics),
       .default_value = kPhysics[0],
       .doc = "khr: KHR_physics_rigid_bodies. omi: OMI_physics_body and OMI_physics_shape, for Godot. none: "
              "neither, and no collision hulls."},
      {.name = "ue_collision",
       .type = Type::kChoice,
       .choices = spellings(kUeCollisions),
       .default_value = kUeCollisions[0],
       .doc = "ucx: the collision hulls also as nodes UCX_..., which Unreal takes for collision geometry."},
      {.name = "pivot",
       .type = Type::kChoice,
       .choices = spellings(kPivots),
       .default_value = kPivots[0],
       .doc = "Origin of each fragment's node: its centre of mass, or that of the source."},
      {.name = "interior_material",
       .type = Type::kText,
       .doc = "Name or index of a material of the mesh whose look, textures included, the cut faces get. "
              "Without it they are a matt grey."},
      {.name = "interior_name",
       .type = Type::kText,
       .doc = "Name of the cut faces' material. Without it: Interior, or Interior_ and the name of "
              "interior_material."},
      {.name = "interior_color",
       .type = Type::kColor,
       .doc = "Base colour of the cut faces, sRGB as #rrggbb; replaces the reused base colour texture."},
      {.name = "interior_roughness",
       .type = Type::kNumber,
       .low = 0,
       .high = 1,
       .doc = "Roughness of the cut faces."},
      {.name = "interior_metallic",
       .type = Type::kNumber,
       .low = 0,
       .high = 1,
       .doc = "How metallic the cut faces are."},
      {.name = "density",
       .type = Type::kNumber,
       .low = 1e-3,
       .high = 1e6,
       .default_value = request.density,
       .doc = "Kilograms in a cubic metre."},
      {.name = "mass",
       .type = Type::kNumber,
       .low = 1e-9,
       .high = 1e15,
       .doc = "Kilograms of all fragments together, instead of a density."},
      {.name = "format",
       .type = Type::kChoice,
       .choices = formats_.names(),
       .doc = "Format of the mesh, where the Content-Type does not say it."},
  };
}

const ParameterSpec* ParameterTable::find(std::string_view name) const {
  for (const ParameterSpec& spec : specs_)
    if (spec.name == name) return &spec;
  return nullptr;
}

Expected<RequestParameters> ParameterTable::parse(const std::vector<RawParameter>& given) const {
  RequestParameters result;
  std::optional<Error> first;
  nlohmann::json offenders = nlohmann::json::array();
  const auto offend = [&](ErrorCode code, const RawParameter& raw, std::string detail) {
    const std::string name = shown(raw.name);
    nlohmann::json entry = {{"detail", detail}};
    entry[raw.is_text ? "parameter" : "pointer"] = raw.is_text ? name : "/" + name;
    offenders.push_back(std::move(entry));
    if (!first) first = Error{code, std::move(detail), name};
  };

  std::set<std::string> seen;
  for (const RawParameter& raw : given) {
    const ParameterSpec* spec = find(raw.name);
    if (!spec) {
      std::vector<std::string> known;
      for (const ParameterSpec& s : specs_) known.push_back(s.name);
      offend(ErrorCode::kUnknownParameter, raw,
             "There is no parameter '" + shown(raw.name) + "'. The parameters are " + join(known) + ".");
      continue;
    }
    if (!seen.insert(raw.name).second) {
      offend(ErrorCode::kBadParameter, raw, "'" + raw.name + "' was given more than once.");
      continue;
    }
    const std::string complaint =
        "'" + raw.name + "' " + expectation(*spec) + "; it was '" + shown(raw.value) + "'.";
    if (spec->type == ParameterSpec::Type::kInteger) {
      const std::optional<std::uint64_t> number = to_integer(raw);
      if (number && *number >= spec->min && *number <= spec->max)
        set_integer(result, raw.name, *number);
      else
        offend(ErrorCode::kBadParameter, raw, complaint);
    } else if (spec->type == ParameterSpec::Type::kNumber) {
      const std::optional<double> number = to_number(raw);
      if (number && *number >= spec->low && *number <= spec->high)
        set_number(result, raw.name, *number);
      else
        offend(ErrorCode::kBadParameter, raw, complaint);
    } else if (spec->type == ParameterSpec::Type::kNames) {
      if (std::optional<std::vector<std::string>> names = to_names(raw))
        set_names(result, raw.name, std::move(*names));
      else
        offend(ErrorCode::kBadParameter, raw, complaint);
    } else if (spec->type == ParameterSpec::Type::kText) {
      if (std::optional<std::string> text = to_text(raw))
        set_text(result, raw.name, std::move(*text));
      else
        offend(ErrorCode::kBadParameter, raw, complaint);
    } else if (spec->type == ParameterSpec::Type::kColor) {
      const std::string text = raw.value.is_string() ? raw.value.get<std::string>() : std::string();
      if ((result.interior.color = linear_color(text)))
        result.interior_color = text;
      else
        offend(ErrorCode::kBadParameter, raw, complaint);
    } else {
      std::string choice = raw.value.is_string() ? raw.value.get<std::string>() : std::string();
      if (raw.name == "format")  // file endings come in both cases: part.STL
        for (char& c : choice)
          if (c >= 'A' && c <= 'Z') c = static_cast<char>(c + ('a' - 'A'));
      if (std::find(spec->choices.begin(), spec->choices.end(), choice) == spec->choices.end())
        offend(raw.name == "format" ? ErrorCode::kUnknownFormat : ErrorCode::kBadParameter, raw, complaint);
      else
        set_choice(result, *spec, choice);
    }
  }
  const auto both =
      std::find_if(given.begin(), given.end(), [](const auto& raw) { return raw.name == "mass"; });
  if (result.mass && seen.count("density") > 0)
    offend(ErrorCode::kBadParameter, *both, "'mass' and 'density' were both given; each decides the other.");
  if (first) {
    first->extra = {{"errors", std::move(offenders)}};
    return tl::unexpected<Error>(std::move(*first));
  }
  return result;
}

nlohmann::json ParameterTable::to_json() const {
  nlohmann::json list = nlohmann::json::array();
  for (const ParameterSpec& spec : specs_) {
    nlohmann::json entry = {{"name", spec.name}, {"description", spec.doc}};
    if (!spec.default_value.is_null()) entry["default"] = spec.default_value;
    if (spec.type == ParameterSpec::Type::kInteger) {
      entry["type"] = "integer";
      entry["minimum"] = spec.min;
      entry["maximum"] = spec.max;
    } else if (spec.type == ParameterSpec::Type::kNumber) {
      entry["type"] = "number";
      entry["minimum"] = spec.low;
      entry["maximum"] = spec.high;
    } else if (spec.type == ParameterSpec::Type::kNames) {
      entry["type"] = "string";
    } else if (spec.type == ParameterSpec::Type::kText) {
      entry["type"] = "string";
      entry["minLength"] = 1;
      entry["maxLength"] = 63;
    } else if (spec.type == ParameterSpec::Type::kColor) {
      entry["type"] = "string";
      entry["pattern"] = "^#[0-9a-fA-F]{6}$";
    } else {
      entry["type"] = "string";
      entry["enum"] = spec.choices;
    }
    list.push_back(std::move(entry));
  }
  return list;
}

nlohmann::json canonical_solid_parameters(const RequestParameters& p) {
  nlohmann::json json = {{"repair", spelling(p.solid.repair, kRepairs)},
                         {"thickness", p.solid.thickness},
                         {"unit", spelling(p.frame.unit, kUnits)},
                         {"up", spelling(p.frame.up, kAxes)},
                         {"weld_tolerance", p.solid.weld_tolerance}};
  if (!p.parts.nodes.empty()) json["nodes"] = p.parts.nodes;
  if (!p.parts.materials.empty()) json["materials"] = p.parts.materials;
  return json;
}

nlohmann::json canonical_parameters(const RequestParameters& p) {
  nlohmann::json json = canonical_solid_parameters(p);
  json["dual"] = spelling(p.fracture.dual, kDuals);
  json["seed"] = p.fracture.seed;
  json["sites"] = p.fracture.sites;
  json["physics"] = spelling(p.physics, kPhysics);
  json["ue_collision"] = spelling(p.ue_collision, kUeCollisions);
  json["pivot"] = spelling(p.fracture.pivot, kPivots);
  if (!p.interior.material.empty()) json["interior_material"] = p.interior.material;
  if (p.interior.name) json["interior_name"] = *p.interior.name;
  if (p.interior.color) json["interior_color"] = p.interior_color;
  if (p.interior.roughness) json["interior_roughness"] = *p.interior.roughness;
  if (p.interior.metallic) json["interior_metallic"] = *p.interior.metallic;
  if (p.mass)
    json["mass"] = *p.mass;
  else
    json["density"] = p.density;
  return json;
}

}  // namespace fracture
