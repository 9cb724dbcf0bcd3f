// Which instances share a shape: those of one material, and only without sheets.
#include <gtest/gtest.h>

#include <set>

#include "common/gltf/gltf_writer.hpp"
#include "common/outputs/answer.hpp"
#include "tests/gltf/glb_file.hpp"
#include "tests/instances/scenes.hpp"

namespace fracture::test {
namespace {

using nlohmann::json;

constexpr std::size_t kTufts = 12;

FractureParameters four_fragments() {
  FractureParameters p;
  p.sites = p.size.fragments = 4;
  p.seed = 7;
  p.hulls = Hulls::kConvex;
  return p;
}

const json& report_of(const Glb& glb) { return glb.document["nodes"][0]["extras"]["fracture"]["report"]; }

TEST(SharedShapes, InstancesOfDifferentMaterialsShareNone) {
  const Grass grass(6);
  FractureParameters p = four_fragments(), cubes;
  cubes.pattern = GridPattern{};
  p.assigned = {{{.nodes = {"0", "1", "2", "3"}}, std::make_shared<const FractureParameters>(cubes), 2, 0.5}};
  const Fractured made = fracture_solid(solid_of_glb(grass.glb(meadow(kTufts))), p);
  ASSERT_EQ(made.set.fragments.size(), kTufts) << "each tuft stays whole, as without 'assign'";
  const Glb glb(write_glb(made, {}));
  EXPECT_EQ(report_of(glb)["instances"], (json{{"fragments", kTufts}, {"shapes", 2}}));
  std::set<std::size_t> meshes[2];
  std::set<std::uint64_t> numbers[2];
  const std::vector<json> nodes = bodies_of(glb.document);
  ASSERT_EQ(nodes.size(), kTufts);
  for (std::size_t k = 0; k < kTufts; ++k) {
    const std::size_t assigned = made.set.fragments[k].node < 4 ? 1 : 0;
    EXPECT_EQ(made.set.fragments[k].density_share, assigned == 1 ? 2 : 1);
    meshes[assigned].insert(nodes[k]["mesh"].get<std::size_t>());
    numbers[assigned].insert(nodes[k]["extras"]["fracture"]["shape"].get<std::uint64_t>());
  }
  for (const auto& of_material : meshes) EXPECT_EQ(of_material.size(), 1u);
  for (const auto& of_material : numbers) EXPECT_EQ(of_material.size(), 1u);
  EXPECT_NE(meshes[0], meshes[1]);
  EXPECT_NE(numbers[0], numbers[1]);
}

/// Appends a triangle of 0.1 mm below the foot of the first tuft, which is at the origin.
void add_sheet(Mesh& mesh) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  const auto repeat = [](auto& values) {
    for (int k = 0; k < 3 && !values.empty(); ++k) values.push_back(values[0]);
  };
  for (const Vec3f& p :
       {Vec3f{0.0080f, -0.0005f, 0}, Vec3f{0.0081f, -0.0005f, 0}, Vec3f{0.0080f, -0.0005f, 0.0001f}})
    mesh.positions.push_back(p);
  repeat(mesh.attributes.normals);
  repeat(mesh.attributes.tangents);
  for (auto& set : mesh.attributes.uvs) repeat(set);
  for (auto& set : mesh.attributes.colors) repeat(set);
  mesh.triangles.push_back({first, first + 1, first + 2});
  mesh.material.push_back(mesh.material[0]);
  mesh.node.push_back(0);
  if (!mesh.triangle_color.empty()) mesh.triangle_color.push_back(mesh.triangle_color[0]);
}

TEST(SharedShapes, AnInstanceThatCarriesASheetHasAMeshOfItsOwn) {
  const Grass grass(6);
  Mesh mesh = import_text(grass.glb(meadow(kTufts)), MeshFormat::kGlb).value();
  add_sheet(mesh);
  Solid solid = make_solid(std::make_shared<Mesh>(std::move(mesh)), {}, {}).value();
  keep_contacts(solid, {}, {});
  keep_instances(solid, {});
  ASSERT_TRUE(solid.sheets);
  ASSERT_TRUE(solid.instances);
  const Fractured made = fracture_solid(std::move(solid), four_fragments());
  ASSERT_EQ(made.set.fragments.size(), kTufts);
  const std::vector<std::uint8_t> bytes = write_glb(made, {});
  const Glb glb(bytes);
  EXPECT_EQ(report_of(glb)["instances"], (json{{"fragments", kTufts - 1}, {"shapes", 1}}));
  const std::vector<json> nodes = bodies_of(glb.document);
  std::size_t carriers = 0;
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    if (!made.set.fragments[k].sheet) continue;
    ++carriers;
    EXPECT_EQ(made.set.fragments[k].node, 0u);
    EXPECT_FALSE(nodes[k].contains("rotation") || nodes[k].contains("scale")) << "its sheet is not turned";
    EXPECT_FALSE(nodes[k]["extras"]["fracture"].contains("shape"));
    const json& sheet = glb.document["nodes"].at(nodes[k]["children"].back().get<std::size_t>());
    EXPECT_EQ(sheet["name"], nodes[k]["name"].get<std::string>() + "_sheet");
    EXPECT_EQ(glb.document["meshes"].at(sheet["mesh"].get<std::size_t>())["name"], sheet["name"]);
  }
  EXPECT_EQ(carriers, 1u);
  const auto answer = outputs::read_answer(bytes);
  ASSERT_TRUE(answer) << answer.error().detail;
  EXPECT_EQ(answer->objects.size(), kTufts + 1);
}

}  // namespace
}  // namespace fracture::test
