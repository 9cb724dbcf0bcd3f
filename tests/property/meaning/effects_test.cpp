// Every parameter does something, or the report says by name that it had no effect. The values here are chosen
// so that they should matter.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "common/materials/materials.hpp"
#include "common/parameters/effects.hpp"
#include "server/service/service.hpp"
#include "tests/server/support/engine_in_process.hpp"

namespace fracture::test {
namespace {

using nlohmann::json;

/// A box as an object of an OBJ file, with a grid on each side. `vertices`: number of those before it.
std::string box_object(const char* name, const Vec3d& low, const Vec3d& high, int& vertices) {
  constexpr int kGrid = 3;
  std::string text = std::string("o ") + name + "\n";
  for (int axis = 0; axis < 3; ++axis)
    for (int end = 0; end < 2; ++end)
      for (int i = 0; i < kGrid; ++i)
        for (int j = 0; j < kGrid; ++j) {
          for (const auto& [a, b] : {std::pair{i, j}, {i + 1, j}, {i + 1, j + 1}, {i, j + 1}}) {
            Vec3d share;
            share[axis] = end;
            share[(axis + 1) % 3] = static_cast<double>(a) / kGrid;
            share[(axis + 2) % 3] = static_cast<double>(b) / kGrid;
            text += "v";
            for (int k = 0; k < 3; ++k) text += " " + std::to_string(low[k] + share[k] * (high[k] - low[k]));
            text += "\n";
          }
          const int first = vertices + 1;
          vertices += 4;
          text += "f";
          for (int k = 0; k < 4; ++k) text += " " + std::to_string(first + (end == 1 ? k : 3 - k));
          text += "\n";
        }
  return text;
}
std::string block() {
  int vertices = 0;
  return box_object("block", {0, 0, 0}, {2, 1, 0.8}, vertices);
}
/// Two boxes that touch.
std::string blocks() {
  int vertices = 0;
  return box_object("low", {0, 0, 0}, {1, 1, 0.8}, vertices) +
         box_object("high", {1, 0, 0}, {2, 1.2, 0.8}, vertices);
}

class Answers {
 public:
  Expected<FractureAnswer> ask(const std::string& mesh, const json& parameters) {
    std::vector<RawParameter> given;
    for (const auto& [name, value] : parameters.items()) given.push_back({name, value, false});
    Expected<RequestParameters> parsed = service_.parse(given);
    if (!parsed) return tl::unexpected<Error>(parsed.error());
    return service_.fracture({std::as_bytes(std::span(mesh.data(), mesh.size())), MeshFormat::kObj, *parsed},
                             {});
  }

