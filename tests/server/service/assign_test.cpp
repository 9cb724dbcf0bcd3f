// Answers to requests with several materials: masses, surfaces, cuts, bonds and warnings in the file, and the caches.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>
#include <string>

#include "tests/server/service/hits_fixture.hpp"

namespace fracture::test {
namespace {

/// A box of 1 x 1 x 1 m at x, as an object of an OBJ file. `first`: number of its first vertex.
std::string obj_box(const std::string& name, const std::string& material, double x, int first) {
  std::string text = "o " + name + "\nusemtl " + material + "\n";
  for (int k = 0; k < 8; ++k)
    text += "v " + std::to_string(x + (k & 1)) + " " + std::to_string(k >> 1 & 1) + " " +
            std::to_string(k >> 2 & 1) + "\n";
  for (const auto& [a, b, c, d] : std::initializer_list<std::array<int, 4>>{
           {0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}})
    text += "f " + std::to_string(first + a) + " " + std::to_string(first + b) + " " +
            std::to_string(first + c) + " " + std::to_string(first + d) + "\n";
  return text;
}

struct AssignTest : testing::Test {
  const std::string mesh = obj_box("Wall", "Clay", 0, 1) + obj_box("Window", "Clear", 1.0001, 9);
  FractureService service{ServiceConfig{}, engine_in_process()};

