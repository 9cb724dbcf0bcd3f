// Parts of a scene: the selection, and that everything else is still in the rest.
#include "common/mesh/selection.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/mesh/material_library.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

/// Three boxes of volume 1, 2, 4 with the nodes "crate", "wall", "crate". The materials are "wood" (0, 2) and
/// "stone" (1). The first triangle of the last box has the second box's material.
Mesh scene() {
  Mesh mesh;
  auto library = std::make_shared<MaterialLibrary>();
  library->materials = {{{"name", "wood"}}, {{"name", "stone"}}};
  mesh.library = library;
  mesh.node_names = {"crate", "wall", "crate"};
  for (std::uint32_t k = 0; k < 3; ++k) {
    const Mesh part = box({10.0 * k, 0, 0}, {10.0 * k + (1u << k), 1, 1});
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.positions.insert(mesh.positions.end(), part.positions.begin(), part.positions.end());
    for (auto triangle : part.triangles) {
      for (std::uint32_t& w : triangle) w += first;
      mesh.triangles.push_back(triangle);
      mesh.node.push_back(k);
      mesh.material.push_back(k % 2);
    }
  }
  mesh.material[24] = 1;
  mesh.attributes.uvs.emplace_back();
  for (const Vec3f& p : mesh.positions) mesh.attributes.uvs[0].push_back({p.x, p.y});
  mesh.remarks = {{"kept"}, {"kept too"}};
  mesh.dropped = {{"light", "Lamp", "why"}};
  mesh.empty_nodes = {{.name = "socket"}};
  mesh.node_extras = {"\"hp\":1"};
  return mesh;
}

TEST(Selection, NothingAskedLeavesTheMeshAsItIs) {
  Mesh mesh = scene();
  ASSERT_TRUE(restrict_to(mesh, {}));
  EXPECT_EQ(mesh.triangles.size(), 36u);
  EXPECT_EQ(mesh.passed_through, nullptr);
  ASSERT_TRUE(restrict_to(mesh, {.nodes = {"crate", "wall"}}));
  EXPECT_EQ(mesh.passed_through, nullptr);
}

TEST(Selection, PatternsAndNodesAboveOthersSelect) {
  Mesh mesh = scene();
  mesh.groups = {{"house", kNoIndex}, {"roof", 0}};
  mesh.group_of_node = {kNoIndex, 0, 1};
  const auto volume = [&](const PartSelection& selection) {
    Mesh part = mesh;
    return restrict_to(part, selection) ? volume_of(part) : -1;
  };
  EXPECT_DOUBLE_EQ(volume({.nodes = {"cra*"}}), 5);
  EXPECT_DOUBLE_EQ(volume({.nodes = {"house"}}), 6) << "with all nodes below it";
  EXPECT_DOUBLE_EQ(volume({.nodes = {"r??f"}}), 4);
  EXPECT_DOUBLE_EQ(volume({.nodes = {"wall"}, .materials = {"s[a-z]one"}}), 2);
  EXPECT_DOUBLE_EQ(volume({.nodes = {"x*"}}), -1);
  mesh.node_names[1] = "cra*";
  EXPECT_DOUBLE_EQ(volume({.nodes = {"cra*"}}), 2) << "a name that is equal goes first";
}

TEST(Selection, ANameStandsForEveryNodeOfThatNameAndTheRestPassesThrough) {
  Mesh mesh = scene();
  ASSERT_TRUE(restrict_to(mesh, {.nodes = {"crate"}}));
  EXPECT_DOUBLE_EQ(volume_of(mesh), 5.0);
  ASSERT_NE(mesh.passed_through, nullptr);
  EXPECT_DOUBLE_EQ(volume_of(*mesh.passed_through), 2.0);
  EXPECT_EQ(mesh.positions.size() + mesh.passed_through->positions.size(), scene().positions.size());
  EXPECT_EQ(mesh.passed_through->library, mesh.library);
  EXPECT_EQ(mesh.passed_through->node_names[mesh.passed_through->node[0]], "wall");
  EXPECT_EQ(mesh.remarks, (Remarks{{"kept"}, {"kept too"}}));
  EXPECT_EQ(mesh.dropped, (std::vector<Dropped>{{"light", "Lamp", "why"}}));
  EXPECT_EQ(mesh.empty_nodes.size(), 1u);
  EXPECT_TRUE(mesh.passed_through->empty_nodes.empty()) << "they are in the answer once";
  EXPECT_EQ(mesh.node_extras, mesh.passed_through->node_extras);
  for (const Mesh* part : {static_cast<const Mesh*>(&mesh), mesh.passed_through.get()})
    for (std::size_t w = 0; w < part->positions.size(); ++w)
      EXPECT_EQ(part->attributes.uvs[0][w], (Vec2f{part->positions[w].x, part->positions[w].y}));
}

TEST(Selection, IndicesSelectOneNode) {
  Mesh mesh = scene();
  ASSERT_TRUE(restrict_to(mesh, {.nodes = {"2"}}));
  EXPECT_DOUBLE_EQ(volume_of(mesh), 4.0);
}

TEST(Selection, ANameThatLooksLikeANumberIsAName) {
  Mesh mesh = scene();
  mesh.node_names[1] = "0";
  ASSERT_TRUE(restrict_to(mesh, {.nodes = {"0"}}));
  EXPECT_DOUBLE_EQ(volume_of(mesh), 2.0);
}

TEST(Selection, WithBothListsATriangleHasToBeInBoth) {
  Mesh mesh = scene();
  ASSERT_TRUE(restrict_to(mesh, {.nodes = {"2"}, .materials = {"wood"}}));
  EXPECT_EQ(mesh.triangles.size(), 11u);
  EXPECT_EQ(mesh.passed_through->triangles.size(), 25u);
}

TEST(Selection, WhatIsNotThereIsRefusedWithTheNamesThatAre) {
  Mesh mesh = scene();
  for (const char* absent : {"Crate", "3", "-1", "1x"}) {
    const auto restricted = restrict_to(mesh, {.nodes = {absent}});
    ASSERT_FALSE(restricted) << absent;
    EXPECT_EQ(restricted.error().code, ErrorCode::kBadParameter);
    EXPECT_EQ(restricted.error().pointer, "nodes");
    EXPECT_EQ(restricted.error().extra->at("known").size(), 2u) << "each name once";
  }
  EXPECT_THAT(restrict_to(mesh, {.nodes = {"crat"}}).error().detail,
              AllOf(HasSubstr("no node named 'crat'"), HasSubstr("Did you mean 'crate'?"),
                    HasSubstr("an index from 0 to 2")));
  EXPECT_THAT(restrict_to(mesh, {.nodes = {"nosuch"}}).error().detail, Not(HasSubstr("Did you mean")));
  EXPECT_EQ(restrict_to(mesh, {.materials = {"glass"}}).error().pointer, "materials");
  EXPECT_FALSE(restrict_to(mesh, {.nodes = {"wall"}, .materials = {"wood"}})) << "empty";
  EXPECT_EQ(mesh.triangles.size(), 36u);
}

}  // namespace
}  // namespace fracture::test
