// The parameter table as JSON, for GET /limits and GET /patterns.
#include <algorithm>

#include "common/materials/notes.hpp"
#include "common/parameters/assignments.hpp"
#include "common/parameters/groups.hpp"
#include "common/parameters/rows.hpp"

namespace fracture {
namespace {

nlohmann::json vector_schema(const ParameterSpec& spec) {
  return {{"type", "array"},
          {"minItems", 3},
          {"maxItems", 3},
          {"items", {{"type", "number"}, {"minimum", spec.low}, {"maximum", spec.high}}}};
}

nlohmann::json describe(const ParameterSpec& spec) {
  nlohmann::json entry;
  switch (spec.type) {
    case Type::kInteger:
      entry = {{"type", "integer"}, {"minimum", spec.min}, {"maximum", spec.max}};
      break;
    case Type::kIntegers:
      entry = {{"type", "array"},
               {"minItems", 1},
               {"maxItems", kMaxIntegers},
               {"items", {{"type", "integer"}, {"minimum", spec.min}, {"maximum", spec.max}}}};
      entry["text"] = "a,b,c";
      break;
    case Type::kNumber:
      entry = {{"type", "number"}, {"minimum", spec.low}, {"maximum", spec.high}};
      break;
    case Type::kNumbers:
      entry = {{"type", "array"},
               {"minItems", 1},
               {"maxItems", kMaxIntegers},
               {"items", {{"type", "number"}, {"minimum", spec.low}, {"maximum", spec.high}}}};
      entry["text"] = "a,b,c";
      break;
    case Type::kNames:
      entry = {{"type", "string"}};
      break;
    case Type::kText:
      entry = {{"type", "string"}, {"minLength", 1}, {"maxLength", spec.longest_text()}};
      break;
    case Type::kColor:
      entry = {{"type", "string"}, {"pattern", "^#[0-9a-fA-F]{6}$"}};
      break;
    case Type::kVector:
    case Type::kDirection:
      entry = vector_schema(spec);
      entry["text"] = "x,y,z";
      break;
    case Type::kVectors:
      entry = {
          {"type", "array"}, {"minItems", spec.min}, {"maxItems", spec.max}, {"items", vector_schema(spec)}};
      entry["text"] = "x,y,z;x,y,z";
      break;
    case Type::kMatrix:
      entry = {{"type", "array"}, {"minItems", 3}, {"maxItems", 3}, {"items", vector_schema(spec)}};
      entry["text"] = "a,b,c;d,e,f;g,h,i";
      break;
    case Type::kAssignments:
      entry = {{"type", "array"},
               {"minItems", 1},
               {"maxItems", kMostAssignments},
               {"items", {{"type", "object"}, {"minProperties", 2}}}};
      entry["text"] = "selector:material;selector:material";
      break;
    case Type::kChoice:
      entry = {{"type", "string"}, {"enum", spec.choices}};
      break;
  }
  entry["name"] = spec.name;
  entry["description"] = spec.doc;
  if (!spec.unit.empty()) entry["unit"] = spec.unit;
  if (!spec.default_value.is_null()) entry["default"] = spec.default_value;
  if (is_assignable(spec.name)) entry["assignable"] = true;
  return entry;
}

/// The parameters of a request that specifies none.
nlohmann::json default_parameters() {
  const RequestParameters nothing;
  return canonical_parameters(nothing);
}

RequestParameters with_choice(const ParameterSpec& spec, std::size_t choice) {
  RequestParameters request;
  spec.set(request, spec, static_cast<std::uint64_t>(choice));
  return request;
}

}  // namespace

nlohmann::json ParameterTable::to_json() const {
  nlohmann::json list = nlohmann::json::array();
  for (const ParameterSpec& spec : specs_) {
    nlohmann::json entry = describe(spec);
    if (std::vector<std::string> words = synonyms_of(spec.name); !words.empty())
      entry["synonyms"] = std::move(words);
    list.push_back(std::move(entry));
  }
  return list;
}

nlohmann::json ParameterTable::patterns_to_json() const {
  nlohmann::json patterns = nlohmann::json::array(), materials = nlohmann::json::array(),
                 general = nlohmann::json::array(), of_mesh = nlohmann::json::array();
  for (std::size_t k = 0; k < std::size(kPatternTraits); ++k) {
    RequestParameters request;
    request.fracture.pattern = default_pattern(k);
    nlohmann::json own = nlohmann::json::array();
    for (const ParameterSpec& spec : specs_) {
      if (spec.patterns.empty() || !belongs(spec, request.fracture.pattern)) continue;
      nlohmann::json entry = describe(spec);
      if (nlohmann::json value = spec.get(request, spec); !value.is_null())
        entry["default"] = std::move(value);
      own.push_back(std::move(entry));
    }
    patterns.push_back({{"name", kPatternTraits[k].name},
                        {"description", kPatternTraits[k].description},
                        {"parameters", std::move(own)}});
  }
  for (const ParameterSpec& spec : specs_)
    if (spec.patterns.empty())
      (spec.decides == Decides::kSolid ? of_mesh : general).push_back(describe(spec));

  const ParameterSpec& material = *find("material");
  const nlohmann::json defaults = default_parameters();
  for (std::size_t k = 0; k < material.choices.size(); ++k) {
    // The values of its pattern, and all other values that differ from the defaults.
    nlohmann::json sets = canonical_parameters(with_choice(material, k));
    for (const ParameterSpec& spec : specs_)
      if (spec.name == "material" || (defaults.contains(spec.name) && sets.contains(spec.name) &&
                                      defaults[spec.name] == sets[spec.name] && spec.name != "pattern"))
        sets.erase(spec.name);
    const MaterialPreset& preset = material_presets()[k];
    const MaterialNotes& notes = notes_of(preset);
    materials.push_back({{"name", preset.name},
                         {"description", preset.doc},
                         {"parameters", std::move(sets)},
                         {"source", preset.source},
                         {"use", notes.use},
                         {"mechanics", notes.mechanics},
                         {"cost", notes.cost}});
  }
  return {{"patterns", std::move(patterns)},
          {"parameters", std::move(general)},
          {"mesh_parameters", std::move(of_mesh)},
          {"materials", std::move(materials)}};
}

}  // namespace fracture