  FractureAnswer ask(const json& parameters) {
    std::vector<RawParameter> given;
    for (const auto& [name, value] : parameters.items()) given.push_back({name, value, false});
    const auto parsed = service.parse(given);
    if (!parsed) throw std::runtime_error(parsed.error().detail);
    const FractureRequest request{bytes(mesh), MeshFormat::kObj, *parsed};
    auto answer = service.fracture(request, {});
    if (!answer) throw std::runtime_error(answer.error().detail);
    return std::move(*answer);
  }
};

const json kHouse = {
    {"material", "brick"},
    {"fragments", 40},
    {"assign", {{{"node", "Window"}, {"material", "glass"}, {"shell", 0}, {"rough_amplitude", 0}}}}};

TEST_F(AssignTest, MassesSurfacesCutsAndBondsAreThoseOfTheMaterials) {
  const FractureAnswer answer = ask(kHouse);
  const json document = document_of(*answer.result), figures = figures_of(*answer.result);
  EXPECT_EQ(figures.at("report").at("warnings").dump().find("assign"), std::string::npos);
  double mass[2] = {};
  std::map<std::uint64_t, int> part_of;
  std::set<std::string> cuts[2];
  const json& materials = document.at("materials");
  const json& surfaces = document.at("extensions").at("KHR_physics_rigid_bodies").at("physicsMaterials");
  ASSERT_EQ(surfaces.size(), 2u);
  EXPECT_EQ(surfaces[0].at("staticFriction"), 0.65) << "brick";
  EXPECT_EQ(surfaces[1].at("staticFriction"), 0.4) << "glass";
  EXPECT_EQ(surfaces[1].at("restitution"), 0.25);
  for (const json& node : document.at("nodes")) {
    const json::json_pointer extras("/extras/fracture/part"),
        collider("/extensions/KHR_physics_rigid_bodies/collider");
    if (!node.contains(extras)) continue;
    const int part = node.at(extras);
    mass[part] += node.at(json::json_pointer("/extras/fracture/mass")).get<double>();
    part_of[node.at(json::json_pointer("/extras/fracture/id"))] = part;
    if (node.contains(collider)) {
      EXPECT_EQ(node.at(collider).at("physicsMaterial"), part);
    }
    for (const json& primitive :
         document.at("meshes").at(node.at("mesh").get<std::size_t>()).at("primitives"))
      if (const std::string name = materials.at(primitive.at("material").get<std::size_t>()).at("name");
          name.starts_with("Interior"))
        cuts[part].insert(name);
  }
  EXPECT_NEAR(mass[0], 1900, 0.01);
  EXPECT_NEAR(mass[1], 2500, 0.01);
  EXPECT_EQ(cuts[0], std::set<std::string>{"Interior_brick"});
  EXPECT_EQ(cuts[1], std::set<std::string>{"Interior_glass"});
  EXPECT_EQ(figures.at("interior_materials").size(), 2u);

  const json& bonds = figures.at("bonds");
  std::size_t across = 0;
  for (std::size_t k = 0; k < bonds.at("a").size(); ++k) {
    const int a = part_of.at(bonds.at("a")[k]), b = part_of.at(bonds.at("b")[k]);
    const double area = bonds.at("area")[k], strength = bonds.at("strength")[k];
    EXPECT_NEAR(strength, area * (a == 1 && b == 1 ? 45e6 : 0.3e6), 1e-4 * strength) << "the weaker of both";
    across += a != b;
  }
  EXPECT_GT(across, 0u);
  EXPECT_EQ(figures.at("certificate").at("unmirrored_caps"), 0);
  EXPECT_EQ(figures.at("parameters").at("assign")[0].at("material"), "glass");
}

TEST_F(AssignTest, ATotalMassIsSharedByTheDensities) {
  json parameters = kHouse;
  parameters["mass"] = 44;
  double mass[2] = {};
  const json document = document_of(*ask(parameters).result);
  for (const json& node : document.at("nodes"))
    if (const json::json_pointer part("/extras/fracture/part"); node.contains(part))
      mass[node.at(part).get<int>()] += node.at(json::json_pointer("/extras/fracture/mass")).get<double>();
  EXPECT_NEAR(mass[0], 19, 1e-3);
  EXPECT_NEAR(mass[1], 25, 1e-3);
}

TEST_F(AssignTest, TheQueryFormGivesTheSameAnswer) {
  json entries = {{"material", "stone"},
                  {"fragments", 20},
                  {"assign", {{{"slot", "Clear"}, {"material", "wood"}}}}},
       text = entries;
  text["assign"] = "slot=Clear:wood";
  const FractureAnswer first = ask(entries), second = ask(text);
  EXPECT_EQ(second.result_cache, CacheOutcome::kHit);
  EXPECT_EQ(first.result->key, second.result->key);
  json other = entries;
  other["assign"] = "slot=Clear:ice";
  EXPECT_NE(ask(other).result->key, first.result->key);
  EXPECT_EQ(ask(other).result_cache, CacheOutcome::kHit);
  EXPECT_NE(ask(other).result->file, first.result->file);
}

TEST_F(AssignTest, OnlyThePartsOfAMaterialWithWallsBecomeHollow) {
  const json figures =
      figures_of(*ask({{"assign", {{{"node", "Window"}, {"shell", 0.1}}}}, {"sites", 4}}).result);
  const json& solid = figures.at("report").at("solid");
  EXPECT_EQ(solid.at("parts_hollowed"), 1);
  EXPECT_NEAR(figures.at("certificate").at("volume_in").get<double>(), 2 - 0.8 * 0.8 * 0.8, 0.05);
}

TEST_F(AssignTest, AnEntryThatMatchesNothingIsAWarning) {
  const json figures = figures_of(*ask({{"sites", 4}, {"assign", "Windov:glass"}}).result);
  const json& warnings = figures.at("report").at("warnings");
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].get<std::string>().find("'Window', 'Wall'"), std::string::npos) << warnings[0];
}

TEST_F(AssignTest, HitsOnSuchAnAnswerNameWhatTheyChange) {
  const FractureAnswer before = ask(kHouse);
  const FractureAnswer after = ask({{"of", "/fractures/sha256:" + before.result->key},
                                    {"local_point", {2.0001, 0.5, 0.5}},
                                    {"local_radius", 0.2},
                                    {"local_sites", 7}});
  const json delta = figures_of(*after.result).at("delta");
  EXPECT_FALSE(delta.at("new").empty());
  std::set<std::uint64_t> was = fragment_ids(*before.result), is = fragment_ids(*after.result);
  for (const std::uint64_t id : ids(delta, "new")) EXPECT_TRUE(is.contains(id) && !was.contains(id));
  for (const std::uint64_t id : ids(delta, "gone")) EXPECT_TRUE(was.contains(id) && !is.contains(id));
}

}  // namespace
}  // namespace fracture::test
