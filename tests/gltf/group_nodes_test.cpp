// The hierarchy of the source in the file: which nodes have groups, what is in them, and their names.
#include <gtest/gtest.h>

#include <array>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "common/gltf/gltf_writer.hpp"
#include "common/gltf/names.hpp"
#include "common/mesh/source_tree.hpp"
#include "tests/gltf/glb_file.hpp"
#include "tests/gltf/two_halves.hpp"
#include "tests/support/fractured.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::test {
namespace {

using nlohmann::json;

/// Two halves from two mesh instances. `nodes`: of the halves. `tree`: of the source; null: none.
FracturedSolid halves_of(const std::vector<std::string>& names, std::array<std::uint32_t, 2> nodes = {0, 1},
                         std::shared_ptr<const SourceTree> tree = {}) {
  FracturedSolid made = two_halves();
  auto mesh = std::make_shared<Mesh>(*made.set.source);
  mesh->node_names = names;
  mesh->node = {nodes[0], nodes[1]};  // which of them have triangles
  mesh->source_tree = std::move(tree);
  made.set.source = mesh;
  for (std::size_t k = 0; k < 2; ++k) made.set.fragments[k].node = nodes[k];
  return made;
}

/// House {Wall, Roof, Lamp}; each of the three is a mesh instance.
std::shared_ptr<const SourceTree> house() {
  return std::make_shared<const SourceTree>(
      SourceTree{{{"House", kNoIndex, "\"floors\":2"}, {"Wall", 0}, {"Roof", 0}, {"Lamp", 0}}, {1, 2, 3}});
}

json nodes_of(const FracturedSolid& made, const GltfOptions& options = {}) {
  return Glb(write_glb(made, options)).document["nodes"];
}

json group(const std::string& name, const json& children, int index, const std::string& source) {
  return {{"name", name},
          {"children", children},
          {"extras", {{"fracture", {{"source", {{"index", index}, {"name", source}}}}}}}};
}

void add_intact(FracturedSolid& made) {
  made.intact.emplace();
  made.intact->parts = {made.set.fragments[0]};
}

TEST(GroupNodes, EachNodeOfTheSourceHoldsItsPieces) {
  const FracturedSolid made = halves_of({"Wall.N", "Wall/E"});
  const json nodes = nodes_of(made);
  ASSERT_EQ(nodes.size(), 5u);
  EXPECT_EQ(nodes[0]["children"], json({3, 4}));
  EXPECT_EQ(nodes[1]["name"], "Wall_N_0");
  EXPECT_EQ(nodes[2]["name"], "Wall_E_1");
  EXPECT_EQ(nodes[3], group("Wall_N", json::array({1}), 0, "Wall.N"));
  EXPECT_EQ(nodes[4], group("Wall_E", json::array({2}), 1, "Wall/E"));
  for (std::size_t k = 1; k < 3; ++k) EXPECT_FALSE(nodes[k]["extras"]["fracture"].contains("source"));
}

TEST(GroupNodes, ChangeNothingElseInTheFile) {
  FracturedSolid made = halves_of({"Wall", "Roof"});
  const Glb grouped(write_glb(made, {}));
  auto plain = std::make_shared<Mesh>(*made.set.source);
  plain->node.clear();
  made.set.source = plain;
  const Glb flat(write_glb(made, {}));
  EXPECT_EQ(grouped.binary, flat.binary);
  json a = grouped.document, b = flat.document;
  for (std::size_t k = 1; k < 3; ++k) EXPECT_EQ(a["nodes"][k], b["nodes"][k]);
  EXPECT_EQ(a["nodes"][0]["extras"], b["nodes"][0]["extras"]);
  a.erase("nodes");
  b.erase("nodes");
  EXPECT_EQ(a, b);
}

TEST(GroupNodes, ASourceOfOneNodeHasNone) {
  EXPECT_EQ(nodes_of(halves_of({"Wall"}, {0, 0})).size(), 3u);
  EXPECT_EQ(nodes_of(halves_of({"Wall", "Wall_LOD1"}, {0, 0})).size(), 3u) << "the other has no triangles";
  const auto instances =
      std::make_shared<const SourceTree>(SourceTree{{{"Trees", kNoIndex}}, {0, 0}});  // of one node
  EXPECT_EQ(nodes_of(halves_of({"Trees", "Trees"}, {0, 1}, instances)).size(), 3u);
  const auto below = std::make_shared<const SourceTree>(SourceTree{{{"House", kNoIndex}, {"Wall", 0}}, {1}});
  const json nodes = nodes_of(halves_of({"Wall"}, {0, 0}, below));
  ASSERT_EQ(nodes.size(), 5u) << "but one below another is a hierarchy";
  EXPECT_EQ(nodes[0]["children"], json::array({3}));
  EXPECT_EQ(nodes[3], group("House", json::array({4}), 0, "House"));
  EXPECT_EQ(nodes[4], group("Wall", json({1, 2}), 1, "Wall"));
}

TEST(GroupNodes, AFragmentOfSeveralNodesIsBelowTheirNearestCommonAncestor) {
  FracturedSolid made = halves_of({"Wall", "Roof", "Lamp"}, {0, 1}, house());
  made.set.fragments[1].nodes.add(0u);
  made.set.fragments[1].nodes.add(1u);
  json nodes = nodes_of(made);
  ASSERT_EQ(nodes.size(), 5u) << "groups that hold nothing are left out";
  json top = group("House", json({2, 4}), 0, "House");
  top["extras"]["floors"] = 2;
  EXPECT_EQ(nodes[0]["children"], json::array({3}));
  EXPECT_EQ(nodes[3], top);
  EXPECT_EQ(nodes[4], group("Wall", json::array({1}), 1, "Wall"));

  FracturedSolid apart = halves_of({"Wall", "Roof"});
  apart.set.fragments[1].nodes.add(0u);
  nodes = nodes_of(apart);
  EXPECT_EQ(nodes[0]["children"], json({2, 3})) << "without a common ancestor, below the root";
  EXPECT_EQ(nodes[3], group("Wall", json::array({1}), 0, "Wall"));
}

TEST(GroupNodes, WithLevelsTheClustersAreTheTreeAndFragmentsStateTheirSource) {
  FracturedSolid made = halves_of({"Wall", "Roof", "Lamp"}, {0, 1}, house());
  made.set.fragments[1].nodes.add(0u);
  made.hierarchy.levels.resize(1);
  made.hierarchy.levels[0].clusters = {{11, kNoIndex, 2, 2.0, 1, {1, 0.5, 0.5}}};
  made.hierarchy.cluster_of_fragment = {0, 0};
  json nodes = nodes_of(made);
  ASSERT_EQ(nodes.size(), 4u);
  EXPECT_EQ(nodes[3]["children"], json({1, 2}));
  EXPECT_EQ(nodes[1]["extras"]["fracture"]["source"], json({{"index", 1}, {"name", "Wall"}}));
  EXPECT_EQ(nodes[2]["extras"]["fracture"]["source"], json({{"index", 0}, {"name", "House"}}));
  auto apart = std::make_shared<Mesh>(*made.set.source);
  apart->source_tree = nullptr;
  made.set.source = apart;
  nodes = nodes_of(made);
  EXPECT_TRUE(nodes[1]["extras"]["fracture"].contains("source"));
  EXPECT_FALSE(nodes[2]["extras"]["fracture"].contains("source")) << "it has no common ancestor";
}

/// A mesh of one triangle for each of these nodes, which are not broken.
std::shared_ptr<const Mesh> rest_of(const FracturedSolid& made, const std::vector<std::uint32_t>& nodes) {
  auto rest = std::make_shared<Mesh>();
  rest->node_names = made.set.source->node_names;
  rest->source_tree = made.set.source->source_tree;
  rest->library = made.set.source->library;
  rest->positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  rest->triangles.assign(nodes.size(), {0, 1, 2});
  rest->material.assign(nodes.size(), kNoIndex);
  rest->node = nodes;
  return rest;
}

TEST(GroupNodes, NodesThatStayWholeAreAtTheirPlaceAndEmptyOnesBelowTheRoot) {
  FracturedSolid made = halves_of({"Wall", "Roof", "Lamp"}, {0, 0}, house());
  auto mesh = std::make_shared<Mesh>(*made.set.source);
  mesh->passed_through = rest_of(made, {2});
  mesh->empty_nodes = {{.name = "socket"}};
  made.set.source = mesh;
  const json nodes = nodes_of(made);
  ASSERT_EQ(nodes.size(), 7u);
  EXPECT_EQ(nodes[0]["children"], json({4, 5}));
  EXPECT_EQ(nodes[3]["name"], "Lamp");
  EXPECT_EQ(nodes[3]["extras"], json({{"whole", {{"node", 2}}}}));
  EXPECT_EQ(nodes[4]["name"], "socket");
  EXPECT_EQ(nodes[5]["children"], json({3, 6})) << "the whole lamp is a node of its own";
  EXPECT_EQ(nodes[6], group("Wall", json({1, 2}), 1, "Wall"));
}

TEST(GroupNodes, WhatStaysWholeOfABrokenNodeIsWithItsFragments) {
  FracturedSolid made = halves_of({"Wall", "Roof", "Lamp"}, {0, 1}, house());
  auto mesh = std::make_shared<Mesh>(*made.set.source);
  mesh->passed_through = rest_of(made, {0});
  made.set.source = mesh;
  json nodes = nodes_of(made);
  EXPECT_EQ(nodes[3]["name"], "Wall");
  EXPECT_EQ(nodes[5], group("Wall_group", json({1, 3}), 1, "Wall"));

  const auto below = std::make_shared<const SourceTree>(
      SourceTree{{{"Wall", kNoIndex}, {"Roof", 0}, {"Lamp", 1}}, {0, 1, 2}});
  made = halves_of({"Wall", "Roof", "Lamp"}, {1, 1}, below);
  mesh = std::make_shared<Mesh>(*made.set.source);
  mesh->passed_through = rest_of(made, {0, 2});
  made.set.source = mesh;
  nodes = nodes_of(made);  // 1, 2: fragments of the roof; 3: the wall; 4: the lamp
  ASSERT_EQ(nodes.size(), 7u);
  EXPECT_EQ(nodes[0]["children"], json::array({5}));
  EXPECT_EQ(nodes[5]["children"], json({3, 6})) << "a whole node above others is in its own group";
  EXPECT_EQ(nodes[6]["children"], json({1, 2, 4}));
}

TEST(GroupNodes, NamesAreThoseOfTheSourceAndUnique) {
  const auto names = [](FracturedSolid made, const GltfOptions& options = {}) {
    std::vector<std::string> found;
    std::set<std::string> all;
    for (const json& node : nodes_of(made, options)) {
      const auto name = node["name"].get<std::string>();
      EXPECT_TRUE(all.insert(name).second) << name;
      EXPECT_LE(name.size(), kMaxName);
      if (node.contains("extras") && node["extras"].contains("fracture") &&
          node["extras"]["fracture"].contains("source"))
        found.push_back(name);
    }
    return found;
  };
  using Names = std::vector<std::string>;
  EXPECT_EQ(names(halves_of({"Cube", "Cube"})), (Names{"Cube", "Cube_2"}));
  EXPECT_EQ(names(halves_of({"Cube", "Cube", "Cube_2"})), (Names{"Cube", "Cube_3"}));
  EXPECT_EQ(names(halves_of({"Cube", "Cube.1"}, {1, 0})), (Names{"Cube", "Cube_1_group"}))
      << "a fragment is called Cube_1";
  EXPECT_EQ(names(halves_of({"Crate-col", "UCX_Box"})), (Names{"Crate-col_piece", "_UCX_Box"}));
  EXPECT_EQ(names(halves_of({"Fracture", "b"})), (Names{"Fracture_group", "b"})) << "the root's name";
  const std::string longest(80, 'x');
  EXPECT_EQ(names(halves_of({longest, longest})), (Names{std::string(57, 'x'), std::string(55, 'x') + "_2"}));

  FracturedSolid with_intact = halves_of({"Intact", "Intact_intact"});
  add_intact(with_intact);
  EXPECT_EQ(names(with_intact), (Names{"Intact_group", "Intact_intact_group"}));
  FracturedSolid with_empty = halves_of({"socket", "b"});
  auto mesh = std::make_shared<Mesh>(*with_empty.set.source);
  mesh->empty_nodes = {{.name = "socket"}};
  with_empty.set.source = mesh;
  EXPECT_EQ(names(with_empty), (Names{"socket_group", "b"})) << "others look for the socket by its name";
}

TEST(GroupNodes, TheIndexOfAGroupIsTheSameInAnAnswerWithFewerFragments) {
  FracturedSolid made = halves_of({"Wall", "Roof"});
  made.set.fragments.erase(made.set.fragments.begin());
  made.set.bonds.clear();
  const json nodes = nodes_of(made);
  ASSERT_EQ(nodes.size(), 3u) << "the source is still a hierarchy";
  EXPECT_EQ(nodes[2], group("Roof", json::array({1}), 1, "Roof"));
  made.set.fragments.clear();
  EXPECT_EQ(nodes_of(made).size(), 1u);
}

/// The name of the group that holds each fragment, by the name of its node in the mesh.
std::map<std::string, std::set<std::string>> groups_by_source(const Fractured& made) {
  const json nodes = nodes_of(made);
  std::vector<std::string> holder(nodes.size());
  for (const json& node : nodes)
    for (const json& child : node.value("children", json::array()))
      holder[child.get<std::size_t>()] = node["name"].get<std::string>();
  std::map<std::string, std::set<std::string>> found;
  for (std::size_t k = 0; k < made.set.fragments.size(); ++k)
    found[made.set.source->node_names[made.set.fragments[k].node]].insert(holder[1 + k]);
  return found;
}

/// The mesh, with House {Left, Right} as its source. The first six or twelve triangles are those of Left.
Mesh of_two_nodes(Mesh mesh) {
  mesh.node_names = {"Left", "Right"};
  mesh.node.assign(mesh.triangles.size() / 2, 0);
  mesh.node.resize(mesh.triangles.size(), 1);
  mesh.material.assign(mesh.triangles.size(), kNoIndex);
  mesh.source_tree = std::make_shared<const SourceTree>(
      SourceTree{{{"House", kNoIndex}, {"Left", 0}, {"Right", 0}}, {1, 2}});
  return mesh;
}

using Groups = std::map<std::string, std::set<std::string>>;

TEST(GroupNodes, FragmentsOfPartsApartAreInTheGroupsOfTheirNodes) {
  FractureParameters p;
  p.pattern = PointsPattern{{{0.25, 0.5, 0.5}, {0.75, 0.5, 0.5}, {5.5, 0.5, 0.5}}};
  const Fractured made =
      fracture_mesh(of_two_nodes(joined({box({0, 0, 0}, {1, 1, 1}), box({5, 0, 0}, {6, 1, 1})})), p);
  EXPECT_EQ(groups_by_source(made), (Groups{{"Left", {"Left"}}, {"Right", {"Right"}}}));
}

TEST(GroupNodes, OneSurfaceOfSeveralNodesIsBelowTheirCommonAncestor) {
  FractureParameters p;
  p.pattern = PointsPattern{{{0.25, 0.5, 0.5}, {0.75, 0.5, 0.5}}};
  const Fractured made = fracture_mesh(of_two_nodes(box({0, 0, 0}, {1, 1, 1})), p);
  ASSERT_EQ(made.set.fragments.size(), 2u);
  for (const Fragment& f : made.set.fragments) EXPECT_EQ(f.nodes, (NodeRange{0, 1}));
  EXPECT_EQ(groups_by_source(made), (Groups{{"Left", {"House"}}}));
}

}  // namespace
}  // namespace fracture::test