 private:
  ServiceConfig config_;
  FractureService service_{config_, engine_in_process()};
};

struct Contents {
  json document;  ///< without the parameters of the request
  std::string binary;
  std::vector<std::string> warnings;
};

Contents contents_of(const FractureResult& result) {
  std::uint32_t length = 0;
  std::memcpy(&length, result.file.data() + 12, 4);
  Contents contents;
  contents.document = json::parse(result.file.begin() + 20, result.file.begin() + 20 + length);
  contents.binary.assign(result.file.begin() + 20 + length, result.file.end());
  for (json& node : contents.document.at("nodes")) {
    const json::json_pointer all("/extras/fracture");
    if (!node.contains(all) || !node.at(all).contains("report")) continue;
    for (const json& warning : node.at(all).at("report").at("warnings"))
      contents.warnings.push_back(warning.get<std::string>());
    node.at(all).erase("parameters");
  }
  return contents;
}

struct Case {
  const char* parameter;
  const char* value;
  const char* context = "{}";  ///< the rest of the request
};

/// Values that should matter, with their requests.
const std::vector<Case> kCases = {
    {"material", "\"wood\""},
    {"pattern", "\"grid\""},
    {"sites", "33"},
    {"seed", "8"},
    {"lloyd", "3"},
    {"stretch", "3"},
    {"grain", "[1, 1, 0]", R"({"stretch": 3})"},
    {"grain_of", "\"part\"", R"({"stretch": 3})"},
    {"stretch_matrix", "[[1, 0, 0], [0, 3, 0], [0, 0, 1]]"},
    {"cells_per_fragment", "4"},
    {"size_spread", "2", R"({"cells_per_fragment": 6})"},
    {"points", "[[0.5, 0.5, 0.4], [1.5, 0.5, 0.4], [1, 0.2, 0.4]]", R"({"pattern": "points"})"},
    {"impacts", "[[0, 0.5, 0.4]]"},
    {"radius", "0.2", R"({"pattern": "impact"})"},
    {"exponent", "0", R"({"pattern": "impact"})"},
    {"share", "0.2", R"({"pattern": "impact"})"},
    {"clusters", "4", R"({"pattern": "clustered"})"},
    {"around", "\"point\"", R"({"pattern": "radial"})"},
    {"axis", "[1, 0, 0]", R"({"pattern": "radial"})"},
    {"spokes", "7", R"({"pattern": "radial"})"},
    {"rings", "3", R"({"pattern": "radial"})"},
    {"growth", "2", R"({"pattern": "radial"})"},
    {"merge", "0", R"({"pattern": "radial"})"},
    {"crushed", "0.5", R"({"pattern": "radial"})"},
    {"jitter", "0.9", R"({"pattern": "grid"})"},
    {"cell", "[0.4, 0.3, 0.5]", R"({"pattern": "grid"})"},
    {"bond", "\"third\"", R"({"pattern": "brick"})"},
    {"mortar", "\"#b9b4a8\"", R"({"pattern": "brick"})"},
    {"normals", "[[1, 0, 0]]", R"({"pattern": "slice"})"},
    {"spacing", "0.3", R"({"pattern": "slice"})"},
    {"tilt", "30", R"({"pattern": "slice"})"},
    {"fragments", "11"},
    {"parts", "\"apart\""},
    {"min_volume", "0.05"},
    {"min_fraction", "0.05"},
    {"min_of_mean", "0.9"},
    {"max_volume", "0.05"},
    {"max_fragments", "5"},
    {"max_triangles", "700"},
    {"keep_box", "[[-1, -1, -1], [1, 3, 3]]"},
    {"anchor_plane", "[[0, 0, 0], [0, 1, 0]]"},
    {"anchor_box", "[[0, 0, 0], [0.2, 0.2, 0.2]]"},
    {"anchor_points", "[[0, 0, 0]]"},
    {"gravity", "[0, -100, 0]", R"({"anchor_plane": [[0, 0, 0], [0, 1, 0]]})"},
    {"broken", "[7]", R"({"anchor_plane": [[0, 0, 0], [0, 1, 0]]})"},
    {"local_sites", "[60]", R"({"local_point": [0, 0.5, 0.4], "local_radius": 0.3})"},
    {"local_rest", "\"fractured\"", R"({"local_point": [0, 0.5, 0.4], "local_radius": 0.3})"},
    {"rough_amplitude", "0.05"},
    {"rough_frequency", "9", R"({"rough_amplitude": 0.03})"},
    {"rough_octaves", "1", R"({"rough_amplitude": 0.03, "rough_frequency": 4})"},
    {"shell", "0.1"},
    {"shell_fraction", "0.05"},
    {"shell_ball", "0.9", R"({"shell_fraction": 0.05})"},
    {"contact_gap", "0.05"},
    {"contact_strength", "0"},
    {"unit", "\"cm\""},
    {"up", "\"z\""},
    {"nodes", "[\"low\"]"},
    {"dual", "\"barycenter\""},
    {"drop_above", "0.03", R"({"dual": "barycenter"})"},
    {"physics", "\"omi\""},
    {"ue_collision", "\"ucx\""},
    {"max_hulls", "1", R"({"cells_per_fragment": 6})"},
    {"pivot", "\"source\""},
    {"intact", "\"true\""},
    {"interior_name", "\"Inside\""},
    {"interior_color", "\"#ff0000\""},
    {"interior_roughness", "0.1"},
    {"interior_metallic", "1"},
    {"interior_opacity", "0.5"},
    {"interior_detail", "\"stone\""},
    {"interior_uv_scale", "3"},
    {"interior_uv_u", "0.4"},
    {"interior_uv_v", "0.4"},
    {"density", "700"},
    {"mass", "12"},
    {"friction", "0.9"},
    {"restitution", "0.9"},
    {"bond_strength", "1234"},
};

/// Requests in which a parameter cannot have an effect.
const std::vector<Case> kIdle = {
    {"seed", "8", R"({"pattern": "points", "points": [[0.5, 0.5, 0.4], [1.5, 0.5, 0.4]]})"},
    {"seed", "8", R"({"pattern": "grid"})"},
    {"grain", "[1, 1, 0]"},
    {"grain_of", "\"part\""},
    {"grain_of", "\"part\"", R"({"pattern": "brick", "stretch": 2})"},
    {"size_spread", "2"},
    {"radius", "0.3", R"({"pattern": "impact", "share": 0})"},
    {"exponent", "1", R"({"pattern": "impact", "share": 0})"},
    {"axis", "[1, 0, 0]", R"({"pattern": "radial", "around": "point"})"},
    {"tilt", "20", R"({"pattern": "slice", "normals": [[1, 0, 0], [0, 1, 0]]})"},
    {"impacts", "[[0, 0.5, 0.4], [2, 0.5, 0.4]]", R"({"pattern": "radial"})"},
    {"parts", "\"apart\""},
    {"instances", "\"separate\""},
    {"contact_gap", "0.01"},
    {"contact_strength", "0.5"},
    {"gravity", "[0, -3, 0]"},
    {"broken", "[7, 8]", R"({"anchor_plane": [[0, 0, 0], [0, 1, 0]]})"},
    {"local_sites", "[60]"},
    {"local_rest", "\"fractured\""},
    {"fragment_sites", "9"},
    {"fragment_seed", "9"},
    {"rough_frequency", "9"},
    {"rough_octaves", "1"},
    {"shell", "0.6"},
    {"shell_ball", "0.5"},
    {"cells_per_fragment", "4", R"({"dual": "barycenter"})"},
    {"size_spread", "2", R"({"dual": "barycenter", "cells_per_fragment": 4})"},
    {"min_of_mean", "0.5", R"({"dual": "barycenter"})"},
    {"dual", "\"barycenter\"", R"({"local_point": [0, 0.5, 0.4], "local_radius": 0.3})"},
    {"drop_above", "100", R"({"dual": "barycenter"})"},
    {"max_hulls", "2", R"({"physics": "none"})"},
    {"keep_box", "[[5, 5, 5], [6, 6, 6]]"},
    {"points", "[[0.5, 0.5, 0.4], [0.5, 0.5, 0.4], [0.5, 0.5, 0.4]]", R"({"pattern": "points"})"},
};

json request_of(const Case& c, bool with) {
  json request = json::parse(c.context);
  if (!request.contains("sites") && !request.contains("pattern") && !request.contains("dual"))
    request["sites"] = 20;
  if (with) request[c.parameter] = json::parse(c.value);
  return request;
}

TEST(Effects, AValueThatShouldMatterChangesTheAnswer) {
  Answers answers;
  const std::string mesh = blocks();
  for (const Case& c : kCases) {
    SCOPED_TRACE(std::string(c.parameter) + "=" + c.value + " " + c.context);
    json without = request_of(c, false);
    if (without.value("pattern", "") == "points") without["points"] = {{0.5, 0.5, 0.4}, {1.5, 0.5, 0.4}};
    const auto plain = answers.ask(mesh, without), set = answers.ask(mesh, request_of(c, true));
    ASSERT_TRUE(plain) << plain.error().detail;
    ASSERT_TRUE(set) << set.error().detail;
    const Contents before = contents_of(*plain->result), after = contents_of(*set->result);
    EXPECT_TRUE(before.binary != after.binary || before.document != after.document);
    const auto idle = std::find_if(after.warnings.begin(), after.warnings.end(), [&](const std::string& w) {
      return w.starts_with(std::string("'") + c.parameter + "' had no effect");
    });
    if (std::string_view(c.parameter) != "broken") {
      EXPECT_EQ(idle, after.warnings.end()) << *idle;
    }
  }
}

TEST(Effects, AValueWithoutEffectIsNamedInTheReport) {
  Answers answers;
  const std::string mesh = block();
  for (const Case& c : kIdle) {
    SCOPED_TRACE(std::string(c.parameter) + "=" + c.value + " " + c.context);
    const auto made = answers.ask(mesh, request_of(c, true));
    ASSERT_TRUE(made) << made.error().detail;
    const Contents contents = contents_of(*made->result);
    EXPECT_TRUE(std::any_of(contents.warnings.begin(), contents.warnings.end(), [&](const std::string& w) {
      return w.find(std::string("'") + c.parameter + "'") != std::string::npos;
    })) << json(contents.warnings);
    // The report depends on the parameter, so the answer has an address of its own.
    if (std::string_view(c.parameter) == "points") continue;
    const auto plain = answers.ask(mesh, request_of(c, false));
    ASSERT_TRUE(plain) << plain.error().detail;
    EXPECT_NE(plain->result->key, made->result->key);
    // The answer's own parameters give the same answer.
    json again = json::parse(made->result->parameters);
    const auto same = answers.ask(mesh, again);
    ASSERT_TRUE(same) << same.error().detail;
    EXPECT_EQ(same->result->key, made->result->key);
  }
}

TEST(Effects, NoValueOfAMaterialIsNamed) {
  Answers answers;
  const std::string mesh = block();
  std::size_t made = 0;
  for (const MaterialPreset& preset : material_presets())
    for (const char* given :
         {R"({"shell": 0})", R"({"shell_fraction": 0})", R"({"rough_amplitude": 0})",
          R"({"stretch_matrix": [[1, 0, 0], [0, 2, 0], [0, 0, 1]]})", R"({"dual": "barycenter"})"}) {
      json request = json::parse(given);
      request["material"] = preset.name;
      if (std::string_view(preset.name) != "brick") request["sites"] = 12;
      SCOPED_TRACE(request.dump());
      const auto answer = answers.ask(mesh, request);
      // Barycentric cells are neither stretched nor turned.
      if (!answer && request.contains("dual")) continue;
      ASSERT_TRUE(answer) << answer.error().detail;
      ++made;
      for (const std::string& warning : contents_of(*answer->result).warnings)
        EXPECT_EQ(warning.find("had no effect"), std::string::npos) << warning;
    }
  EXPECT_GT(made, 4 * material_presets().size());
}

TEST(Effects, EveryParameterHasACase) {
  // Tested elsewhere: they need other meshes (materials, sheets, colours, instances) or earlier answers, or two of them
  // are one value.
  std::set<std::string> known{"format",
                              "repair",
                              "thickness",
                              "weld_tolerance",
                              "materials",
                              "density_from",
                              "sheets",
                              "proxies",
                              "assign",
                              "instances",
                              "exterior",
                              "interior",
                              "interior_material",
                              "interior_mix",
                              "interior_shade",
                              "interior_crushed",
                              "levels",
                              "keep_center",
                              "keep_radius",
                              "local_point",
                              "local_radius",
                              "of",
                              "delta",
                              "local_new",
                              "fragment",
                              "fragment_sites",
                              "fragment_seed",
                              "hull_excess"};
  for (const Case& c : kCases) known.insert(c.parameter);
  const ParameterTable table(1'000, FormatSet());
  for (const ParameterSpec& row : table.specs())
    EXPECT_TRUE(known.contains(row.name)) << "a value that should matter is missing for " << row.name;
  std::set<std::string> idle;
  for (const Case& c : kIdle) idle.insert(c.parameter);
  for (const ParameterSpec& row : table.specs())
    if (has_effect_check(row.name) && row.name != "hull_excess" && row.name != "mortar") {
      EXPECT_TRUE(idle.contains(row.name)) << row.name;
    }
}

}  // namespace
}  // namespace fracture::test
