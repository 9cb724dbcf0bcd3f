// Nodes of the source whose names are in no fragment are listed, with their extras.
#include "common/pipeline/unnamed_nodes.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "common/mesh/source_tree.hpp"
#include "common/solid/solid.hpp"

namespace fracture::test {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

/// One triangle for each name.
Mesh mesh_of(std::vector<std::string> names) {
  Mesh mesh;
  for (std::uint32_t k = 0; k < names.size(); ++k) {
    mesh.triangles.push_back({0, 1, 2});
    mesh.node.push_back(k);
  }
  mesh.node_names = std::move(names);
  return mesh;
}

std::vector<std::string> listed(const Mesh& mesh, const std::vector<std::uint32_t>& nodes,
                                const FragmentSet& set = {}) {
  std::vector<Dropped> dropped;
  add_unnamed_nodes(mesh, nodes, set, dropped, kUninterrupted);
  std::vector<std::string> texts;
  for (const Dropped& entry : dropped) texts.push_back(entry.what + " " + entry.name);
  return texts;
}

TEST(UnnamedNodes, AreThoseThatNoFragmentIsNamedAfter) {
  const Mesh mesh = mesh_of({"Helmet", "Strap", "Lens"});
  EXPECT_THAT(listed(mesh, {0, 0, 0}), ElementsAre("node Strap", "node Lens"));
  EXPECT_THAT(listed(mesh, {0, 2, 1}), IsEmpty());
}

TEST(UnnamedNodes, WithANameThatAnotherNodeHasLoseOnlyTheirExtras) {
  Mesh mesh = mesh_of({"Leaf", "Leaf", "Trunk"});
  EXPECT_THAT(listed(mesh, {0, 2}), IsEmpty());
  mesh.node_extras = {"\"a\":1", "\"a\":2", "\"a\":3"};
  EXPECT_THAT(listed(mesh, {0}), ElementsAre("extras Leaf", "extras Trunk", "node Trunk"));
}

TEST(UnnamedNodes, ThatStayWholeHaveTheirNames) {
  Mesh mesh = mesh_of({"Wall", "Window", "Sign"});
  mesh.node = {0, 2};  // the window is not fractured
  mesh.triangles.pop_back();
  auto rest = std::make_shared<Mesh>(mesh_of({"Wall", "Window", "Sign"}));
  rest->node = {1};
  mesh.passed_through = rest;
  EXPECT_THAT(listed(mesh, {0}), ElementsAre("node Sign"));
  FragmentSet set;
  auto sheets = std::make_shared<Sheets>();
  sheets->triangles = {1};  // the sign
  set.whole_sheets = sheets;
  EXPECT_THAT(listed(mesh, {0}, set), IsEmpty());
}

TEST(UnnamedNodes, ThoseWithoutAMeshHaveNoGroupIfThereAreLevels) {
  Mesh mesh = mesh_of({"Wall", "Roof"});
  mesh.triangles.pop_back();  // the roof is not in this mesh
  mesh.node.pop_back();
  const auto without_group = [&] {
    std::vector<Dropped> dropped;
    add_nodes_without_group(mesh, dropped, kUninterrupted);
    return dropped;
  };
  EXPECT_THAT(without_group(), IsEmpty());
  mesh.source_tree = std::make_shared<const SourceTree>(SourceTree{
      {{"Street", kNoIndex}, {"House", 0, "\"floors\":2"}, {"Wall", 1}, {"Shed", 0}, {"Roof", 3}}, {2, 4}});
  const char* const reason = "answers with levels have no groups";
  EXPECT_THAT(without_group(),
              ElementsAre(Dropped{"node", "Street", reason}, Dropped{"node", "House", reason},
                          Dropped{"extras", "House", reason}));
}

TEST(UnnamedNodes, AMeshWithoutNodesHasNone) {
  Mesh mesh;
  mesh.triangles = {{0, 1, 2}};
  EXPECT_THAT(listed(mesh, {0}), IsEmpty());
}

}  // namespace
}  // namespace fracture::test
