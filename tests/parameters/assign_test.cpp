// The parameter `assign`: its forms, its limits, and what its entries mean.
#include <gtest/gtest.h>

#include "common/parameters/as_text.hpp"
#include "common/parameters/assignments.hpp"
#include "tests/parameters/parse.hpp"

namespace fracture {
namespace {

using nlohmann::json;

Expected<RequestParameters> parse_json(const json& parameters) {
  std::vector<RawParameter> given;
  for (const auto& [name, value] : parameters.items()) given.push_back({name, value, false});
  return table().parse(given);
}

/// The detail and the first pointer of the refusal; "" if it is accepted.
std::string refusal(const json& assign, std::string* pointer = nullptr) {
  const auto parsed = parse_json({{"assign", assign}});
  if (parsed) return "";
  if (pointer) *pointer = parsed.error().extra->at("errors").at(0).value("pointer", "");
  return parsed.error().detail;
}

TEST(Assign, TheFormOfAQueryEqualsThatOfJson) {
  const auto text = parse_text("assign", "Wall_*:brick; slot=Glass:glass;part=3:wood");
  const auto entries = parse_json({{"assign",
                                    {{{"node", "Wall_*"}, {"material", "brick"}},
                                     {{"slot", {"Glass"}}, {"material", "glass"}},
                                     {{"part", {3}}, {"material", "wood"}}}}});
  ASSERT_TRUE(text) << text.error().detail;
  ASSERT_TRUE(entries) << entries.error().detail;
  EXPECT_EQ(canonical_parameters(*text), canonical_parameters(*entries));
  EXPECT_EQ(canonical_site_parameters(*text), canonical_site_parameters(*entries));
  EXPECT_EQ(canonical_solid_parameters(*text), canonical_solid_parameters(*entries));
  ASSERT_EQ(text->assign.size(), 3u);
  EXPECT_EQ(text->assign[0].selector, PartSelector{.nodes = {"Wall_*"}});
  EXPECT_EQ(text->assign[1].selector, PartSelector{.slots = {"Glass"}});
  EXPECT_EQ(text->assign[2].selector, PartSelector{.parts = {3}});
  EXPECT_EQ(text->assign[1].parameters->material, "glass");
  const json canonical = canonical_parameters(*text);
  EXPECT_EQ(as_text(canonical["assign"]), "Wall_*:brick;slot=Glass:glass;part=3:wood");
  const auto as_json = parse_text("assign", canonical["assign"].dump());
  ASSERT_TRUE(as_json) << as_json.error().detail;
  EXPECT_EQ(canonical_parameters(*as_json), canonical);
  EXPECT_EQ(canonical_parameters(*parse_json(canonical)), canonical) << "an answer's parameters, sent again";
}

TEST(Assign, EntriesHaveTheirMaterialsPropertiesAndTheRequestsSizes) {
  const auto parsed = parse_json({{"material", "brick"},
                                  {"fragments", 70},
                                  {"rough_amplitude", 0.2},
                                  {"seed", 9},
                                  {"assign",
                                   {{{"node", "Window"}, {"material", "glass"}, {"density", 5000}},
                                    {{"node", "Post"}, {"stretch", 3}}}}});
  ASSERT_TRUE(parsed) << parsed.error().detail;
  const RequestParameters &window = *parsed->assign[0].parameters, &post = *parsed->assign[1].parameters;
  EXPECT_EQ(window.physical.density, 5000);
  EXPECT_EQ(window.physical.bond_strength, 45e6);
  EXPECT_EQ(window.fracture.roughness.amplitude, 0.08) << "that of glass, not that of the request";
  EXPECT_EQ(window.fracture.seed, 9u);
  EXPECT_EQ(window.fracture.size.fragments, 70u);
  EXPECT_EQ(post.material, "") << "without a material it is like a request without one";
  EXPECT_EQ(post.fracture.anisotropy.stretch, 3);
  EXPECT_EQ(post.fracture.roughness.amplitude, 0);
  ASSERT_EQ(parsed->fracture.assigned.size(), 2u);
  EXPECT_DOUBLE_EQ(parsed->fracture.assigned[0].density, 5000 / 1900.0) << "brick has 1900 kg/m3";
  EXPECT_DOUBLE_EQ(parsed->fracture.assigned[0].strength, 45e6 / 0.3e6);
  const json canonical = canonical_parameters(*parsed);
  EXPECT_EQ(canonical["assign"][0], (json{{"node", "Window"}, {"material", "glass"}, {"density", 5000.0}}));
  EXPECT_EQ(canonical_parameters(*parse_json(canonical)), canonical);
}

TEST(Assign, WallsOfPartsDetermineTheSolid) {
  const auto walls = [](const json& parameters) {
    return canonical_solid_parameters(*parse_json(parameters));
  };
  const json glass = {{"assign", {{{"node", "Bottle"}, {"material", "glass"}}}}};
  EXPECT_EQ(walls(glass)["assign"],
            (json{{{"node", "Bottle"}, {"shell_fraction", 0.02}, {"shell_ball", 0.2}}}));
  const auto prepared = parse_json(walls(glass));
  ASSERT_TRUE(prepared) << prepared.error().detail;
  EXPECT_EQ(canonical_solid_parameters(*prepared), walls(glass))
      << "a client may prepare the mesh with these";
  EXPECT_EQ(prepared->hollow, parse_json(glass)->hollow);
  EXPECT_FALSE(walls({{"assign", {{{"node", "Post"}, {"material", "wood"}}}}}).contains("assign"));
  const json post = {{"material", "glass"}, {"assign", {{{"node", "Post"}, {"material", "wood"}}}}};
  EXPECT_EQ(walls(post)["assign"], (json{{{"node", "Post"}, {"shell", 0.0}}})) << "wood has no walls";
}

TEST(Assign, ImpactsApplyToTheMaterialsThatHaveThem) {
  const json assign = {{{"node", "Window"}, {"material", "glass"}},
                       {{"node", "Post"}, {"material", "brick"}, {"impacts", {{1, 2, 3}}}}};
  const auto parsed = parse_json({{"impacts", {{4, 5, 6}}}, {"assign", assign}});
  ASSERT_TRUE(parsed) << parsed.error().detail;
  EXPECT_EQ(std::get<RadialPattern>(parsed->assign[0].parameters->fracture.pattern).impacts,
            (std::vector<Vec3d>{{4, 5, 6}}));
  EXPECT_EQ(std::get<BrickPattern>(parsed->assign[1].parameters->fracture.pattern).impacts,
            (std::vector<Vec3d>{{1, 2, 3}}));
}

TEST(Assign, WhatIsWrongIsNamedWithItsPlace) {
  std::string pointer;
  json many = json::array();
  for (int k = 0; k < 64; ++k) many.push_back({{"part", k}, {"material", "wood"}});
  EXPECT_EQ(refusal(many), "");
  many.push_back({{"part", 64}, {"material", "wood"}});
  EXPECT_EQ(refusal(many), "'assign' must have 1 to 64 entries; it had 65.");
  EXPECT_EQ(refusal(json::array()), "'assign' must have 1 to 64 entries; it had 0.");
  EXPECT_EQ(refusal({{{"material", "wood"}}}, &pointer),
            "'assign' must say which parts each entry is for: entry 1 has no 'node', 'slot' or 'part'.");
  EXPECT_EQ(pointer, "/assign/0");
  EXPECT_NE(refusal({{{"node", "a"}}}), "");
  EXPECT_NE(refusal({{{"node", ""}, {"material", "wood"}}}, &pointer), "");
  EXPECT_EQ(pointer, "/assign/0/node");
  EXPECT_NE(refusal({{{"node", std::string(1001, 'a')}, {"material", "wood"}}}), "");
  EXPECT_NE(refusal({{{"part", -1}, {"material", "wood"}}}, &pointer), "");
  EXPECT_EQ(pointer, "/assign/0/part");
  const std::string gold =
      refusal({{{"node", "a"}, {"material", "wood"}}, {{"node", "b"}, {"material", "gold"}}}, &pointer);
  EXPECT_TRUE(gold.starts_with("Entry 2 of 'assign': 'material' must be glass")) << gold;
  EXPECT_EQ(pointer, "/assign/1/material");
  EXPECT_NE(refusal({{{"node", "a"}, {"material", "wood"}, {"fragments", 3}}}, &pointer)
                .find("'fragments' is not a property"),
            std::string::npos);
  EXPECT_EQ(pointer, "/assign/0/fragments");
  EXPECT_NE(refusal({{{"node", "a"}, {"materiel", "wood"}}}, &pointer).find("Did you mean 'material'?"),
            std::string::npos);
  EXPECT_EQ(pointer, "/assign/0/materiel");
  EXPECT_NE(refusal({{{"node", "a"}, {"material", "wood"}, {"jitter", 0.1}}})
                .find("entry of 'assign' uses the uniform pattern"),
            std::string::npos);
  EXPECT_NE(refusal({3}), "");
  EXPECT_FALSE(parse_text("assign", "Wall"));
  EXPECT_FALSE(parse_text("assign", "part=x:wood"));
  EXPECT_FALSE(parse_text("assign", "[{]"));
  EXPECT_FALSE(parse_json({{"bond_strength", 0}, {"assign", json::array({many.front()})}}));
}

}  // namespace
}  // namespace fracture
