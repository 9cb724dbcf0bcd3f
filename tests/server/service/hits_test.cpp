// Hits on earlier answers, with the real engine: the meaning of `of`, deltas, and that a kept answer saves
// time but changes nothing.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "tests/server/service/hits_fixture.hpp"

namespace fracture::test {
namespace {

/// Returns whether the name of some material begins with `name`.
bool has_material(const FractureResult& glb, std::string_view name) {
  const json document = document_of(glb);
  return std::any_of(document.at("materials").begin(), document.at("materials").end(),
                     [&](const json& material) { return material.value("name", "").starts_with(name); });
}

TEST_F(HitsTest, AMaterialThatMakesWallsDoesSoInTheServer) {
  const auto volume = [](const FractureAnswer& answer) {
    return figures_of(*answer.result).at("certificate").at("volume_out").get<double>();
  };
  const FractureAnswer walls = ask({{"material", "ceramic"}, {"sites", 8}}),
                       solid = ask({{"material", "ceramic"}, {"sites", 8}, {"shell", 0}});
  EXPECT_NEAR(volume(solid), 2, 1e-6);
  // The walls are at least 0.04 of the longest side thick, which is 0.08 m, all around the box of 2 x 1 x 1
  // m.
  EXPECT_LT(volume(walls), 1.2);
  EXPECT_GT(volume(walls), 2 - 1.84 * 0.84 * 0.84);
  EXPECT_TRUE(has_material(*walls.result, "Cavity"));
  EXPECT_FALSE(has_material(*solid.result, "Cavity"));
}

TEST_F(HitsTest, TheReliefOfCutsIsNotSentAgainWithADelta) {
  const FractureAnswer first = ask({{"sites", 30}, {"interior_detail", "stone"}});
  EXPECT_TRUE(document_of(*first.result).contains("images"));
  const FractureAnswer changed = ask({{"of", address(first)},
                                      {"local_point", {2, 0.5, 0.5}},
                                      {"local_radius", 0.3},
                                      {"local_sites", 8},
                                      {"delta", "only"}});
  EXPECT_FALSE(document_of(*changed.result).contains("images"));
}

// The groups of aggregates are part of the diagram, and depend on the size limits.
TEST_F(HitsTest, DiagramsOfAggregatesAreThoseOfTheirLimits) {
  const json plain = {{"sites", 20},         {"cells_per_fragment", 6}, {"local_point", {2, 0.5, 0.5}},
                      {"local_radius", 0.3}, {"local_sites", 8},        {"local_rest", "fractured"}};
  json limited = plain;
  limited["min_of_mean"] = 0.5;
  const FractureAnswer without = ask(plain), with = ask(limited);
  EXPECT_NE(without.result->file, with.result->file);
  FractureService fresh(config, test::engine_in_process());
  EXPECT_EQ(ask(fresh, mesh, limited)->result->file, with.result->file);
}

TEST_F(HitsTest, AnAddressStandsForItsParametersAndAKeptAnswerForAComputedOne) {
  const FractureAnswer first = ask({{"sites", 40}, {"seed", 7}, {"density", 500}});
  const FractureAnswer second = ask(
      {{"of", address(first)}, {"local_point", {2, 0.5, 0.5}}, {"local_radius", 0.3}, {"local_sites", 8}});
  EXPECT_EQ(second.diagram_cache, CacheOutcome::kMissStored) << "nobody kept the first answer";
  const FractureAnswer third =
      ask({{"of", address(second)}, {"local_point", {0, 0, 0}}, {"local_radius", 0.2}, {"local_sites", 5}});
  EXPECT_EQ(third.diagram_cache, CacheOutcome::kHit) << "the second answer was kept";

  const json parameters = figures_of(*third.result).at("parameters");
  EXPECT_EQ(parameters.at("local_point"), json::parse("[[2.0, 0.5, 0.5], [0.0, 0.0, 0.0]]"));
  EXPECT_EQ(parameters.at("local_radius"), json::parse("[0.3, 0.2]"));
  EXPECT_EQ(parameters.at("local_sites"), json::parse("[8, 5]"));
  EXPECT_EQ(parameters.at("local_rest"), "fractured");
  EXPECT_EQ(parameters.at("delta"), "stated");
  EXPECT_EQ(parameters.at("local_new"), 1);
  EXPECT_EQ(parameters.at("density"), 500);
  EXPECT_FALSE(parameters.contains("of"));

  // Computed from scratch with all parameters, by a server without any kept answer, and by a server without
  // room to keep any.
  FractureService fresh(config, test::engine_in_process());
  const auto cold = ask(fresh, mesh, parameters);
  ASSERT_TRUE(cold);
  EXPECT_EQ(cold->result->file, third.result->file);
  EXPECT_EQ(cold->result->key, third.result->key);
  config.diagram_cache_bytes = 0;
  FractureService forgetful(config, test::engine_in_process());
  EXPECT_EQ(ask(forgetful, mesh, parameters)->result->file, third.result->file);

  // A plain request with all hits has the same fragments in the same nodes.
  json plain = parameters;
  plain.erase("delta");
  plain.erase("local_new");
  const json with_delta = document_of(*third.result), without = document_of(*ask(plain).result);
  EXPECT_EQ(with_delta.at("meshes"), without.at("meshes"));
  EXPECT_EQ(with_delta.at("bufferViews"), without.at("bufferViews"));
  EXPECT_EQ(fragment_ids(*third.result), fragment_ids(*ask(plain).result));
}

TEST_F(HitsTest, ALookThatIsAskedForLaterIsThatLookAlone) {
  const FractureAnswer stone = ask({{"sites", 8}, {"material", "stone"}});
  const json mixed = figures_of(*stone.result).at("parameters");
  ASSERT_TRUE(mixed.contains("interior_mix"));
  const json red =
      figures_of(*ask({{"of", address(stone)}, {"interior_color", "#ff0000"}}).result).at("parameters");
  EXPECT_EQ(red.at("interior_color"), "#ff0000");
  EXPECT_FALSE(red.contains("interior_mix")) << "as without 'of'";
  const json rough =
      figures_of(*ask({{"of", address(stone)}, {"interior_roughness", 0.25}}).result).at("parameters");
  EXPECT_EQ(rough.at("interior_mix"), mixed.at("interior_mix")) << "nothing else changes";
}

TEST_F(HitsTest, AnAnswerCanBeKeptForItsFirstHit) {
  const FractureAnswer plain = ask({{"sites", 20}}), kept = ask({{"sites", 20}, {"delta", "stated"}});
  EXPECT_EQ(kept.diagram_cache, CacheOutcome::kHit);
  EXPECT_EQ(figures_of(*kept.result).at("delta"), json::parse(R"({"new": [], "changed": [], "gone": []})"));
  EXPECT_EQ(document_of(*kept.result).at("meshes"), document_of(*plain.result).at("meshes"));
  for (const FractureAnswer& of : {plain, kept})
    for (const char* delta : {"stated", "only"}) {
      const FractureAnswer after = ask({{"of", address(of)},
                                        {"local_point", {2, 0.5, 0.5}},
                                        {"local_radius", of.result == plain.result ? 0.3 : 0.2},
                                        {"delta", delta}});
      EXPECT_EQ(after.diagram_cache, CacheOutcome::kHit) << delta;
    }
}

TEST_F(HitsTest, TheDeltaIsTheDifferenceOfBothAnswers) {
  const FractureAnswer before = ask({{"sites", 60}});
  const json hit = {{"of", address(before)}, {"local_point", {2, 0.5, 0.5}}, {"local_radius", 0.3}};
  const FractureAnswer after = ask(hit);
  const json delta = figures_of(*after.result).at("delta");
  const std::set<std::uint64_t> was = fragment_ids(*before.result), is = fragment_ids(*after.result);
  std::set<std::uint64_t> expected = was;
  for (const std::uint64_t id : ids(delta, "gone")) EXPECT_EQ(expected.erase(id), 1u);
  for (const std::uint64_t id : ids(delta, "new")) EXPECT_TRUE(expected.insert(id).second);
  EXPECT_EQ(expected, is);
  EXPECT_GE(ids(delta, "new").size(), 20u);
  const std::size_t touched = ids(delta, "new").size() + ids(delta, "changed").size();
  EXPECT_LT(touched, is.size()) << "some of it is far from the hit";

  json only = hit;
  only["delta"] = "only";
  const FractureAnswer part = ask(only);
  std::set<std::uint64_t> named;
  for (const char* list : {"new", "changed"})
    for (const std::uint64_t id : ids(delta, list)) named.insert(id);
  EXPECT_EQ(fragment_ids(*part.result), named);
  const json figures = figures_of(*part.result), whole = figures_of(*after.result);
  EXPECT_EQ(figures.at("delta"), delta);
  EXPECT_EQ(figures.at("certificate"), whole.at("certificate"));
  // The bonds are those of the whole answer that touch a named fragment, compared by both ids.
  std::map<std::set<std::uint64_t>, double> bonds, expected_bonds;
  const auto collect = [&](const json& from, auto& into) {
    const json& b = from.at("bonds");
    for (std::size_t k = 0; k < b.at("a").size(); ++k) {
      const std::set<std::uint64_t> ends{b.at("a")[k], b.at("b")[k]};
      if (named.contains(*ends.begin()) || named.contains(*ends.rbegin())) into[ends] = b.at("area")[k];
    }
  };
  collect(figures, bonds);
  collect(whole, expected_bonds);
  EXPECT_EQ(bonds, expected_bonds);
  EXPECT_EQ(bonds.size(), figures.at("bonds").at("a").size());
  EXPECT_LT(part.result->file.size(), after.result->file.size());
}

TEST_F(HitsTest, AnchorsHoldWhatChangedAsTheyHoldItInTheWhole) {
  const FractureAnswer before =
      ask({{"sites", 60}, {"anchor_plane", {{0, 0.2, 0}, {0, 1, 0}}}, {"gravity", {0, -9.81, 0}}});
  json hit = {{"of", address(before)}, {"local_point", {2, 0.2, 0.5}}, {"local_radius", 0.3}};
  const auto anchored = [](const FractureAnswer& answer) {
    std::map<std::uint64_t, bool> by_id;
    const json document = document_of(*answer.result);
    for (const json& node : document.at("nodes"))
      if (const json own = node.value("extras", json::object()).value("fracture", json::object());
          own.contains("anchored"))
        by_id[own.at("id")] = own.at("anchored");
    return by_id;
  };
  const FractureAnswer after = ask(hit);
  hit["delta"] = "only";
  const FractureAnswer part = ask(hit);
  const auto whole = anchored(after), changed = anchored(part);
  ASSERT_LT(changed.size(), whole.size());
  std::set<bool> seen;
  for (const auto& [id, held] : changed) {
    EXPECT_EQ(held, whole.at(id)) << id;
    seen.insert(held);
  }
  EXPECT_EQ(seen.size(), 2u) << "the hit is at the edge of what is held";
  // The report's members on anchors and support describe all fragments, so a delta leaves them out.
  const json of_all = figures_of(*after.result).at("report"), of_part = figures_of(*part.result).at("report");
  for (const char* name : {"anchors", "support"}) {
    EXPECT_TRUE(of_all.contains(name)) << name;
    EXPECT_FALSE(of_part.contains(name)) << name;
  }
}

TEST_F(HitsTest, SeveralNewHitsAreComparedWithTheAnswerBeforeThemAll) {
  const FractureAnswer before = ask({{"sites", 30}});
  const FractureAnswer after = ask({{"of", address(before)},
                                    {"local_point", {{2, 0.5, 0.5}, {0, 0.5, 0.5}}},
                                    {"local_radius", {0.2, 0.3}},
                                    {"local_sites", 6}});
  const json figures = figures_of(*after.result);
  EXPECT_EQ(figures.at("parameters").at("local_new"), 2);
  EXPECT_EQ(figures.at("parameters").at("local_sites"), json::parse("[6, 6]"));
  const std::set<std::uint64_t> was = fragment_ids(*before.result);
  std::set<std::uint64_t> added;
  for (const std::uint64_t id : fragment_ids(*after.result))
    if (!was.contains(id)) added.insert(id);
  const auto named = ids(figures.at("delta"), "new");
  EXPECT_EQ(std::set<std::uint64_t>(named.begin(), named.end()), added);
}

TEST_F(HitsTest, AnAnswerMayBeAskedOtherThingsOfItsFragments) {
  const FractureAnswer first = ask({{"sites", 12}, {"mass", 5}});
  const std::uint64_t one = *fragment_ids(*first.result).begin();
  const FractureAnswer parts = ask({{"of", address(first)}, {"fragment", one}, {"fragment_sites", 4}});
  EXPECT_EQ(parts.result->file,
            ask({{"sites", 12}, {"mass", 5}, {"fragment", one}, {"fragment_sites", 4}}).result->file);
  EXPECT_EQ(ask({{"of", address(first)}, {"density", 9}}).result->file,
            ask({{"sites", 12}, {"density", 9}}).result->file);
  EXPECT_EQ(ask({{"of", address(first)}}).result, first.result);
  // Hits on parts of a fragment would have to be hits on that fragment.
  EXPECT_EQ(refused({{"of", address(parts)}, {"local_point", {0, 0, 0}}, {"local_radius", 1}}).pointer, "of");
}

TEST_F(HitsTest, TheFormatOfTheBodyMayBeGivenWithAnAddress) {
  const FractureAnswer first = ask({{"sites", 8}});
  json hit = {{"of", address(first)}, {"local_point", {2, 0, 0}}, {"local_radius", 0.5}};
  const FractureAnswer plain = ask(hit);
  hit["format"] = "obj";
  EXPECT_EQ(ask(hit).result->key, plain.result->key);
  EXPECT_EQ(ask({{"of", address(first)}, {"format", "obj"}}).result->key, first.result->key);
  hit["unit"] = "cm";
  const Error error = refused(hit);
  EXPECT_EQ(error.pointer, "unit");
  EXPECT_NE(error.detail.find("determined by the earlier answer"), std::string::npos) << error.detail;
}

TEST_F(HitsTest, WhatCannotBeMeantIsRefusedByName) {
  const FractureAnswer plain = ask({{"sites", 8}});
  const FractureAnswer whole =
      ask({{"sites", 8}, {"local_point", {2, 0, 0}}, {"local_radius", 0.5}, {"local_sites", 4}});
  const std::string of = address(plain);
  const json hit = {{"local_point", {2, 0, 0}}, {"local_radius", 0.5}};
  const auto with = [](json object, const json& more) {
    object.update(more);
    return object;
  };
  const std::string unknown = of.substr(0, of.size() - 16) + "0123456789abcdef";
  for (const auto& [given, name] : std::vector<std::pair<json, std::string>>{
           {{{"of", "nonsense"}}, "of"},
           {{{"of", "/fractures/sha256:12"}}, "of"},
           {{{"of", "/jobs/" + of.substr(11)}}, "of"},
           {{{"of", 5}}, "of"},
           {{{"of", of}, {"sites", 9}}, "sites"},
           {{{"of", of}, {"seed", 2}}, "seed"},
           {{{"of", of}, {"material", "glass"}}, "material"},
           {{{"of", of}, {"repair", "strict"}}, "repair"},
           {{{"of", of}, {"local_point", {2, 0, 0}}}, "local_radius"},
           {{{"of", of}, {"delta", "only"}}, "delta"},
           {{{"of", address(whole)}, {"delta", "stated"}}, "delta"},
           {with(hit, {{"of", of}, {"pivot", "source"}}), "pivot"},
           {with(hit, {{"of", of}, {"rough_amplitude", 0.1}, {"delta", "only"}}), "rough_amplitude"},
           {with(hit, {{"of", of}, {"local_new", 1}}), "local_new"},
           {with(hit, {{"of", of}, {"local_rest", "whole"}}), "local_rest"},
           {with(hit, {{"of", address(whole)}, {"local_rest", "fractured"}}), "local_rest"},
           {with(hit, {{"of", of}, {"local_radius", -1}}), "local_radius"},
           {with(hit, {{"of", of}, {"local_radius", {1, 2}}}), "local_radius"},
           {with(hit, {{"of", of}, {"local_sites", {1, 2, 3}}}), "local_sites"},
           {with(hit, {{"local_point", {{0, 0, 0}, {1, 0, 0}}}, {"local_sites", 6000}}), "local_sites"},
           {with(hit, {{"local_sites", 0}}), "local_sites"},
           {with(hit, {{"local_point", {{0, 0}}}}), "local_point"},
           {with(hit, {{"of", of}, {"delta", "only"}, {"anchor_points", {{0, 0, 0}}}}), "anchor_points"},
           {with(hit, {{"levels", {2, 8}}, {"delta", "only"}}), "delta"},
           {with(hit, {{"fragment", 5}, {"delta", "stated"}}), "delta"},
           {with(hit, {{"delta", "stated"}, {"local_new", 2}}), "local_new"},
           {{{"delta", "only"}}, "delta"}}) {
    const Error error = refused(given);
    EXPECT_EQ(error.code, ErrorCode::kBadParameter) << given << error.detail;
    EXPECT_EQ(error.pointer, name) << given;
    EXPECT_NE(error.detail.find("'"), std::string::npos) << given;
  }
  const Error error = refused({{"of", unknown}});
  EXPECT_EQ(error.code, ErrorCode::kNoSuchAnswer);
  EXPECT_EQ(error.pointer, "of");
  const auto foreign = ask(service, other, {{"of", of}});
  ASSERT_FALSE(foreign);
  EXPECT_EQ(foreign.error().code, ErrorCode::kBadParameter);
  EXPECT_EQ(foreign.error().pointer, "of");
  EXPECT_NE(foreign.error().detail.find("another mesh"), std::string::npos);
}

TEST_F(HitsTest, TheRestMayStayOnePieceFromHitToHit) {
  const FractureAnswer first =
      ask({{"sites", 30}, {"local_point", {2, 0.5, 0.5}}, {"local_radius", 0.3}, {"local_sites", 6}});
  const FractureAnswer second = ask(
      {{"of", address(first)}, {"local_point", {0, 0.5, 0.5}}, {"local_radius", 0.3}, {"local_sites", 6}});
  const json figures = figures_of(*second.result);
  EXPECT_EQ(figures.at("parameters").at("local_rest"), "whole");
  // The box is 2 m x 1 m x 1 m, and each hit has a radius of 0.3 m. So the rest is one piece with more than half of the
  // volume.
  std::size_t large = 0;
  const json document = document_of(*second.result);
  for (const json& node : document.at("nodes"))
    if (const json::json_pointer volume("/extras/fracture/volume"); node.contains(volume))
      large += node.at(volume) > 1.0;
  EXPECT_EQ(large, 1u);
  EXPECT_GE(ids(figures.at("delta"), "new").size(), 6u);
}

TEST_F(HitsTest, KeptAnswersCountInTheBudgetOfTheDiagrams) {
  const FractureAnswer first = ask({{"sites", 40}});
  const std::size_t plain = service.figures().diagrams.bytes;
  ask({{"of", address(first)}, {"local_point", {2, 0.5, 0.5}}, {"local_radius", 0.3}});
  const auto& figures = service.figures().diagrams;
  EXPECT_EQ(figures.entries, 3u) << "a diagram, and what was there before and after the hit";
  EXPECT_GT(figures.bytes, plain + first.result->file.size() / 2);
}

}  // namespace
}  // namespace fracture::test
