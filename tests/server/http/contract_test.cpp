// Compares proto/openapi.yaml (as the JSON that the server serves) with the server's own tables.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "common/materials/materials.hpp"
#include "common/parameters/parameters.hpp"
#include "server/http/api.hpp"
#include "server/http/problem.hpp"

namespace fracture::http {
namespace {

using nlohmann::json;

const json& document() {
  static const json parsed = json::parse(openapi_json());
  return parsed;
}

json resolve(const json& value) {
  if (!value.contains("$ref")) return value;
  return resolve(document().at(json::json_pointer(value.at("$ref").get<std::string>().substr(1))));
}

TEST(Contract, EveryPathAndMethodOfTheDocumentIsRoutedAndTheReverse) {
  std::set<std::string> documented, routed;
  for (const auto& [path, item] : document().at("paths").items())
    for (const auto& [method, operation] : item.items())
      if (method != "servers" && method != "parameters") {
        std::string upper = method;
        for (char& c : upper) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
        documented.insert(upper + " " + path);
      }
  for (const Route& route : routes())
    routed.insert(std::string(route.method) + " " + std::string(route.path));
  EXPECT_EQ(documented, routed);
}

TEST(Contract, EveryPublicAnswerMaySayWhatIsLeftOfAShare) {
  for (const auto& [path, item] : document().at("paths").items())
    for (const auto& [method, operation] : item.items()) {
      if (!operation.is_object() || !operation.contains("responses")) continue;
      for (const auto& [status, response] : operation.at("responses").items())
        for (const char* name : {"RateLimit", "RateLimit-Policy"}) {
          const json described = resolve(response).value("headers", json::object());
          if (item.contains("servers") && !response.contains("$ref")) {
            EXPECT_FALSE(described.contains(name))
                << path << " " << status << ": the admin listener knows no names";
          } else if (!item.contains("servers")) {
            EXPECT_EQ(resolve(described.at(name)).at("schema").at("type"), "string") << path << " " << status;
          }
        }
    }
}

TEST(Contract, SummariesAndListenersAgree) {
  for (const Route& route : routes()) {
    const json& item = document().at("paths").at(std::string(route.path));
    std::string method(route.method);
    for (char& c : method) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    const json& operation = item.at(method);
    EXPECT_EQ(operation.at("summary"), route.summary) << route.path;
    EXPECT_EQ(item.contains("servers"), route.listener == Listener::kAdmin) << route.path;
  }
}

TEST(Contract, EveryProblemIsListedAndNoOther) {
  std::set<std::string> documented, table;
  for (const json& type :
       document().at("components").at("schemas").at("Problem").at("properties").at("type").at("enum"))
    documented.insert(type);
  for (const ProblemType& type : problem_types()) table.insert("/problems/" + std::string(type.slug));
  EXPECT_EQ(documented, table);
  EXPECT_EQ(table.size(), problem_types().size()) << "a slug stands twice in the table";
}

TEST(Contract, EveryCodeHasItsOwnRowAndAnErrorStatus) {
#define FRACTURE_ERROR(name, its_slug, its_title) EXPECT_EQ(problem_type(ErrorCode::name).slug, its_slug);
#include "common/base/error_codes.def"
#undef FRACTURE_ERROR
  for (const ProblemType& type : problem_types()) {
    EXPECT_GE(type.status, 400) << type.slug;
    EXPECT_LE(type.status, 599) << type.slug;
  }
}

TEST(Contract, EveryParameterIsListedWithItsRangeAndDefault) {
  const ParameterTable table(ServiceConfig{}.max_sites, FormatSet::all());
  const json operation = document().at("paths").at("/fracture").at("post");
  std::set<std::string> documented, known;
  for (const json& reference : operation.at("parameters")) {
    if (resolve(reference).at("in") != "query") continue;
    const json parameter = resolve(reference), schema = resolve(parameter.at("schema"));
    const std::string name = parameter.at("name");
    documented.insert(name);
    const ParameterSpec* spec = table.find(name);
    ASSERT_NE(spec, nullptr) << name;
    if (spec->type == ParameterSpec::Type::kInteger) {
      EXPECT_EQ(schema.at("minimum"), spec->min) << name;
      EXPECT_EQ(schema.at("maximum"), spec->max) << name;
    } else if (spec->type == ParameterSpec::Type::kIntegers) {
      const json array = schema.at("oneOf").at(1);
      EXPECT_EQ(array.at("maxItems"), kMaxIntegers) << name;
      EXPECT_EQ(array.at("items").at("minimum"), spec->min) << name;
      EXPECT_EQ(array.at("items").at("maximum"), spec->max) << name;
    } else if (spec->type == ParameterSpec::Type::kNumbers) {
      const json array = schema.at("oneOf").at(1);
      EXPECT_EQ(array.at("maxItems"), kMaxIntegers) << name;
      EXPECT_EQ(array.at("items").at("minimum"), spec->low) << name;
      EXPECT_EQ(array.at("items").at("maximum"), spec->high) << name;
    } else if (spec->type == ParameterSpec::Type::kNumber) {
      EXPECT_EQ(schema.at("minimum"), spec->low) << name;
      EXPECT_EQ(schema.at("maximum"), spec->high) << name;
    } else if (spec->type == ParameterSpec::Type::kNames) {
      EXPECT_EQ(schema.at("oneOf").size(), 2u) << name;  // a string, or an array of strings
    } else if (spec->type == ParameterSpec::Type::kAssignments) {
      const json array = schema.at("oneOf").at(1);
      EXPECT_EQ(array.at("minItems"), 1) << name;
      EXPECT_EQ(array.at("maxItems"), kMostAssignments) << name;
    } else if (spec->type == ParameterSpec::Type::kText) {
      EXPECT_EQ(schema.at("minLength"), 1) << name;
      EXPECT_EQ(schema.at("maxLength"), spec->longest_text()) << name;
    } else if (spec->type == ParameterSpec::Type::kColor) {
      EXPECT_EQ(schema.at("pattern"), "^#[0-9a-fA-F]{6}$") << name;
    } else if (spec->type == ParameterSpec::Type::kChoice) {
      EXPECT_EQ(schema.at("enum"), json(spec->choices)) << name;
    } else {  // a string, or arrays of numbers
      const json array = schema.at("oneOf").at(1);
      const bool list = spec->type == ParameterSpec::Type::kVectors,
                 matrix = spec->type == ParameterSpec::Type::kMatrix;
      EXPECT_EQ(array.at("minItems"), list ? spec->min : 3) << name;
      EXPECT_EQ(array.at("maxItems"), list ? spec->max : 3) << name;
      const json numbers = list || matrix ? array.at("items").at("items") : array.at("items");
      EXPECT_EQ(numbers.at("minimum"), spec->low) << name;
      EXPECT_EQ(numbers.at("maximum"), spec->high) << name;
    }
    EXPECT_EQ(schema.value("default", json()), spec->default_value) << name;
  }
  for (const ParameterSpec& spec : table.specs()) known.insert(spec.name);
  EXPECT_EQ(documented, known);
  std::set<std::string> in_json;
  for (const auto& [name, schema] :
       document().at("components").at("schemas").at("Parameters").at("properties").items())
    in_json.insert(name);
  EXPECT_EQ(in_json, known);
}

TEST(Contract, TheDocumentNamesTheMaterialsThatHaveWallsAndHowThick) {
  const std::string words = document()
                                .at("components")
                                .at("schemas")
                                .at("Parameters")
                                .at("properties")
                                .at("shell_fraction")
                                .at("description");
  std::size_t listed = 0;
  for (std::size_t at = 0; (at = words.find(" 0.0", at)) != std::string::npos; ++at) ++listed;
  std::size_t hollow = 0;
  for (const MaterialPreset& preset : material_presets()) {
    if (preset.shell_fraction == 0) continue;
    ++hollow;
    const std::string sentence = std::string(preset.name) + " " + json(preset.shell_fraction).dump();
    EXPECT_NE(words.find(sentence), std::string::npos) << sentence << " is not in: " << words;
  }
  EXPECT_EQ(listed, hollow) << words;
}

TEST(Contract, AStoredMeshIsFracturedWithTheSameParametersButItsFormat) {
  const auto names = [](const char* path) {
    std::set<std::string> set;
    for (const json& reference : document().at("paths").at(path).at("post").at("parameters"))
      set.insert(resolve(reference).at("name"));
    return set;
  };
  std::set<std::string> all = names("/fracture");
  all.erase("format");
  EXPECT_EQ(names("/meshes/{id}/fracture"), all);
}

TEST(Contract, TheDocumentCarriesTheServersVersion) {
  EXPECT_EQ(document().at("info").at("version"), FRACTURE_VERSION);
}

}  // namespace
}  // namespace fracture::http
