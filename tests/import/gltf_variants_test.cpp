// KHR_materials_variants: the list of variants and the mappings of each primitive are in the mesh's library.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "common/mesh/material_library.hpp"
#include "tests/import/make_files.hpp"

namespace fracture::test {
namespace {

using nlohmann::json;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

json mapping(int material, std::vector<int> variants) {
  return {{"material", material}, {"variants", std::move(variants)}};
}

/// A tetrahedron with the materials Paint, Snow and Rust, and the variants "winter" and "old".
struct Varied : Tetrahedron {
  Varied() {
    json["materials"] = {{{"name", "Paint"}}, {{"name", "Snow"}}, {{"name", "Rust"}}};
    json["extensionsUsed"] = {"KHR_materials_variants"};
    json["extensions"]["KHR_materials_variants"]["variants"] = {{{"name", "winter"}}, {{"name", "old"}}};
    json["meshes"][0]["name"] = "Box";
    primitive()["material"] = 0;
  }
  /// Sets the mappings of a primitive.
  void map(std::size_t k, nlohmann::json mappings) {
    json["meshes"][0]["primitives"][k]["extensions"]["KHR_materials_variants"]["mappings"] =
        std::move(mappings);
  }
  Mesh read() const {
    Expected<Mesh> mesh = import_text(glb(), MeshFormat::kGlb);
    EXPECT_TRUE(mesh) << (mesh ? "" : mesh.error().detail);
    return mesh ? std::move(*mesh) : Mesh{};
  }
};

TEST(GltfVariants, AreKeptWithTheMappingsOfTheirPrimitive) {
  Varied file;
  const json mappings = json::array({mapping(1, {0}), mapping(2, {1})});
  file.map(0, mappings);
  const Mesh mesh = file.read();
  const MaterialLibrary& library = *mesh.library;
  EXPECT_EQ(library.variants, json({{{"name", "winter"}}, {{"name", "old"}}}));
  EXPECT_EQ(library.materials, file.json["materials"]);
  EXPECT_EQ(library.variant_mappings,
            json::array({{{"mappings", mappings}}, json::object(), json::object()}));
  EXPECT_THAT(library.extensions_used, ElementsAre("KHR_materials_variants"));
  EXPECT_THAT(library.extensions_required, IsEmpty());
  EXPECT_THAT(mesh.dropped, IsEmpty());
  EXPECT_THAT(looks_of(library, 0), ElementsAre(0u, 1u, 2u));
  EXPECT_THAT(looks_of(library, 1), ElementsAre(1u));
}

TEST(GltfVariants, PrimitivesWithOneMaterialAndDifferentMappingsHaveDifferentMaterials) {
  Varied file;
  json& primitives = file.json["meshes"][0]["primitives"];
  for (int k = 0; k < 4; ++k) primitives.push_back(primitives[0]);
  primitives[4].erase("material");
  file.map(1, json::array({mapping(1, {0, 1})}));
  file.map(2, json::array({mapping(2, {1})}));
  file.map(3, json::array({mapping(1, {0, 1})}));
  file.map(4, json::array({mapping(2, {0})}));
  const Mesh mesh = file.read();
  ASSERT_EQ(mesh.triangles.size(), 20u);
  std::vector<std::uint32_t> of_primitives;  // the tetrahedron has four triangles
  for (std::size_t t = 0; t < 20; t += 4) of_primitives.push_back(mesh.material[t]);
  EXPECT_THAT(of_primitives, ElementsAre(0u, 3u, 4u, 3u, 5u));
  const MaterialLibrary& library = *mesh.library;
  ASSERT_EQ(library.materials.size(), 6u);
  EXPECT_EQ(library.materials[3]["name"], "Paint");
  EXPECT_EQ(library.materials[4]["name"], "Paint");
  EXPECT_EQ(library.materials[5], json::object()) << "the default material of glTF";
  ASSERT_EQ(library.variant_mappings.size(), 6u);
  EXPECT_EQ(library.variant_mappings[0], json::object());
  EXPECT_EQ(library.variant_mappings[3]["mappings"], json::array({mapping(1, {0, 1})}));
  EXPECT_EQ(library.variant_mappings[4]["mappings"], json::array({mapping(2, {1})}));
  EXPECT_EQ(library.variant_mappings[5]["mappings"], json::array({mapping(2, {0})}));
}

TEST(GltfVariants, MappingsThatNameNothingAreListed) {
  Varied file;
  file.map(0, json::array({mapping(3, {0}), mapping(1, {2}), 7, mapping(1, {1})}));
  const Mesh mesh = file.read();
  EXPECT_EQ(mesh.library->variant_mappings[0]["mappings"], json::array({mapping(1, {1})}));
  ASSERT_EQ(mesh.dropped.size(), 1u) << "equal entries are listed once";
  EXPECT_EQ(mesh.dropped[0].what + " " + mesh.dropped[0].name, "material variant a primitive of Box");
}

TEST(GltfVariants, MappingsWithoutAListOfVariantsAreDropped) {
  Varied file;
  file.map(0, json::array({mapping(1, {0})}));
  file.json.erase("extensions");
  const Mesh mesh = file.read();
  EXPECT_THAT(mesh.library->variant_mappings, IsEmpty());
  EXPECT_THAT(mesh.library->extensions_used, IsEmpty());
  ASSERT_EQ(mesh.dropped.size(), 1u);
  EXPECT_EQ(mesh.dropped[0].what + " " + mesh.dropped[0].name, "extension KHR_materials_variants");
}

TEST(GltfVariants, ANormalMapOfAVariantGivesTheMeshTangents) {
  Varied file;
  std::string uvs;
  put<float>(uvs, {0, 0, 1, 0, 0, 1, 1, 1});
  file.primitive()["attributes"]["TEXCOORD_0"] = file.add_accessor(uvs, 5126, 4, "VEC2");
  file.json["images"] = {{{"uri", "data:image/png;base64,iVBORw0KGgo="}}};  // the signature of a PNG
  file.json["textures"] = {{{"source", 0}}};
  file.json["materials"][1]["normalTexture"] = {{"index", 0}};
  EXPECT_THAT(file.read().attributes.tangents, IsEmpty()) << "no surface has this material";
  file.map(0, json::array({mapping(1, {0})}));
  EXPECT_EQ(file.read().attributes.tangents.size(), 4u);
}

}  // namespace
}  // namespace fracture::test
