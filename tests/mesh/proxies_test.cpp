// Levels of detail and collision geometry: which names mean them, and what becomes of their nodes.
#include "common/mesh/proxies.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "common/mesh/selection.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// One unit cube for each name, 10 m apart.
Mesh scene(const std::vector<std::string>& names) {
  Mesh mesh;
  mesh.node_names = names;
  for (std::uint32_t k = 0; k < names.size(); ++k) {
    const Mesh part = box({10.0 * k, 0, 0}, {10.0 * k + 1, 1, 1});
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.positions.insert(mesh.positions.end(), part.positions.begin(), part.positions.end());
    for (auto triangle : part.triangles) {
      for (std::uint32_t& w : triangle) w += first;
      mesh.triangles.push_back(triangle);
      mesh.node.push_back(k);
      mesh.material.push_back(kNoIndex);
    }
  }
  mesh.remarks.note("kept");
  return mesh;
}

/// The names of the nodes that have triangles.
std::vector<std::string> nodes_of(const Mesh& mesh) {
  std::vector<bool> used(mesh.node_names.size());
  for (const std::uint32_t node : mesh.node) used.at(node) = true;
  std::vector<std::string> names;
  for (std::size_t k = 0; k < used.size(); ++k)
    if (used[k]) names.push_back(mesh.node_names[k]);
  return names;
}

Mesh taken(Mesh mesh) {
  take_proxies(mesh);
  return mesh;
}
std::vector<std::string> left(const std::vector<std::string>& names) { return nodes_of(taken(scene(names))); }

/// "hull: its owners", for each given hull.
std::vector<std::string> given(const Mesh& mesh) {
  std::vector<std::string> result;
  for (const GivenHull& hull : mesh.given_hulls) {
    std::string text = hull.name + ":";
    for (const std::uint32_t owner : *hull.owners) text += " " + mesh.node_names.at(owner);
    result.push_back(text);
  }
  return result;
}

TEST(Proxies, OfLevelsOfDetailOnlyTheFirstStays) {
  EXPECT_THAT(left({"SM_Crate_LOD0", "SM_Crate_LOD1", "Wall", "SM_Crate_LOD2"}),
              ElementsAre("SM_Crate_LOD0", "Wall"));
  EXPECT_THAT(left({"a_lod1", "a_lod0"}), ElementsAre("a_lod0"));
  EXPECT_THAT(left({"a_LOD0.001", "a_LOD1.001"}), ElementsAre("a_LOD0.001")) << "copies in Blender";
}

TEST(Proxies, ALevelCountsOnlyIfTheSameStemHasLevel0) {
  for (const std::vector<std::string>& names : {std::vector<std::string>{"Crate_LOD1", "Crate_LOD2"},
                                                {"Crate_LOD1", "Barrel_LOD0"},
                                                {"Crate_LOD0", "Crate_LODX"},
                                                {"Crate_LOD0", "Crate_LOD"},
                                                {"Crate_LOD0", "CrateLOD1"},
                                                {"_LOD0", "_LOD1"},
                                                {"Crate_LOD0", "Crate_LOD100"}})
    EXPECT_EQ(left(names), names) << names[0] << ", " << names[1];
}

TEST(Proxies, CollisionGeometryOfUnrealBecomesHulls) {
  const Mesh mesh = taken(
      scene({"Wall", "UCX_Wall_00", "UBX_Wall", "USP_Wall_1", "UCP_Wall_02", "Wall_01", "UCX_Wall_01"}));
  EXPECT_THAT(nodes_of(mesh), ElementsAre("Wall", "Wall_01"));
  EXPECT_THAT(given(mesh), ElementsAre("UCX_Wall_00: Wall", "UBX_Wall: Wall", "USP_Wall_1: Wall",
                                       "UCP_Wall_02: Wall", "UCX_Wall_01: Wall_01"))
      << "the whole name is more likely than a number";
  for (const GivenHull& hull : mesh.given_hulls) {
    EXPECT_TRUE(hull.convex);
    EXPECT_EQ(hull.points.size(), 8u);
    EXPECT_EQ(hull.triangles.size(), 12u);
  }
  EXPECT_EQ(mesh.given_hulls[0].points[0].x, 10) << "where the node is";
}

