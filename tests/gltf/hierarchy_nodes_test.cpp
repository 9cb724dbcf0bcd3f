// A hierarchy in the file: nodes without a mesh or a transform, and the same hierarchy as figures by id.
#include <gtest/gtest.h>

#include "common/gltf/gltf_writer.hpp"

#include "tests/gltf/glb_file.hpp"
#include "tests/gltf/two_halves.hpp"

namespace fracture::test {
namespace {

using nlohmann::json;

/// One cluster of both halves, with one cluster for each half below it.
FracturedSolid two_halves_in_levels() {
  FracturedSolid made = two_halves();
  made.hierarchy.levels.resize(2);
  made.hierarchy.levels[0].clusters = {{11, kNoIndex, 2, 2.0, 1, {1, 0.5, 0.5}}};
  made.hierarchy.levels[1].clusters = {{21, 0, 1, 1.0, 1, {0.5, 0.5, 0.5}},
                                       {22, 0, 1, 1.0, 1, {1.5, 0.5, 0.5}}};
  made.hierarchy.levels[1].bonds = made.set.bonds;
  made.hierarchy.cluster_of_fragment = {0, 1};
  made.anchored = {.held = {0, 1}, .count = 1};
  return made;
}

TEST(GltfHierarchy, ClustersAreNodesWithoutTransformBehindAllOthers) {
  const json nodes = Glb(write_glb(two_halves_in_levels(), {})).document["nodes"];
  ASSERT_EQ(nodes.size(), 6u);
  EXPECT_EQ(nodes[0]["children"], json({3}));
  EXPECT_EQ(nodes[3]["children"], json({4, 5}));
  EXPECT_EQ(nodes[4]["children"], json({1}));
  EXPECT_EQ(nodes[5]["children"], json({2}));
  EXPECT_EQ(nodes[3]["name"], "Cluster_0_0");
  EXPECT_EQ(nodes[5]["name"], "Cluster_1_1");
  for (std::size_t k = 3; k < 6; ++k)
    for (const char* key : {"mesh", "translation", "rotation", "scale", "matrix", "extensions"})
      EXPECT_FALSE(nodes[k].contains(key));
}

TEST(GltfHierarchy, LevelAndParentStandInTheExtrasOfFragmentsAndClusters) {
  GltfOptions options;
  options.density = 500;
  const FracturedSolid made = two_halves_in_levels();
  const json nodes = Glb(write_glb(made, options)).document["nodes"];
  const auto extras = [&](std::size_t node) { return nodes[node]["extras"]["fracture"]; };
  EXPECT_EQ(extras(1)["level"], 2);
  EXPECT_EQ(extras(1)["parent"], 21);
  EXPECT_EQ(extras(2)["parent"], 22);
  EXPECT_EQ(extras(1)["anchored"], false);
  EXPECT_EQ(extras(2)["anchored"], true);
  EXPECT_EQ(extras(4), json({{"cluster", 21},
                             {"level", 1},
                             {"parent", 11},
                             {"fragments", 1},
                             {"volume", 1.0},
                             {"mass", 500.0},
                             {"center_of_mass", {0.5, 0.5, 0.5}}}));
  EXPECT_TRUE(extras(3)["parent"].is_null());
  EXPECT_EQ(extras(3)["mass"], 1000.0);

  const json levels = extras(0)["levels"];
  ASSERT_EQ(levels.size(), 2u);
  EXPECT_EQ(levels[0]["id"], json({11}));
  EXPECT_FALSE(levels[0].contains("parent"));
  EXPECT_EQ(levels[1]["parent"], json({11, 11}));
  EXPECT_EQ(levels[1]["bonds"]["a"], json({21}));
  EXPECT_EQ(levels[1]["bonds"]["b"], json({22}));
  EXPECT_EQ(levels[1]["bonds"]["area"], json({1.0}));
  EXPECT_EQ(fracture_extras(made, options)["levels"], levels);
}

TEST(GltfHierarchy, NamesOfClustersAreFreeOfThoseOfTheSource) {
  FracturedSolid made = two_halves_in_levels();
  auto source = std::make_shared<Mesh>(*made.set.source);
  source->node_names = {"Cluster_0"};
  made.set.source = source;
  const json nodes = Glb(write_glb(made, {})).document["nodes"];
  EXPECT_EQ(nodes[1]["name"], "Cluster_0_0");
  EXPECT_EQ(nodes[3]["name"], "Cluster2_0_0");
}

TEST(GltfHierarchy, WithoutLevelsNothingOfItIsThere) {
  const json document = Glb(write_glb(two_halves(), {})).document;
  EXPECT_EQ(document["nodes"].size(), 3u);
  EXPECT_FALSE(document["nodes"][0]["extras"]["fracture"].contains("levels"));
}

}  // namespace
}  // namespace fracture::test
