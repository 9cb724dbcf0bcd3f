#include "common/parameters/parameters.hpp"

#include <gtest/gtest.h>

#include "tests/parameters/parse.hpp"

namespace fracture {
namespace {

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
    EXPECT_NE(parsed.error().detail.find("from 1 to 100,000"), std::string::npos) << parsed.error().detail;
    EXPECT_NE(parsed.error().detail.find(std::string("'") + bad + "'"), std::string::npos)
        << parsed.error().detail;
  }
}

TEST(Parameters, NumbersAreDecimalsInTheirRange) {
  EXPECT_EQ(parse_text("thickness", "0.02")->solid.thickness, 0.02);
  EXPECT_EQ(parse_text("sheets", "whole")->solid.sheets, SheetsMode::kWhole);
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
    EXPECT_NE(parsed.error().detail.find("from 0 to 1,000"), std::string::npos) << parsed.error().detail;
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
  EXPECT_EQ(pointer("impacts", "[0, 2e8, 0]", "impact"), "/impacts/1");
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
  EXPECT_NE(detail({{"pattern", "impact"}, {"radius", "-1"}}).find("from 1e-06 to 1,000,000"),
            std::string::npos);
  EXPECT_NE(detail({{"anchor_plane", "1"}}).find("must be 2 vectors of three numbers from -100,000,000 to"),
            std::string::npos);
  EXPECT_NE(detail({{"rings", "5"}}).find("belongs to the radial pattern"), std::string::npos);
  EXPECT_NE(detail({{"pattern", "points"}}).find("needs 'points'"), std::string::npos);
  EXPECT_NE(detail({{"pattern", "points"}, {"points", "0,0,0"}, {"sites", "5"}}).find("'sites' belongs"),
            std::string::npos);
  EXPECT_NE(detail({{"stretch_matrix", "1,0,0;0,1,0;0,0,1"}, {"stretch", "2"}}).find("both given"),
            std::string::npos);
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

TEST(Parameters, TheUnbrokenMeshIsAskedForAsTextOrAsABoolean) {
  EXPECT_FALSE(table().parse({})->fracture.intact);
  EXPECT_FALSE(canonical_parameters(*table().parse({{"intact", "false"}})).contains("intact"));
  for (const nlohmann::json& yes : {nlohmann::json("true"), nlohmann::json(true)}) {
    const auto parsed = table().parse({{"intact", yes, false}});
    ASSERT_TRUE(parsed) << yes;
    EXPECT_TRUE(parsed->fracture.intact);
    EXPECT_EQ(canonical_parameters(*parsed).at("intact"), "true") << "so that it can be sent again";
  }
  EXPECT_FALSE(table().parse({{"intact", "yes"}}));
}

TEST(Sheets, AThicknessNeedsSolidSheetsOrNothing) {
  const auto parse = [](const char* sheets) {
    return table().parse({{"sheets", sheets, true}, {"thickness", "0.1", true}});
  };
  EXPECT_TRUE(parse("solid"));
  for (const char* other : {"attach", "whole", "drop"}) {
    const auto refused = parse(other);
    ASSERT_FALSE(refused) << other;
    EXPECT_EQ(refused.error().pointer, "thickness");
    EXPECT_NE(refused.error().detail.find("sheets=solid"), std::string::npos) << refused.error().detail;
  }
  EXPECT_TRUE(table().parse({{"sheets", "drop", true}, {"thickness", "0", true}}));
}

}  // namespace
}  // namespace fracture
