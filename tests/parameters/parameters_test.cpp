#include "common/parameters/parameters.hpp"

#include <gtest/gtest.h>

#include <set>

namespace fracture {
namespace {

const ParameterTable& table() {
  static const ParameterTable instance(100'000, FormatSet());
  return instance;
}

Expected<RequestParameters> parse_text(const std::string& name, const std::string& value) {
  return table().parse({{name, value, true}});
}

TEST(Parameters, NothingGivenMeansTheDefaults) {
  const auto parsed = table().parse({});
  ASSERT_TRUE(parsed);
  EXPECT_EQ(parsed->fracture.sites, 50u);
  EXPECT_EQ(parsed->fracture.seed, 1u);
  EXPECT_EQ(parsed->fracture.dual, Dual::kCircumcenter);
  EXPECT_FALSE(parsed->format);
}

TEST(Parameters, BothEndsOfEachRangeAreAccepted) {
  EXPECT_EQ(parse_text("sites", "1")->fracture.sites, 1u);
  EXPECT_EQ(parse_text("sites", "100000")->fracture.sites, 100'000u);
  EXPECT_EQ(parse_text("seed", "0")->fracture.seed, 0u);
  EXPECT_EQ(parse_text("seed", "9007199254740991")->fracture.seed, 9007199254740991u);
  EXPECT_EQ(parse_text("dual", "barycenter")->fracture.dual, Dual::kBarycenter);
}

TEST(Parameters, EverythingThatIsNoNumberInRangeIsRefusedWithValueAndRange) {
  for (const char* bad : {"0", "-5", "1e12", "1000000000000", "100001", "", " 5", "5 ", "+5", "0x10", "5.0",
                          "nan", "99999999999999999999999999"}) {
    const auto parsed = parse_text("sites", bad);
    ASSERT_FALSE(parsed) << bad;
    EXPECT_EQ(parsed.error().code, ErrorCode::kBadParameter) << bad;
    EXPECT_EQ(parsed.error().pointer, "sites") << bad;
    EXPECT_NE(parsed.error().detail.find("from 1 to 100000"), std::string::npos) << parsed.error().detail;
    EXPECT_NE(parsed.error().detail.find(std::string("'") + bad + "'"), std::string::npos)
        << parsed.error().detail;
  }
}

TEST(Parameters, NumbersAreDecimalsInTheirRange) {
  EXPECT_EQ(parse_text("thickness", "0.02")->solid.thickness, 0.02);
  EXPECT_EQ(parse_text("thickness", "1e-3")->solid.thickness, 0.001);
  EXPECT_EQ(table().parse({{"thickness", 1, false}})->solid.thickness, 1.0);
  EXPECT_EQ(parse_text("weld_tolerance", "0")->solid.weld_tolerance, 0.0);
  EXPECT_EQ(parse_text("density", "2400")->physical.density, 2400.0);
  EXPECT_EQ(parse_text("mass", "80.5")->mass, 80.5);
  for (const char* bad :
       {"", " 1", "1 ", "+1", "nan", "inf", "-1", "-0.001", "1001", "0x1", "1,5", "1e999"}) {
    const auto parsed = parse_text("thickness", bad);
    ASSERT_FALSE(parsed) << bad;
    EXPECT_EQ(parsed.error().code, ErrorCode::kBadParameter) << bad;
    EXPECT_NE(parsed.error().detail.find("from 0 to 1000"), std::string::npos) << parsed.error().detail;
  }
  EXPECT_FALSE(table().parse({{"thickness", "1", false}}));
  EXPECT_FALSE(parse_text("weld_tolerance", "0.02"));
  EXPECT_FALSE(parse_text("density", "0"));
}

TEST(Parameters, MassAndDensityExcludeEachOther) {
  const auto parsed = table().parse({{"mass", "5"}, {"density", "1000"}});
  ASSERT_FALSE(parsed);
  EXPECT_EQ(parsed.error().pointer, "mass");
  const auto mass = canonical_parameters(*table().parse({{"mass", "5"}}));
  EXPECT_EQ(mass.at("mass"), 5.0);
  EXPECT_FALSE(mass.contains("density"));
}

TEST(Parameters, NamesAreASetHoweverTheyAreGiven) {
  const std::vector<std::string> expected{"a b", "wand", "\xc3\xbc"};
  EXPECT_EQ(parse_text("nodes", "wand,a b,\xc3\xbc,wand")->parts.nodes, expected);
  EXPECT_EQ(table().parse({{"materials", {"\xc3\xbc", "a b", "wand"}, false}})->parts.materials, expected);
  for (const char* bad : {"", ",", "a,", ",a", "a,,b", "\xff"}) EXPECT_FALSE(parse_text("nodes", bad)) << bad;
  for (const nlohmann::json& bad :
       {nlohmann::json::array(), nlohmann::json{5}, nlohmann::json(5), nlohmann::json{""}})
    EXPECT_FALSE(table().parse({{"nodes", bad, false}})) << bad;
}

TEST(Parameters, EverythingThatDecidesTheAnswerIsInItsCanonicalForm) {
  const std::string defaults = canonical_parameters(*table().parse({})).dump();
  for (const auto& [name, value] :
       std::vector<std::pair<std::string, std::string>>{{"repair", "strict"},
                                                        {"thickness", "0.1"},
                                                        {"weld_tolerance", "0"},
                                                        {"unit", "inch"},
                                                        {"up", "z"},
                                                        {"nodes", "a"},
                                                        {"materials", "a"},
                                                        {"physics", "omi"},
                                                        {"ue_collision", "ucx"},
                                                        {"pivot", "source"},
                                                        {"shell", "0.5"},
                                                        {"shell_fraction", "0.1"},
                                                        {"interior", "plain"},
                                                        {"interior_detail", "brick"},
                                                        {"interior_uv_scale", "2"},
                                                        {"interior_uv_u", "0.5"},
                                                        {"interior_uv_v", "0.5"},
                                                        {"interior_material", "Rock"},
                                                        {"interior_name", "Inside"},
                                                        {"interior_color", "#a0B1c2"},
                                                        {"interior_mix", "0.5"},
                                                        {"interior_shade", "1.5"},
                                                        {"interior_opacity", "0.5"},
                                                        {"interior_crushed", "0.5"},
                                                        {"interior_roughness", "0.25"},
                                                        {"interior_metallic", "1"},
                                                        {"density", "1"},
                                                        {"mass", "1"},
                                                        {"sites", "7"},
                                                        {"seed", "7"},
                                                        {"dual", "barycenter"}}) {
    const auto parsed = parse_text(name, value);
    ASSERT_TRUE(parsed) << name;
    EXPECT_NE(canonical_parameters(*parsed).dump(), defaults) << name;
    const auto shown = canonical_parameters(*parsed).at(name);
    EXPECT_EQ(shown.is_array()    ? shown.at(0).get<std::string>()
              : shown.is_string() ? shown.get<std::string>()
                                  : value,
              value);
  }
}

TEST(Parameters, LevelsMustIncreaseAndAreInsteadOfSites) {
  const auto parsed = table().parse({{"levels", {8, 40, 200}, false}});
  ASSERT_TRUE(parsed);
  EXPECT_EQ(parsed->fracture.levels, (std::vector<std::uint32_t>{8, 40}));
  EXPECT_EQ(parsed->fracture.sites, 200u);
  EXPECT_EQ(canonical_parameters(*parsed).at("levels"), nlohmann::json({8, 40, 200}));
  EXPECT_EQ(parse_text("levels", "8,40,200")->fracture.levels, parsed->fracture.levels);
  for (const char* bad : {"40,8", "8,8", "", "8,", "0,5", "1.5,3", "1,2,3,4,5,6,7,8,9"})
    EXPECT_FALSE(parse_text("levels", bad)) << bad;
  EXPECT_TRUE(table().parse({{"levels", {8, 40}, false}, {"sites", 40, false}}));
  const auto both = table().parse({{"levels", {8, 40}, false}, {"sites", 41, false}});
  ASSERT_FALSE(both);
  EXPECT_EQ(both.error().code, ErrorCode::kBadParameter);
  const auto falling = table().parse({{"levels", {40, 8}, false}});
  ASSERT_FALSE(falling);
  EXPECT_EQ(falling.error().extra->at("errors").at(0).at("pointer"), "/levels");
}

TEST(Parameters, ValuesThatBelongTogetherAreAskedForTogether) {
  using Given = std::vector<RawParameter>;
  const Given sphere{{"keep_center", "0,1,0"}, {"keep_radius", "0.5"}};
  const auto kept = table().parse(sphere);
  ASSERT_TRUE(kept && kept->fracture.keep);
  EXPECT_EQ(kept->fracture.keep->center, (Vec3d{0, 1, 0}));
  EXPECT_EQ(kept->fracture.keep->radius, 0.5);
  const auto held = table().parse({{"anchor_plane", "0,2,0;0,4,0"}});
  ASSERT_TRUE(held);
  ASSERT_EQ(held->fracture.anchors.planes.size(), 1u);
  EXPECT_EQ(held->fracture.anchors.planes[0].offset, 2);  // along the unit normal
  for (const auto& [given, name] : std::vector<std::pair<Given, std::string>>{
           {{sphere[0]}, "keep_radius"},
           {{sphere[1]}, "keep_center"},
           {{{"local_point", "0,0,0"}}, "local_radius"},
           {{{"local_radius", "1"}}, "local_point"},
           {{{"broken", "5"}}, "broken"},
           {{{"keep_box", "0,0,0;-1,1,1"}}, "keep_box"},
           {{{"anchor_plane", "0,0,0;0,0,0"}}, "anchor_plane"},
           {{{"drop_above", "2"}}, "drop_above"},
           {{{"min_volume", "2"}, {"max_volume", "1"}}, "max_volume"}}) {
    const auto parsed = table().parse(given);
    ASSERT_FALSE(parsed) << name;
    EXPECT_EQ(parsed.error().code, ErrorCode::kBadParameter) << name;
    EXPECT_EQ(parsed.error().pointer, name);
  }
}

TEST(Parameters, AnUnknownNameIsRefusedByNameWithTheKnownOnes) {
  const auto parsed = parse_text("site", "5");
  ASSERT_FALSE(parsed);
  EXPECT_EQ(parsed.error().code, ErrorCode::kUnknownParameter);
  EXPECT_EQ(parsed.error().pointer, "site");
  EXPECT_NE(parsed.error().detail.find("sites"), std::string::npos);
}

TEST(Parameters, AMisspeltNameIsToldTheNearestOne) {
  const std::vector<std::pair<std::string, std::string>> misspelt{
      {"site", "sites"}, {"materal", "material"}, {"local-point", "local_point"}, {"sed", "seed"}};
  for (const auto& [given, meant] : misspelt) {
    const auto parsed = parse_text(given, "5");
    ASSERT_FALSE(parsed);
    EXPECT_NE(parsed.error().detail.find("Did you mean '" + meant + "'?"), std::string::npos) << given;
  }
  EXPECT_EQ(parse_text("colour", "5").error().detail.find("Did you mean"), std::string::npos);
}

TEST(Parameters, EveryOffenderIsListed) {
  const auto parsed = table().parse({{"sites", "0"}, {"colour", "red"}, {"dual", 5, false}});
  ASSERT_FALSE(parsed);
  const auto& errors = parsed.error().extra->at("errors");
  ASSERT_EQ(errors.size(), 3u);
  EXPECT_EQ(errors[0].at("parameter"), "sites");
  EXPECT_EQ(errors[1].at("parameter"), "colour");
  EXPECT_EQ(errors[2].at("pointer"), "/dual");
}

TEST(Parameters, GivenTwiceIsRefusedEvenWithTheSameValue) {
  const auto parsed = table().parse({{"sites", "5"}, {"sites", 5, false}});
  ASSERT_FALSE(parsed);
  EXPECT_EQ(parsed.error().code, ErrorCode::kBadParameter);
}

TEST(Parameters, JsonValuesMustHaveTheirOwnType) {
  EXPECT_EQ(table().parse({{"sites", 7, false}})->fracture.sites, 7u);
  const std::vector<nlohmann::json> wrong = {nlohmann::json("7"),        nlohmann::json(7.0),
                                             nlohmann::json(true),       nlohmann::json(-7),
                                             nlohmann::json::array({7}), nlohmann::json()};
  for (const nlohmann::json& value : wrong) EXPECT_FALSE(table().parse({{"sites", value, false}})) << value;
}

TEST(Parameters, FormatsThatAreOffAreUnknownUntilEnabled) {
  EXPECT_EQ(parse_text("format", "blend").error().code, ErrorCode::kUnknownFormat);
  EXPECT_EQ(parse_text("format", "exe").error().code, ErrorCode::kUnknownFormat);
  EXPECT_EQ(parse_text("format", "obj")->format, MeshFormat::kObj);
  EXPECT_EQ(parse_text("format", "STL")->format, MeshFormat::kStl);
  FormatSet with_blend;
  with_blend.enable(MeshFormat::kBlend);
  EXPECT_EQ(ParameterTable(10, with_blend).parse({{"format", "blend"}})->format, MeshFormat::kBlend);
}

TEST(Parameters, LevelsKeepToTheMostSites) {
  const ParameterTable small(1000, FormatSet());
  EXPECT_TRUE(small.parse({{"levels", "10,1000"}}));
  EXPECT_FALSE(small.parse({{"levels", "10,1001"}}));
}

TEST(Parameters, ControlCharactersOfTheClientNeverReachTheDetail) {
  const auto parsed = parse_text("sites", std::string("a\r\n\x1b[31m\xff", 9));
  ASSERT_FALSE(parsed);
  for (const char c : parsed.error().detail) EXPECT_TRUE(c >= 0x20 && c < 0x7f);
}

TEST(Parameters, AColourIsHexInSrgbAndAText63BytesWithoutControlCharacters) {
  const auto color = parse_text("interior_color", "#ff0080");
  ASSERT_TRUE(color);
  EXPECT_EQ(color->interior.color->x, 1);
  EXPECT_EQ(color->interior.color->y, 0);
  EXPECT_NEAR(color->interior.color->z, 0.2158605, 1e-6);  // IEC 61966-2-1 of 128 / 255
  for (const char* bad : {"ff0080", "#ff008", "#ff00800", "#ff00gg", "red", ""})
    EXPECT_FALSE(parse_text("interior_color", bad)) << bad;
  EXPECT_TRUE(parse_text("interior_name", std::string(63, 'a')));
  for (const std::string& bad :
       {std::string(), std::string(64, 'a'), std::string("a\nb"), std::string("\xff")})
    EXPECT_FALSE(parse_text("interior_name", bad));
}

TEST(Parameters, AColorOfOnesOwnIsNotMixedUnlessOneSaysSo) {
  const auto mix = [](std::vector<RawParameter> given) {
    given.push_back({"material", "stone"});
    const auto parsed = table().parse(given);
    EXPECT_TRUE(parsed);
    return parsed->interior.mix;
  };
  EXPECT_TRUE(mix({}));
  EXPECT_FALSE(mix({{"interior_color", "#ff0080"}}));
  EXPECT_FALSE(mix({{"interior_material", "Rock"}}));
  EXPECT_EQ(mix({{"interior_mix", "0.25"}, {"interior_color", "#ff0080"}}), 0.25);
}

TEST(Parameters, MortarIsOfBricksAloneAndStaysWhateverTheCutsLookLike) {
  const auto off = table().parse({{"material", "brick"}});
  EXPECT_FALSE(std::get<BrickPattern>(off->fracture.pattern).mortar);
  EXPECT_FALSE(off->interior.mortar);
  EXPECT_FALSE(canonical_parameters(*off).contains("mortar"));
  const std::vector<RawParameter> given{
      {"interior_material", "Rock"}, {"material", "brick"}, {"mortar", "#ff0080"}};
  const auto on = table().parse(given);
  ASSERT_TRUE(on);
  EXPECT_TRUE(std::get<BrickPattern>(on->fracture.pattern).mortar);
  ASSERT_TRUE(on->interior.mortar);
  EXPECT_EQ(on->interior.mortar->x, 1);
  EXPECT_EQ(on->interior.mortar->y, 0);
  EXPECT_EQ(canonical_parameters(*on).at("mortar"), "#ff0080");
  EXPECT_NE(canonical_site_parameters(*on), canonical_site_parameters(*off));
  const nlohmann::json canonical = canonical_parameters(*on);
  std::vector<RawParameter> again;
  for (const auto& [name, value] : canonical.items()) again.push_back({name, value, false});
  EXPECT_EQ(table().parse(again)->interior.mortar, on->interior.mortar);
  EXPECT_FALSE(table().parse({{"material", "stone"}, {"mortar", "#ff0080"}}));
  EXPECT_FALSE(table().parse({{"material", "brick"}, {"mortar", "grey"}}));
}

TEST(Parameters, VectorsAreTextOrArrays) {
  const auto text = table().parse({{"pattern", "impact"}, {"impacts", "1,-2.5,1e-3;0,0,0"}});
  ASSERT_TRUE(text) << text.error().detail;
  const std::vector<Vec3d> expected{{1, -2.5, 1e-3}, {0, 0, 0}};
  EXPECT_EQ(std::get<ImpactPattern>(text->fracture.pattern).impacts, expected);
  const auto json =
      table().parse({{"pattern", "impact", false},
                     {"impacts", nlohmann::json::parse("[[1, -2.5, 1e-3], [0, 0, 0]]"), false}});
  ASSERT_TRUE(json);
  EXPECT_EQ(canonical_parameters(*json), canonical_parameters(*text));
  const auto one = table().parse({{"pattern", "impact"}, {"impacts", {1, 2, 3}, false}});
  ASSERT_TRUE(one);
  EXPECT_EQ(std::get<ImpactPattern>(one->fracture.pattern).impacts, (std::vector<Vec3d>{{1, 2, 3}}));
  const auto matrix = table().parse({{"stretch_matrix", "1,0,0;0,2,0;0,0,3"}});
  ASSERT_TRUE(matrix);
  EXPECT_EQ(matrix->fracture.anisotropy.matrix->rows[1], (Vec3d{0, 2, 0}));
}

TEST(Parameters, AnOffenderInsideAListIsPointedAt) {
  const auto pointer = [](const char* name, const char* json, const char* pattern) {
    const auto parsed = table().parse({{"pattern", pattern}, {name, nlohmann::json::parse(json), false}});
    return parsed ? std::string("accepted") : parsed.error().extra->at("errors")[0].value("pointer", "none");
  };
  EXPECT_EQ(pointer("points", "[[0, 0, 0], [1, null, 0]]", "points"), "/points/1/1");
  EXPECT_EQ(pointer("points", "[[0, 0, 0], [1, 2]]", "points"), "/points/1");
  EXPECT_EQ(pointer("points", "[[0, 0, 0], \"1,2,3\"]", "points"), "/points/1");
  EXPECT_EQ(pointer("points", "[]", "points"), "/points");
  EXPECT_EQ(pointer("impacts", "[0, 2e6, 0]", "impact"), "/impacts/1");
  EXPECT_EQ(pointer("axis", "[0, 0, 0]", "radial"), "/axis");
  EXPECT_EQ(pointer("cell", "[1, 0, 1]", "grid"), "/cell/1");
  EXPECT_EQ(pointer("normals", "[[1, 0, 0], [2, 0, 0]]", "slice"), "/normals");
  EXPECT_EQ(pointer("normals", "[[1,0,0],[0,1,0],[0,0,1],[1,1,1]]", "slice"), "/normals");
  EXPECT_EQ(pointer("stretch_matrix", "[[1, 2, 3], [2, 4, 6], [0, 0, 1]]", "uniform"), "/stretch_matrix");
  EXPECT_EQ(pointer("stretch_matrix", "[[1, 0, 0], [0, 1, 0]]", "uniform"), "/stretch_matrix");
  for (const char* bad : {"nan,0,0", "0,0", "0,0,0,0", "", "0,0,0;", "1;2;3", "inf,0,0", "0, 0,0"})
    EXPECT_FALSE(table().parse({{"pattern", "points"}, {"points", bad}})) << bad;
}

TEST(Parameters, BadPatternsAndMaterialsAreRefusedWithTheLegalOnes) {
  const auto detail = [](const std::vector<RawParameter>& given) {
    const auto parsed = table().parse(given);
    return parsed ? std::string("accepted") : parsed.error().detail;
  };
  EXPECT_NE(detail({{"material", "wodo"}}).find("glass, wood, concrete"), std::string::npos);
  EXPECT_NE(detail({{"pattern", "star"}}).find("uniform, points, impact"), std::string::npos);
  EXPECT_NE(detail({{"pattern", "impact"}, {"radius", "-1"}}).find("from 1e-06 to 1e+06"), std::string::npos);
  EXPECT_NE(detail({{"rings", "5"}}).find("belongs to the pattern radial"), std::string::npos);
  EXPECT_NE(detail({{"pattern", "points"}}).find("needs 'points'"), std::string::npos);
  EXPECT_NE(detail({{"pattern", "points"}, {"points", "0,0,0"}, {"sites", "5"}}).find("'sites' belongs"),
            std::string::npos);
  EXPECT_NE(detail({{"stretch_matrix", "1,0,0;0,1,0;0,0,1"}, {"stretch", "2"}}).find("both given"),
            std::string::npos);
}

TEST(Parameters, AMaterialIsAPresetThatGivenParametersOverride) {
  for (const MaterialPreset& preset : material_presets()) {
    SCOPED_TRACE(preset.name);
    const auto parsed = table().parse({{"friction", "0.9"}, {"material", preset.name}});
    ASSERT_TRUE(parsed) << parsed.error().detail;
    EXPECT_EQ(parsed->physical.friction, 0.9);
    EXPECT_EQ(parsed->physical.density, preset.physical.density);
    EXPECT_EQ(parsed->physical.bond_strength, preset.physical.bond_strength);
    EXPECT_EQ(parsed->fracture.pattern, preset.pattern);
    EXPECT_EQ(parsed->interior_color, preset.look.color);
    EXPECT_TRUE(parsed->interior.color);
    // Its canonical form means the same.
    const nlohmann::json canonical = canonical_parameters(*parsed);
    std::vector<RawParameter> again;
    for (const auto& [name, value] : canonical.items()) again.push_back({name, value, false});
    const auto reparsed = table().parse(again);
    ASSERT_TRUE(reparsed) << reparsed.error().detail;
    EXPECT_EQ(canonical_parameters(*reparsed), canonical);
  }
  const auto bedded = table().parse({{"material", "sandstone"}});
  ASSERT_TRUE(bedded);
  EXPECT_EQ(bedded->fracture.anisotropy.grain, (Vec3d{0, 1, 0}));
  const auto by_part = table().parse({{"material", "sandstone"}, {"grain_of", "part"}});
  ASSERT_TRUE(by_part) << by_part.error().detail;
  EXPECT_EQ(by_part->fracture.anisotropy, (Anisotropy{.stretch = 0.5, .grain_of = GrainOf::kPart}));
  const auto other = table().parse({{"material", "cast_iron"}, {"pattern", "radial"}, {"spokes", "20"}});
  ASSERT_TRUE(other) << other.error().detail;
  EXPECT_EQ(other->physical.density, 7200);
  EXPECT_EQ(other->fracture.lloyd, 0u) << "relaxation belongs to the preset's own pattern";
  EXPECT_EQ(std::get<RadialPattern>(other->fracture.pattern).spokes, 20u);
}

TEST(Parameters, ChunksOfSeveralCellsGoWithThePatternsThatKnowThem) {
  const auto stone = table().parse({{"material", "stone"}});
  ASSERT_TRUE(stone);
  EXPECT_GT(stone->fracture.aggregation.cells, 1u);
  EXPECT_EQ(canonical_parameters(*stone).at("size_spread"), stone->fracture.aggregation.spread);
  EXPECT_EQ(canonical_parameters(*stone).at("max_hulls"), 4);
  EXPECT_FALSE(canonical_parameters(*parse_text("sites", "80")).contains("size_spread")) << "of single cells";
  const auto single = table().parse({{"material", "stone"}, {"cells_per_fragment", "1"}});
  ASSERT_TRUE(single);
  EXPECT_EQ(canonical_parameters(*single).at("cells_per_fragment"), 1) << "so that it can be sent again";
  const auto hit = table().parse({{"material", "stone"}, {"pattern", "impact"}});
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->fracture.aggregation, stone->fracture.aggregation);
  const auto panes = table().parse({{"material", "stone"}, {"pattern", "radial"}});
  ASSERT_TRUE(panes);
  EXPECT_EQ(panes->fracture.aggregation, Aggregation{});
  EXPECT_FALSE(table().parse({{"pattern", "grid"}, {"cells_per_fragment", "4"}}));
  EXPECT_FALSE(table().parse({{"cells_per_fragment", "65"}}));
  EXPECT_FALSE(table().parse({{"size_spread", "2.1"}}));
  const auto paper = table().parse({{"material", "stone"}, {"dual", "barycenter"}});
  ASSERT_TRUE(paper);
  EXPECT_EQ(cells_per_fragment(paper->fracture), 1u);
}

TEST(Parameters, OnlyWhatDecidesTheSitesIsInTheirKey) {
  const auto key = [](const std::vector<RawParameter>& given) {
    return canonical_site_parameters(*table().parse(given)).dump();
  };
  const std::string plain = key({});
  EXPECT_EQ(key({{"density", "5"}, {"pivot", "source"}, {"repair", "strict"}, {"dual", "barycenter"}}),
            plain);
  EXPECT_EQ(key({{"material", "wood"}}), key({{"stretch", "8"}, {"grain_of", "part"}, {"density", "3"}}));
  EXPECT_NE(key({{"pattern", "impact"}}), plain);
  EXPECT_NE(key({{"seed", "2"}}), plain);
  EXPECT_NE(key({{"lloyd", "1"}}), plain);
  EXPECT_NE(key({{"pattern", "impact"}, {"impacts", "0,0,0"}}),
            key({{"pattern", "impact"}, {"impacts", "0,0,1"}}));
}

TEST(Parameters, TheCatalogueDescribesEveryPatternAndMaterial) {
  const nlohmann::json catalogue = table().patterns_to_json();
  ASSERT_EQ(catalogue.at("patterns").size(), std::variant_size_v<SitePattern>);
  std::set<std::string> named;
  for (const auto& pattern : catalogue.at("patterns"))
    for (const auto& parameter : pattern.at("parameters")) {
      EXPECT_FALSE(parameter.at("description").get<std::string>().empty());
      EXPECT_TRUE(parameter.contains("type"));
      named.insert(parameter.at("name"));
    }
  for (const auto& parameter : catalogue.at("parameters")) named.insert(parameter.at("name"));
  std::set<std::string> of_mesh;
  for (const auto& parameter : catalogue.at("mesh_parameters")) of_mesh.insert(parameter.at("name"));
  for (const ParameterSpec& spec : table().specs()) {
    EXPECT_EQ(named.count(spec.name), spec.decides == Decides::kSolid ? 0u : 1u) << spec.name;
    EXPECT_EQ(of_mesh.count(spec.name), spec.decides == Decides::kSolid ? 1u : 0u) << spec.name;
  }
  ASSERT_EQ(catalogue.at("materials").size(), 13u);
  for (const auto& material : catalogue.at("materials")) {
    std::vector<RawParameter> given;
    for (const auto& [name, value] : material.at("parameters").items()) given.push_back({name, value, false});
    const auto spelled = table().parse(given),
               named_only = table().parse({{"material", material.at("name"), false}});
    ASSERT_TRUE(spelled) << spelled.error().detail;
    EXPECT_EQ(spelled->fracture.pattern, named_only->fracture.pattern);
    EXPECT_EQ(spelled->physical, named_only->physical);
    EXPECT_EQ(spelled->fracture.roughness, named_only->fracture.roughness);
    EXPECT_EQ(spelled->interior, named_only->interior);
    EXPECT_TRUE(named_only->exterior.any());
    EXPECT_EQ(spelled->hollow, named_only->hollow);
    EXPECT_EQ(canonical_site_parameters(*spelled), canonical_site_parameters(*named_only));
    for (const char* said : {"description", "source", "use", "mechanics"})
      EXPECT_GE(material.at(said).get<std::string>().size(), 10u) << said;
    EXPECT_GE(material.at("cost").get<double>(), 1);
  }
}

TEST(Parameters, WhatIsClearHasClearCuts) {
  for (const MaterialPreset& preset : material_presets()) {
    const std::string name = preset.name;
    const auto parsed = table().parse({{"material", name, false}});
    ASSERT_TRUE(parsed);
    const bool is_clear = name == "glass" || name == "ice" || name == "crystal";
    EXPECT_EQ(parsed->interior.opacity.value_or(1) < 1, is_clear) << name;
  }
}

TEST(Parameters, AHitOnAMaterialAsksForThePatternOfHits) {
  const std::string hit = "0.1,0.2,0.3";
  for (const MaterialPreset& preset : material_presets()) {
    SCOPED_TRACE(preset.name);
    const auto asked = table().parse({{"material", preset.name, false}, {"impacts", hit, true}});
    ASSERT_TRUE(asked) << asked.error().detail;
    const bool knows_hits = std::holds_alternative<ImpactPattern>(asked->fracture.pattern) ||
                            asked->fracture.pattern.index() == preset.pattern.index();
    EXPECT_TRUE(knows_hits);
    EXPECT_EQ(asked->fracture.aggregation, preset.aggregation) << "all else is the material's";
    EXPECT_EQ(asked->fracture.roughness, preset.roughness);
    // Its canonical form says the same.
    std::vector<RawParameter> again;
    const nlohmann::json form = canonical_parameters(*asked);
    for (const auto& [name, value] : form.items()) again.push_back({name, value, false});
    const auto same = table().parse(again);
    ASSERT_TRUE(same) << same.error().detail;
    EXPECT_EQ(canonical_parameters(*same), canonical_parameters(*asked));
  }
  EXPECT_FALSE(table().parse({{"impacts", hit, true}})) << "no material asks for it";
  EXPECT_FALSE(
      table().parse({{"material", "stone", false}, {"pattern", "uniform", false}, {"impacts", hit, true}}));
}

TEST(Parameters, ANumberOfFragmentsDecidesTheCellsWhereNobodyElseDoes) {
  const auto alone = table().parse({{"fragments", "80"}, {"pattern", "impact"}});
  ASSERT_TRUE(alone);
  EXPECT_EQ(alone->fracture.sites, 80u);
  EXPECT_EQ(alone->fracture.size.fragments, 80u);
  const auto both = table().parse({{"fragments", "80"}, {"sites", "400"}});
  ASSERT_TRUE(both);
  EXPECT_EQ(both->fracture.sites, 400u);
  EXPECT_FALSE(canonical_parameters(*parse_text("sites", "80")).contains("fragments"));
  EXPECT_TRUE(table().parse({{"fragments", "0"}, {"levels", "5,20"}})) << "0 is not given";
  for (const auto& [name, value] : {std::pair{"levels", "5,20"}, {"dual", "barycenter"}}) {
    const auto refused = table().parse({{"fragments", "20"}, {name, value}});
    ASSERT_FALSE(refused) << name;
    EXPECT_EQ(refused.error().pointer, "fragments") << name;
  }
}

TEST(Parameters, AMaterialWithoutALimitOfSizeCanBeSentAgain) {
  const auto free = table().parse({{"material", "stone"}, {"min_of_mean", "0"}});
  ASSERT_TRUE(free);
  EXPECT_EQ(canonical_parameters(*free).at("min_of_mean"), 0.0);
  EXPECT_EQ(canonical_parameters(*table().parse({{"material", "stone"}})).at("min_of_mean"), kLeastOfMean);
  EXPECT_FALSE(canonical_parameters(*parse_text("sites", "80")).contains("min_of_mean"));
}

TEST(Parameters, RoughnessIsCheckedAndShownWhereItMatters) {
  const auto spelled = parse_text("rough_amplitude", "0.02");
  ASSERT_TRUE(spelled);
  EXPECT_EQ(spelled->fracture.roughness, (Roughness{0.02, 5, 2}));
  EXPECT_EQ(canonical_parameters(*spelled).at("rough_octaves"), 2);
  EXPECT_FALSE(canonical_parameters(*parse_text("rough_octaves", "4")).contains("rough_octaves"))
      << "of flat cuts";
  const auto stone = table().parse({{"material", "stone"}}),
             flat = table().parse({{"material", "stone"}, {"rough_amplitude", "0"}});
  EXPECT_GT(stone->fracture.roughness.amplitude, 0);
  EXPECT_EQ(canonical_parameters(*flat).at("rough_amplitude"), 0.0) << "so that it can be sent again";
  EXPECT_FALSE(canonical_parameters(*flat).contains("rough_frequency"));
  for (const auto& [name, bad] :
       std::vector<std::pair<std::string, nlohmann::json>>{{"rough_amplitude", -0.1},
                                                           {"rough_amplitude", 0.3},
                                                           {"rough_amplitude", "much"},
                                                           {"rough_frequency", 0},
                                                           {"rough_frequency", 101},
                                                           {"rough_octaves", 0},
                                                           {"rough_octaves", 7},
                                                           {"rough_octaves", 1.5}}) {
    const auto refused = table().parse({{name, bad, false}});
    ASSERT_FALSE(refused) << name << " " << bad;
    EXPECT_EQ(refused.error().code, ErrorCode::kBadParameter);
    EXPECT_EQ(refused.error().extra->at("errors").at(0).at("pointer"), "/" + name);
  }
}

TEST(Parameters, OneSpellingForEveryWayToAsk) {
  const auto by_text = table().parse({{"seed", "3"}, {"sites", "50"}});
  const auto by_json = table().parse({{"seed", 3, false}});
  EXPECT_EQ(canonical_parameters(*by_text).dump(), canonical_parameters(*by_json).dump());
  EXPECT_EQ(
      canonical_parameters(*by_text).dump(),
      R"({"bond_strength":1000000.0,"density":1000.0,"dual":"circumcenter","friction":0.6,"interior":"auto",)"
      R"("interior_shade":0.8,"lloyd":0,"pattern":"uniform",)"
      R"("physics":"khr","pivot":"center_of_mass","repair":"fill","restitution":0.1,"seed":3,"sites":50,"stretch":1.0,)"
      R"("thickness":0.0,"ue_collision":"none","unit":"file","up":"file","weld_tolerance":1e-06})");
}

TEST(Parameters, TheOutsideIsOfAMaterialOnlyWhereThereIsOne) {
  const auto refused = table().parse({{"exterior", "material"}});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().pointer, "exterior");
  EXPECT_NE(refused.error().detail.find("say which"), std::string::npos);
  EXPECT_TRUE(table().parse({{"exterior", "material"}, {"of", "sha256:" + std::string(64, 'a')}}))
      << "the earlier answer has one";
  EXPECT_FALSE(table().parse({{"exterior", "auto"}})->exterior.any());
  EXPECT_FALSE(canonical_parameters(*table().parse({{"exterior", "asset"}})).contains("exterior"));

  const auto glass = table().parse({{"material", "glass"}, {"exterior", "material"}});
  ASSERT_TRUE(glass);
  EXPECT_EQ(glass->exterior.choice, ExteriorChoice::kMaterial);
  EXPECT_EQ(glass->exterior.opacity, glass->interior.opacity);
  EXPECT_EQ(canonical_parameters(*glass).at("exterior"), "material");
  const auto pottery = table().parse({{"material", "ceramic"}});
  EXPECT_EQ(pottery->exterior.choice, ExteriorChoice::kAuto);
  EXPECT_LT(*pottery->exterior.roughness, *pottery->interior.roughness) << "glazed outside, biscuit inside";
}

TEST(Parameters, WallsOfAMaterialAreItsDefault) {
  const auto hollow = [](const std::vector<RawParameter>& given) { return table().parse(given)->hollow; };
  EXPECT_GT(hollow({{"material", "glass"}}).fraction, 0);
  EXPECT_GT(hollow({{"material", "glass"}}).least_ball, 0);
  EXPECT_FALSE(hollow({{"material", "stone"}}).any());
  EXPECT_FALSE(hollow({{"material", "glass"}, {"shell", "0"}}).any());
  EXPECT_EQ(hollow({{"material", "glass"}, {"shell", "0.01"}}), HollowOptions{.thickness = 0.01});
  EXPECT_EQ(hollow({{"material", "ceramic"}, {"shell_fraction", "0.1"}}), HollowOptions{.fraction = 0.1});
  EXPECT_FALSE(table().parse({{"shell_fraction", "0.1"}, {"shell_ball", "0.01"}}))
      << "takes too fine a lattice";
}

TEST(Parameters, WallsAreTheSameWhenTheirCanonicalFormIsSentAgain) {
  for (const std::vector<RawParameter>& given :
       std::vector<std::vector<RawParameter>>{{{"material", "glass"}},
                                              {{"material", "glass"}, {"shell", "0"}},
                                              {{"material", "ceramic"}, {"shell", "0.02"}},
                                              {{"material", "ceramic"}, {"shell_fraction", "0"}},
                                              {{"material", "ceramic"}, {"shell_fraction", "0.1"}},
                                              {{"shell_fraction", "0.1"}, {"shell_ball", "0.5"}}}) {
    const auto first = table().parse(given);
    ASSERT_TRUE(first);
    const nlohmann::json canonical = canonical_parameters(*first);
    std::vector<RawParameter> again;
    for (const auto& [name, value] : canonical.items()) again.push_back({name, value, false});
    const auto second = table().parse(again);
    ASSERT_TRUE(second) << second.error().detail;
    EXPECT_EQ(second->hollow, first->hollow) << canonical;
  }
  EXPECT_EQ(canonical_solid_parameters(*table().parse({{"material", "glass"}, {"shell", "0"}})),
            canonical_solid_parameters(*table().parse({})))
      << "one preparation for all that have no walls";
}

}  // namespace
}  // namespace fracture