TEST(Proxies, CollisionGeometryBelongsToLevel0OrToAllNodesBelowItsName) {
  EXPECT_THAT(given(taken(scene({"Crate_LOD0", "Crate_LOD1", "UCX_Crate_00"}))),
              ElementsAre("UCX_Crate_00: Crate_LOD0"));
  Mesh mesh = scene({"Body", "Lid", "UCX_Chest_00", "Other"});
  mesh.groups = {{"Room", kNoIndex}, {"Chest", 0}};
  mesh.group_of_node = {1, 1, 0, 0};
  EXPECT_THAT(given(taken(mesh)), ElementsAre("UCX_Chest_00: Body Lid"));
  EXPECT_THAT(given(taken(scene({"Crate", "Crate", "UCX_Crate_00"}))),
              ElementsAre("UCX_Crate_00: Crate Crate"));
}

TEST(Proxies, CollisionGeometryOfGodotBecomesHulls) {
  const Mesh mesh =
      taken(scene({"Wall", "Wall-col", "Wall-colonly", "Wall-convcol", "Wall-convcolonly", "Wall-COL.001"}));
  EXPECT_THAT(nodes_of(mesh), ElementsAre("Wall"));
  ASSERT_EQ(mesh.given_hulls.size(), 5u);
  for (const std::size_t k : {0u, 1u, 4u}) EXPECT_FALSE(mesh.given_hulls[k].convex) << k;
  for (const std::size_t k : {2u, 3u}) EXPECT_TRUE(mesh.given_hulls[k].convex) << k;
}

TEST(Proxies, OtherSeparatorsOfGodotCountUnlessTheNameIsAmbiguous) {
  EXPECT_THAT(left({"Wall", "Wall$col", "Wall_colonly", "Wall_convcol"}), ElementsAre("Wall"));
  EXPECT_THAT(left({"Temple", "Temple_col"}), ElementsAre("Temple", "Temple_col")) << "maybe a column";
}

TEST(Proxies, NamesWithoutAnOwnerAreOrdinaryUnlessTheyAreNeverVisible) {
  EXPECT_THAT(left({"UCX_Wall_00", "Floor"}), ElementsAre("UCX_Wall_00", "Floor"));
  EXPECT_THAT(left({"UCX_Wall", "UCX_Wall_00"}), ElementsAre("UCX_Wall", "UCX_Wall_00"));
  EXPECT_THAT(left({"Wall-col", "Floor"}), ElementsAre("Wall-col", "Floor")) << "in Godot, it is visible";
  const Mesh mesh = taken(scene({"Wall-colonly", "Ramp-convcolonly", "Floor"}));
  EXPECT_THAT(nodes_of(mesh), ElementsAre("Floor"));
  EXPECT_THAT(mesh.given_hulls, IsEmpty());
  ASSERT_EQ(mesh.dropped.size(), 2u);
  EXPECT_EQ(mesh.dropped[0].name, "Wall-colonly");
  EXPECT_THAT(left({"Wall-colonly"}), ElementsAre("Wall-colonly")) << "otherwise, nothing would be left";
}

TEST(Proxies, AMeshOfTheNodeItselfIsNotItsOwner) {
  Mesh mesh = scene({"Crate-col"});
  mesh.groups = {{"Crate", kNoIndex}};  // the name of its mesh in Blender
  mesh.group_of_node = {0};
  EXPECT_THAT(nodes_of(taken(mesh)), ElementsAre("Crate-col"));
}

TEST(Proxies, HullsOfLevelsThatAreLeftOutAreLeftOutToo) {
  const Mesh mesh = taken(scene({"Crate_LOD0", "Crate_LOD1", "UCX_Crate_LOD1_00", "UCX_Crate_LOD0_00"}));
  EXPECT_THAT(nodes_of(mesh), ElementsAre("Crate_LOD0"));
  EXPECT_THAT(given(mesh), ElementsAre("UCX_Crate_LOD0_00: Crate_LOD0"));
}

TEST(Proxies, TheListOfDroppedThingsNamesThemAndWarningsTheCollisionGeometry) {
  const Mesh mesh = taken(scene({"Crate_LOD0", "Crate_LOD1", "UCX_Crate_00", "Ramp-colonly"}));
  ASSERT_EQ(mesh.remarks.warnings.size(), 2u);
  const char* const kNames[] = {"UCX_Crate_00", "Ramp-colonly"};
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_THAT(mesh.remarks.warnings[k], HasSubstr(kNames[k]));
    EXPECT_THAT(mesh.remarks.warnings[k], HasSubstr("proxies=geometry"));
  }
  EXPECT_THAT(mesh.remarks.notes, ElementsAre("kept"));
  std::vector<std::string> dropped;
  for (const Dropped& entry : mesh.dropped) dropped.push_back(entry.name);
  EXPECT_THAT(dropped, testing::UnorderedElementsAre("Crate_LOD1", "UCX_Crate_00", "Ramp-colonly"));
  for (const Dropped& entry : mesh.dropped)
    if (entry.what == "level of detail") {
      EXPECT_THAT(entry.reason, HasSubstr("proxies=geometry"));
    }
}

