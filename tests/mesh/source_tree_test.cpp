// The tree of a source's nodes: common ancestors, and when it says something.
#include "common/mesh/source_tree.hpp"

#include <gtest/gtest.h>

#include <initializer_list>
#include <memory>

#include "common/mesh/mesh.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::test {
namespace {

/// 0 House {1 Floor {2 Wall, 3 Window {4 Pane}}, 5 Roof}, 6 Lamp. All except House and Floor are mesh instances; Pane is two.
Mesh house() {
  Mesh mesh;
  mesh.node_names = {"Wall", "Window", "Pane", "Pane", "Roof", "Lamp"};
  mesh.source_tree = std::make_shared<const SourceTree>(SourceTree{{{"House", kNoIndex},
                                                                    {"Floor", 0},
                                                                    {"Wall", 1},
                                                                    {"Window", 1},
                                                                    {"Pane", 3},
                                                                    {"Roof", 0},
                                                                    {"Lamp", kNoIndex}},
                                                                   {2, 3, 4, 4, 5, 6}});
  return mesh;
}

TEST(SourceTree, TheCommonAncestorIsTheNearestOne) {
  const Mesh mesh = house();
  const SourceNodes nodes(mesh);
  const auto of = [&](std::initializer_list<std::uint32_t> instances) {
    NodeRange range;
    for (const std::uint32_t instance : instances) range.add(instance);
    return nodes.common_ancestor(range);
  };
  EXPECT_EQ(of({0}), 2u);
  EXPECT_EQ(of({2, 3}), 4u) << "both are instances of the pane";
  EXPECT_EQ(of({1, 2}), 3u) << "the window is above the pane";
  EXPECT_EQ(of({0, 2}), 1u);
  EXPECT_EQ(of({2, 4, 3}), 0u);
  EXPECT_EQ(of({1, 5}), kNoIndex);
  EXPECT_EQ(of({9}), kNoIndex);
  EXPECT_EQ(of({}), kNoIndex);
}

TEST(SourceTree, WithoutOneEachInstanceIsANodeOfItsOwn) {
  Mesh mesh;
  mesh.node_names = {"a", "b"};
  const SourceNodes nodes(mesh);
  EXPECT_EQ(nodes.size(), 2u);
  EXPECT_EQ(nodes.name(1), "b");
  EXPECT_EQ(nodes.parent(1), kNoIndex);
  EXPECT_EQ(nodes.extras(1), "");
  EXPECT_EQ(nodes.common_ancestor({1, 1}), 1u);
  EXPECT_EQ(nodes.common_ancestor({0, 1}), kNoIndex);
}

TEST(SourceTree, IsAHierarchyIfItsTrianglesAreOfSeveralNodesOrBelowOne) {
  Mesh mesh = house();
  const auto is_hierarchy = [&](std::vector<std::uint32_t> triangles) {
    mesh.node = std::move(triangles);
    return SourceNodes(mesh).is_hierarchy({});
  };
  EXPECT_TRUE(is_hierarchy({0, 0}));
  EXPECT_FALSE(is_hierarchy({5, 5, 5})) << "the lamp is below nothing";
  EXPECT_TRUE(is_hierarchy({5, 5, 4}));
  EXPECT_FALSE(is_hierarchy({}));
  auto rest = std::make_shared<Mesh>(house());
  rest->node = {4};
  mesh.passed_through = rest;
  EXPECT_TRUE(is_hierarchy({5})) << "the roof stays whole";
  mesh.passed_through = nullptr;
  mesh.source_tree = nullptr;
  EXPECT_FALSE(is_hierarchy({1, 1}));
  EXPECT_TRUE(is_hierarchy({1, 2}));
}

}  // namespace
}  // namespace fracture::test
