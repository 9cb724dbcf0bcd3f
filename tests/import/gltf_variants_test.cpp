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
  for (int k = 0; k < 3; ++k) primitives.push_back(primitives[0]);
  file.map(1, json::array({mapping(1, {0, 1})}));
  file.map(2, json::array({mapping(2, {1})}));
  file.map(3, json::array({mapping(1, {0, 1})}));
  const Mesh mesh = file.read();
  ASSERT_EQ(mesh.triangles.size(), 16u);
  std::vector<std::uint32_t> of_primitives;  // the tetrahedron has four triangles
  for (std::size_t t = 0; t < 16; t += 4) of_primitives.push_back(mesh.material[t]);
  EXPECT_THAT(of_primitives, ElementsAre(0u, 3u, 4u, 3u));
  const MaterialLibrary& library = *mesh.library;
  ASSERT_EQ(library.materials.size(), 5u);
  EXPECT_EQ(library.materials[3]["name"], "Paint");
  EXPECT_EQ(library.materials[4]["name"], "Paint");
  ASSERT_EQ(library.variant_mappings.size(), 5u);
  EXPECT_EQ(library.variant_mappings[0], json::object());
  EXPECT_EQ(library.variant_mappings[3]["mappings"], json::array({mapping(1, {0, 1})}));
  EXPECT_EQ(library.variant_mappings[4]["mappings"], json::array({mapping(2, {1})}));
}

TEST(GltfVariants, APrimitiveWithoutAMaterialHasNone) {
  Varied file;
  file.primitive().erase("material");
  file.map(0, json::array({mapping(2, {0})}));
  const Mesh mesh = file.read();
  EXPECT_EQ(mesh.material[0], kNoIndex);
  EXPECT_EQ(mesh.library->materials.size(), 3u);
  EXPECT_THAT(mesh.library->variant_mappings, IsEmpty());
  ASSERT_EQ(mesh.dropped.size(), 1u);
  EXPECT_EQ(to_text(mesh.dropped[0]), "material variant a primitive of Box: its primitive has no material");
}

TEST(GltfVariants, MappingsThatWouldMakeEachFragmentLongAreListed) {
  Varied file;
  json long_one = mapping(1, {0});
  long_one["name"] = std::string(4096, 'a');
  file.map(0, json::array({long_one}));
  const Mesh mesh = file.read();
  EXPECT_THAT(mesh.library->variant_mappings, IsEmpty());
  ASSERT_EQ(mesh.dropped.size(), 1u);
  EXPECT_EQ(to_text(mesh.dropped[0]),
            "material variant a primitive of Box: its mappings are too long to be copied to each fragment");
}

// 20 primitives have one material of 1 MB and different mappings. Each needs a copy of the material, and 19 copies need 19 MB, so
// they fit into 32 MiB, but not next to further materials.
TEST(GltfVariants, AreDroppedIfTheyDoNotFitNextToTheMaterials) {
  for (const bool others : {false, true}) {
    SCOPED_TRACE(others);
    Varied file;
    file.json["materials"][0]["extras"]["text"] = std::string(1'000'000, 'a');
    if (others)
      for (int k = 1; k < 3; ++k)
        file.json["materials"][static_cast<std::size_t>(k)]["extras"]["text"] = std::string(8'000'000, 'a');
    json& variants = file.json["extensions"]["KHR_materials_variants"]["variants"];
    for (int k = 2; k < 20; ++k) variants.push_back({{"name", std::to_string(k)}});
    json& primitives = file.json["meshes"][0]["primitives"];
    for (int k = 1; k < 20; ++k) primitives.push_back(primitives[0]);
    for (int k = 0; k < 20; ++k) file.map(static_cast<std::size_t>(k), json::array({mapping(1, {k})}));
    const Mesh mesh = file.read();
    EXPECT_EQ(mesh.library->materials.size(), others ? 3u : 22u);
    EXPECT_EQ(mesh.library->variants.empty(), others);
    EXPECT_EQ(mesh.dropped.size(), others ? 20u : 0u);
  }
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