TEST(Proxies, TakingThemIsInterruptedByCancellation) {
  std::vector<std::string> names{"Crate_LOD0", "Crate_LOD1", "UCX_Crate_00"};
  for (int k = 0; k < 2'000; ++k) names.push_back("Stone_" + std::to_string(k));
  Mesh mesh = scene(names);
  Execution execution;
  std::stop_source stop;
  execution.stop = stop.get_token();
  stop.request_stop();
  EXPECT_THROW(take_proxies(mesh, execution), Interrupted);
}

TEST(Proxies, ManyNamesMakeAShortWarning) {
  std::vector<std::string> names{"a"};
  for (int k = 1; k < 9; ++k) names.push_back("UCX_a_" + std::to_string(k));
  const Mesh mesh = taken(scene(names));
  ASSERT_EQ(mesh.remarks.warnings.size(), 1u);
  EXPECT_THAT(mesh.remarks.warnings[0], HasSubstr("8 nodes are"));
  EXPECT_THAT(mesh.remarks.warnings[0], HasSubstr("UCX_a_5 and 3 more"));
}

TEST(Proxies, AMeshWithoutThemDoesNotChange) {
  const Mesh before = scene({"Wall", "Floor"}), after = taken(before);
  EXPECT_EQ(after.positions, before.positions);
  EXPECT_EQ(after.triangles, before.triangles);
  EXPECT_EQ(after.remarks, before.remarks);
  Mesh bare = box({0, 0, 0}, {1, 1, 1});
  bare.node.clear();
  EXPECT_EQ(taken(bare).triangles, bare.triangles) << "nodes are not known";
}

/// The nodes that are broken, and those that stay whole, if only the given nodes are chosen.
std::pair<std::vector<std::string>, std::vector<std::string>> chosen(const std::vector<std::string>& nodes) {
  Mesh mesh = scene({"Crate_LOD0", "Crate_LOD1", "UCX_Crate", "Wall", "UCX_Wall"});
  EXPECT_TRUE(restrict_to(mesh, {.nodes = nodes}));
  take_proxies(mesh);
  return {nodes_of(mesh), mesh.passed_through ? nodes_of(*mesh.passed_through) : std::vector<std::string>()};
}

TEST(Proxies, AChosenNodeTakesItsProxiesAlongAndOthersStayAsTheyAre) {
  EXPECT_THAT(chosen({"Crate_LOD0"}).first, ElementsAre("Crate_LOD0"));
  EXPECT_THAT(chosen({"Crate_LOD0"}).second, ElementsAre("Wall", "UCX_Wall"));
  EXPECT_THAT(chosen({"Crate_LOD1"}).first, ElementsAre("Crate_LOD1")) << "chosen by name, without level 0";
  EXPECT_THAT(chosen({"UCX_Wall"}).first, ElementsAre("UCX_Wall"));
  EXPECT_THAT(chosen({"Crate_LOD0", "Wall"}).second, IsEmpty());
}

TEST(Proxies, VolumeIsThatOfLevel0) {
  EXPECT_DOUBLE_EQ(volume_of(taken(scene({"a_LOD0", "a_LOD1", "UCX_a"}))), 1);
}

TEST(Proxies, EachOfManyNodesFindsItsOwn) {
  std::vector<std::string> names;
  for (int k = 0; k < 1'000; ++k)
    for (const char* form : {"", "_LOD0", "_LOD1"}) names.push_back("Part" + std::to_string(k) + form);
  for (int k = 0; k < 1'000; ++k) names.push_back("UCX_Part" + std::to_string(k) + "_00");
  const Mesh mesh = taken(scene(names));
  EXPECT_EQ(nodes_of(mesh).size(), 2'000u);
  EXPECT_EQ(mesh.given_hulls.size(), 1'000u);
}

}  // namespace
}  // namespace fracture::test
