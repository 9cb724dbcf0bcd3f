// The parameters that a material decides, and those that may still be given with it.
#include <gtest/gtest.h>

#include <set>

#include "common/hits/delta.hpp"
#include "tests/parameters/parse.hpp"

namespace fracture {
namespace {

TEST(MaterialParameters, AColorOfOnesOwnIsNotMixedUnlessOneSaysSo) {
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

// Hits on whole parts make Voronoi cells, which may be grouped; the answer before the first hit has barycentric cells.
TEST(MaterialParameters, BarycentricCellsBeforeAHitAreNotGrouped) {
  const std::vector<RawParameter> before{{"material", "stone"}, {"dual", "barycenter"}};
  std::vector<RawParameter> given = before;
  for (const RawParameter& more :
       {RawParameter{"local_point", "0,0,0"}, {"local_radius", "0.2"}, {"delta", "stated"}})
    given.push_back(more);
  const auto hit = table().parse(given), whole = table().parse(before);
  ASSERT_TRUE(hit);
  ASSERT_TRUE(whole);
  EXPECT_GT(hit->fracture.aggregation.cells, 1u);
  EXPECT_EQ(before_hits(hit->fracture, 1).aggregation, Aggregation{});
  const char* const name = "cells_per_fragment";
  EXPECT_TRUE(canonical_base_parameters(*hit, true).contains(name));
  EXPECT_EQ(canonical_base_parameters(*hit, false).contains(name),
            canonical_base_parameters(*whole, false).contains(name));
}

TEST(MaterialParameters, MortarIsOfBricksAloneAndStaysWhateverTheCutsLookLike) {
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

TEST(MaterialParameters, AMaterialIsAPresetThatGivenParametersOverride) {
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

TEST(MaterialParameters, ChunksOfSeveralCellsGoWithThePatternsThatKnowThem) {
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

TEST(MaterialParameters, TheCatalogueDescribesEveryPatternAndMaterial) {
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

TEST(MaterialParameters, WhatIsClearHasClearCuts) {
  for (const MaterialPreset& preset : material_presets()) {
    const std::string name = preset.name;
    const auto parsed = table().parse({{"material", name, false}});
    ASSERT_TRUE(parsed);
    const bool is_clear = name == "glass" || name == "ice" || name == "crystal";
    EXPECT_EQ(parsed->interior.opacity.value_or(1) < 1, is_clear) << name;
  }
}

TEST(MaterialParameters, AHitOnAMaterialAsksForThePatternOfHits) {
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
  const auto alone = table().parse({{"impacts", hit, true}});
  ASSERT_TRUE(alone) << alone.error().detail;
  EXPECT_EQ(alone->fracture.pattern, SitePattern(ImpactPattern{.impacts = {{0.1, 0.2, 0.3}}}));
  EXPECT_EQ(canonical_parameters(*alone),
            canonical_parameters(*table().parse({{"pattern", "impact", false}, {"impacts", hit, true}})));
  EXPECT_FALSE(table().parse({{"pattern", "uniform", false}, {"impacts", hit, true}}));
  EXPECT_FALSE(
      table().parse({{"material", "stone", false}, {"pattern", "uniform", false}, {"impacts", hit, true}}));
}

TEST(MaterialParameters, AMaterialWithoutALimitOfSizeCanBeSentAgain) {
  const auto free = table().parse({{"material", "stone"}, {"min_of_mean", "0"}});
  ASSERT_TRUE(free);
  EXPECT_EQ(canonical_parameters(*free).at("min_of_mean"), 0.0);
  EXPECT_EQ(canonical_parameters(*table().parse({{"material", "stone"}})).at("min_of_mean"), kLeastOfMean);
  EXPECT_FALSE(canonical_parameters(*parse_text("sites", "80")).contains("min_of_mean"));
}

TEST(MaterialParameters, RoughnessIsCheckedAndShownWhereItMatters) {
  const auto spelled = parse_text("rough_amplitude", "0.02");
  ASSERT_TRUE(spelled);
  EXPECT_EQ(spelled->fracture.roughness, (Roughness{0.02, 5, 2}));
  EXPECT_EQ(canonical_parameters(*spelled).at("rough_octaves"), 2);
  EXPECT_EQ(canonical_parameters(*parse_text("rough_octaves", "4")).at("rough_octaves"), 4)
      << "the report says that it had no effect";
  EXPECT_FALSE(canonical_site_parameters(*parse_text("rough_octaves", "4")).contains("rough_octaves"));
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

TEST(MaterialParameters, TheOutsideIsOfAMaterialOnlyWhereThereIsOne) {
  const auto refused = table().parse({{"exterior", "material"}});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().pointer, "exterior");
  EXPECT_NE(refused.error().detail.find("no 'material' is given"), std::string::npos);
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

TEST(MaterialParameters, WallsOfAMaterialAreItsDefault) {
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

TEST(MaterialParameters, WallsAreTheSameWhenTheirCanonicalFormIsSentAgain) {
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
