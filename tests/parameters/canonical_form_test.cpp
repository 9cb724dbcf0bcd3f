// The canonical form of parameters: what decides the solid, the sites and the answer, in one spelling.
#include <gtest/gtest.h>

#include "common/parameters/parameters.hpp"
#include "tests/parameters/parse.hpp"

namespace fracture {
namespace {

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

TEST(Parameters, BarycentricCellsHaveSitesOfTheirOwnOnlyWithAKeptRegionOrSpokes) {
  const auto key = [](std::vector<RawParameter> given, const char* dual) {
    given.push_back({"dual", dual});
    return canonical_site_parameters(*table().parse(given)).dump();
  };
  for (const std::vector<RawParameter>& given :
       {std::vector<RawParameter>{{"keep_box", "0,0,0;1,1,1"}}, {{"pattern", "radial"}}})
    EXPECT_NE(key(given, "barycenter"), key(given, "circumcenter"));
  EXPECT_EQ(key({}, "barycenter"), key({}, "circumcenter"));
}

TEST(Parameters, TheGapOfContactsDecidesTheSolidAndTheirStrengthTheAnswer) {
  const auto parsed = table().parse({{"contact_gap", "0.02"}, {"contact_strength", "0.5"}});
  ASSERT_TRUE(parsed);
  EXPECT_EQ(parsed->solid.contact_gap, 0.02);
  EXPECT_EQ(parsed->fracture.contact_strength, 0.5);
  EXPECT_EQ(canonical_solid_parameters(*parsed)["contact_gap"], 0.02);
  EXPECT_FALSE(canonical_solid_parameters(*parsed).contains("contact_strength"));
  EXPECT_EQ(canonical_site_parameters(*parsed), canonical_site_parameters(*table().parse({})));
  EXPECT_EQ(canonical_parameters(*parsed)["contact_strength"], 0.5);
  EXPECT_EQ(canonical_parameters(*table().parse({{"contact_strength", "1"}})),
            canonical_parameters(*table().parse({})));
  EXPECT_FALSE(table().parse({{"contact_gap", "-1"}}));
}

TEST(Parameters, OneSpellingForEveryWayToAsk) {
  const auto by_text = table().parse({{"seed", "3"}, {"sites", "50"}});
  const auto by_json = table().parse({{"seed", 3, false}});
  EXPECT_EQ(canonical_parameters(*by_text).dump(), canonical_parameters(*by_json).dump());
  EXPECT_EQ(
      canonical_parameters(*by_text).dump(),
      R"({"bond_strength":1000000.0,"density":1000.0,"dual":"circumcenter","friction":0.6,"hull_excess":1.5,)"
      R"("interior":"auto","interior_shade":0.8,"lloyd":0,"max_hulls":4,"pattern":"uniform",)"
      R"("physics":"khr","pivot":"center_of_mass","repair":"fill","restitution":0.1,"seed":3,"sites":50,"stretch":1.0,)"
      R"("thickness":0.0,"ue_collision":"none","unit":"file","up":"file","weld_tolerance":1e-06})");
}

TEST(Sheets, AreInTheCanonicalFormOnlyIfTheyAreNotTheDefault) {
  EXPECT_FALSE(canonical_solid_parameters(*parse_text("sheets", "attach")).contains("sheets"));
  EXPECT_EQ(canonical_solid_parameters(*parse_text("sheets", "drop"))["sheets"], "drop");
  EXPECT_FALSE(canonical_solid_parameters(*parse_text("thickness", "0.1")).contains("sheets"));
  EXPECT_EQ(canonical_solid_parameters(*parse_text("sheets", "solid"))["sheets"], "solid");
}

TEST(Proxies, AreInTheCanonicalFormOnlyIfTheyAreNotTheDefault) {
  EXPECT_EQ(table().parse({})->proxies, Proxies::kHulls);
  EXPECT_FALSE(canonical_solid_parameters(*parse_text("proxies", "hulls")).contains("proxies"));
  EXPECT_EQ(canonical_solid_parameters(*parse_text("proxies", "geometry"))["proxies"], "geometry");
  EXPECT_FALSE(parse_text("proxies", "none"));
}

}  // namespace
}  // namespace fracture
