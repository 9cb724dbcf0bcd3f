// Sheets in the file: a mesh of their own below the fragment that carries them, or nodes of their own.
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "common/gltf/gltf_writer.hpp"
#include "common/import/import.hpp"
#include "tests/gltf/glb_file.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/fractured.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::test {
namespace {

using nlohmann::json;

/// A cube and a unit square above it, from two nodes.
Mesh cube_and_pane() {
  Mesh mesh = joined({cube(), translated(open_quad(), {-0.5, -0.5, 0.75})});
  mesh.node_names = {"Wall", "Pane"};
  mesh.node.assign(mesh.triangles.size(), 0);
  mesh.node[12] = mesh.node[13] = 1;
  mesh.material.assign(mesh.triangles.size(), kNoIndex);
  return mesh;
}

Fractured with_sheets(SheetsMode mode, bool intact = false) {
  FractureParameters p;
  p.pattern = PointsPattern{{{-0.25, 0, 0}, {0.25, 0, 0}}};
  p.hulls = Hulls::kConvex;
  p.intact = intact;
  Mesh mesh = cube_and_pane();
  return fracture_solid(make_solid(std::make_shared<Mesh>(std::move(mesh)), {.sheets = mode}, {}).value(), p);
}

Glb file_of(const Fractured& made, const GltfOptions& options = {}) { return Glb(write_glb(made, options)); }

bool is_fragment_node(const json& node) {
  return node.contains("extras") && node["extras"].contains("fracture") &&
         node["extras"]["fracture"].contains("id");
}

double area_of(const Glb& file, const json& node) {
  double area = 0;
  for (const json& p : file.document["meshes"].at(node["mesh"].get<std::size_t>())["primitives"]) {
    const auto points = file.read<Vec3f>(p["attributes"]["POSITION"]);
    const auto corners = file.read<std::uint16_t>(p["indices"]);
    for (std::size_t t = 0; t < corners.size(); t += 3) {
      const Vec3d a = to_double(points[corners[t]]);
      area +=
          0.5 * length(cross(to_double(points[corners[t + 1]]) - a, to_double(points[corners[t + 2]]) - a));
    }
  }
  return area;
}

/// Expects that every node but the roots of scenes has exactly one parent, and every mesh exactly one user or more.
void expect_one_parent_each(const Glb& file) {
  std::multiset<std::size_t> reached;
  for (const json& scene : file.document["scenes"])
    for (const json& root : scene["nodes"]) reached.insert(root.get<std::size_t>());
  for (const json& node : file.document["nodes"])
    for (const json& child : node.value("children", json::array())) reached.insert(child.get<std::size_t>());
  for (std::size_t n = 0; n < file.document["nodes"].size(); ++n) EXPECT_EQ(reached.count(n), 1u) << n;
  EXPECT_EQ(reached.size(), file.document["nodes"].size());
  std::set<std::string> names;
  for (const json& node : file.document["nodes"]) {
    EXPECT_TRUE(names.insert(node["name"].get<std::string>()).second) << node["name"];
    if (node.contains("mesh")) {
      EXPECT_LT(node["mesh"].get<std::size_t>(), file.document["meshes"].size());
    }
  }
}

TEST(SheetNodes, AreTheLastChildrenOfTheirFragmentsAndPlain) {
  for (const Physics physics : {Physics::kKhr, Physics::kOmi, Physics::kNone})
    for (const UeCollision ue : {UeCollision::kNone, UeCollision::kUcx}) {
      GltfOptions options;
      options.physics = physics;
      options.ue_collision = ue;
      const Glb file = file_of(with_sheets(SheetsMode::kAttach), options);
      expect_one_parent_each(file);
      std::size_t fragments = 0;
      for (const json& node : file.document["nodes"]) {
        if (!is_fragment_node(node)) continue;
        ++fragments;
        const json& sheet = file.document["nodes"].at(node["children"].back().get<std::size_t>());
        EXPECT_EQ(sheet["name"], node["name"].get<std::string>() + "_sheet");
        EXPECT_EQ(sheet.size(), 2u) << "only a name and a mesh: " << sheet;
        const json& mesh = file.document["meshes"].at(sheet["mesh"].get<std::size_t>());
        EXPECT_EQ(mesh["name"], sheet["name"]);
        EXPECT_FALSE(mesh.contains("extensions"));
        EXPECT_NEAR(area_of(file, sheet), 0.5, 1e-6);
        EXPECT_TRUE(file.document["meshes"].at(node["mesh"].get<std::size_t>())["extensions"].contains(
            "EXT_mesh_manifold"));
      }
      EXPECT_EQ(fragments, 2u);
    }
}

TEST(SheetNodes, LeaveTheMeshesOfFragmentsAsTheyAre) {
  const Glb with = file_of(with_sheets(SheetsMode::kAttach)),
            without = file_of(with_sheets(SheetsMode::kDrop));
  for (std::size_t k = 0; k < 2; ++k) {
    const json &a = with.document["meshes"][k], &b = without.document["meshes"][k];
    ASSERT_EQ(a["primitives"].size(), b["primitives"].size());
    for (std::size_t p = 0; p < a["primitives"].size(); ++p) {
      EXPECT_EQ(with.read<Vec3f>(a["primitives"][p]["attributes"]["POSITION"]),
                without.read<Vec3f>(b["primitives"][p]["attributes"]["POSITION"]));
      EXPECT_EQ(with.read<std::uint16_t>(a["primitives"][p]["indices"]),
                without.read<std::uint16_t>(b["primitives"][p]["indices"]));
    }
  }
  for (const json& node : without.document["nodes"])
    EXPECT_EQ(node["name"].get<std::string>().find("_sheet"), std::string::npos);
}

TEST(SheetNodes, TheCertificateStatesTheirAreaOnlyIfThereAreSheets) {
  const auto certificate = [](const Glb& file) -> json {
    return file.document["nodes"][0]["extras"]["fracture"]["certificate"];
  };
  const json with = certificate(file_of(with_sheets(SheetsMode::kAttach))),
             without = certificate(file_of(with_sheets(SheetsMode::kDrop)));
  EXPECT_EQ(with["sheet_area_in"], 1.0);
  EXPECT_NEAR(with["sheet_area_out"].get<double>(), 1, 1e-12);
  EXPECT_FALSE(without.contains("sheet_area_in"));
  EXPECT_FALSE(without.contains("sheet_area_out"));
}

TEST(SheetNodes, WholeSheetsAreANodeOfTheirOwn) {
  const Glb file = file_of(with_sheets(SheetsMode::kWhole));
  expect_one_parent_each(file);
  std::size_t found = 0;
  for (const json& child : file.document["nodes"][0]["children"]) {
    const json& node = file.document["nodes"].at(child.get<std::size_t>());
    if (!node.contains("mesh")) {
      EXPECT_EQ(node["name"], "Wall") << "the group of the fragments";
      continue;
    }
    ++found;
    EXPECT_EQ(node["name"], "Pane");
    EXPECT_NEAR(area_of(file, node), 1, 1e-6);
  }
  EXPECT_EQ(found, 1u);
}

TEST(SheetNodes, TheIntactSceneHasThemToo) {
  for (const SheetsMode mode : {SheetsMode::kAttach, SheetsMode::kWhole}) {
    const Glb file = file_of(with_sheets(mode, /*intact=*/true));
    expect_one_parent_each(file);
    double area = 0;
    const json& root =
        file.document["nodes"].at(file.document["scenes"].at(1)["nodes"].at(0).get<std::size_t>());
    std::vector<std::size_t> below;
    for (const json& child : root["children"]) below.push_back(child.get<std::size_t>());
    for (std::size_t k = 0; k < below.size(); ++k) {
      const json& node = file.document["nodes"].at(below[k]);
      for (const json& child : node.value("children", json::array()))
        below.push_back(child.get<std::size_t>());
      if (node.contains("mesh")) area += area_of(file, node);
    }
    EXPECT_NEAR(area, 6 + 1, 1e-6) << "the cube and the pane";
  }
}

TEST(SheetNodes, AnImportedAnswerHasTheAreaOfBoth) {
  GltfOptions options;
  options.physics = Physics::kNone;
  const std::vector<std::uint8_t> bytes = write_glb(with_sheets(SheetsMode::kAttach), options);
  const Expected<Mesh> mesh = import_mesh(std::as_bytes(std::span(bytes)), MeshFormat::kGlb, {});
  ASSERT_TRUE(mesh) << mesh.error().detail;
  EXPECT_NEAR(test::area_of(*mesh), 6 + 2 + 1, 1e-6) << "the cube, both sides of its cut, and the pane";
}

}  // namespace
}  // namespace fracture::test
