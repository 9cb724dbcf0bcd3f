// Compares the file with the specification and with the input. The file is read back by the importer and by
// hand.
#include "common/gltf/gltf_writer.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <set>

#include "common/gltf/json_text.hpp"
#include "common/gltf/names.hpp"
#include "common/import/import.hpp"
#include "common/mesh/material_library.hpp"
#include "common/solid/solid.hpp"
#include "tests/gltf/glb_file.hpp"
#include "tests/gltf/two_halves.hpp"

namespace fracture::test {
namespace {

using nlohmann::json;

TEST(GltfWriter, SameInputSameBytes) { EXPECT_EQ(write_glb(two_halves(), {}), write_glb(two_halves(), {})); }

TEST(GltfWriter, OneIdentityRootAndOneNodeForEachFragmentAtItsPivot) {
  const Glb glb(write_glb(two_halves(), {}));
  const json& nodes = glb.document["nodes"];
  ASSERT_EQ(nodes.size(), 3u);
  EXPECT_EQ(glb.document["scenes"][0]["nodes"], json::array({0}));
  EXPECT_EQ(nodes[0]["children"], json({1, 2}));
  for (const char* key : {"translation", "rotation", "scale", "matrix"}) EXPECT_FALSE(nodes[0].contains(key));
  EXPECT_EQ(nodes[1]["translation"], json({0.5, 0.5, 0.5}));
  EXPECT_EQ(nodes[2]["translation"], json({1.5, 0.5, 0.5}));
  EXPECT_FALSE(glb.document.contains("extensionsRequired"));
}

TEST(GltfWriter, PositionsAndAttributesAreBitForBitThoseOfTheFragments) {
  const FracturedSolid made = two_halves();
  const Glb glb(write_glb(made, {}));
  for (std::size_t k = 0; k < made.set.fragments.size(); ++k) {
    const Fragment& f = made.set.fragments[k];
    const json& attributes = glb.document["meshes"][k]["primitives"][0]["attributes"];
    EXPECT_EQ(glb.read<Vec3f>(attributes["POSITION"]), f.positions);
    EXPECT_EQ(glb.read<Vec3f>(attributes["NORMAL"]), f.attributes.normals);
    EXPECT_EQ(glb.read<Vec4f>(attributes["TANGENT"]), f.attributes.tangents);
    EXPECT_EQ(glb.read<Vec2f>(attributes["TEXCOORD_0"]), f.attributes.uvs[0]);
    EXPECT_EQ(glb.read<Vec2f>(attributes["TEXCOORD_1"]), f.attributes.uvs[1]);
    EXPECT_EQ(glb.read<Vec4f>(attributes["COLOR_0"]), f.attributes.colors[0]);
  }
}

TEST(GltfWriter, PrimitivesShareAttributesAndCoverTheIndicesInOrder) {
  const FracturedSolid made = two_halves();
  const Glb glb(write_glb(made, {}));
  for (std::size_t k = 0; k < made.set.fragments.size(); ++k) {
    const json& primitives = glb.document["meshes"][k]["primitives"];
    ASSERT_EQ(primitives.size(), 3u);
    std::vector<std::uint32_t> indices;
    std::set<std::size_t> views;
    for (const json& primitive : primitives) {
      EXPECT_EQ(primitive["attributes"]["POSITION"], primitives[0]["attributes"]["POSITION"]);
      views.insert(glb.document["accessors"][primitive["indices"].get<std::size_t>()]["bufferView"]
                       .get<std::size_t>());
      for (const std::uint16_t index : glb.read<std::uint16_t>(primitive["indices"]))
        indices.push_back(index);
    }
    EXPECT_EQ(indices, made.set.fragments[k].indices);
    EXPECT_EQ(views.size(), 1u);
  }
}

TEST(GltfWriter, FragmentsCarryTheExtrasOfTheirSourceNodes) {
  FracturedSolid made = two_halves();
  auto mesh = std::make_shared<Mesh>(*made.set.source);
  mesh->node_names = {"crate", "lid"};
  made.set.source = mesh;
  made.set.fragments[1].node = 1;
  const std::vector<std::uint8_t> without = write_glb(made, {});
  mesh->node_extras = {"\"hp\":120,\"loot\":[\"gem\"]", ""};
  const Glb glb(write_glb(made, {}));
  json extras = glb.document["nodes"][1]["extras"];
  EXPECT_EQ(extras["hp"], 120);
  EXPECT_EQ(extras["loot"], json::array({"gem"}));
  EXPECT_EQ(extras.size(), 3u) << "and those of the fragment";
  extras.erase("hp");
  extras.erase("loot");
  const Glb plain(without);
  EXPECT_EQ(extras, plain.document["nodes"][1]["extras"]);
  EXPECT_EQ(glb.document["nodes"][2], plain.document["nodes"][2]) << "the lid has none";
}

TEST(GltfWriter, NodesWithoutAMeshAreTheLastOnesBelowTheRoot) {
  FracturedSolid made = two_halves();
  const Glb plain(write_glb(made, {}));
  auto mesh = std::make_shared<Mesh>(*made.set.source);
  mesh->empty_nodes = {{.name = "socket", .t = {1, 2, 3}, .extras = "\"hp\":1"},
                       {.name = "socket", .x = {0, 0, -2}, .z = {2, 0, 0}, .t = {4, 5, 6}},
                       {.name = "origin"}};
  made.set.source = mesh;
  const Glb glb(write_glb(made, {}));
  const json& nodes = glb.document["nodes"];
  ASSERT_EQ(nodes.size(), plain.document["nodes"].size() + 3);
  EXPECT_EQ(nodes[0]["children"], json({1, 2, 3, 4, 5}));
  EXPECT_EQ(nodes[3], json::parse(R"({"name": "socket", "translation": [1, 2, 3], "extras": {"hp": 1}})"));
  EXPECT_EQ(nodes[4], json::parse(R"({"name": "socket_2", "matrix": [0, 0, -2, 0,  0, 1, 0, 0,  2, 0, 0, 0,
                                      4, 5, 6, 1]})"));
  EXPECT_EQ(nodes[5], json::parse(R"({"name": "origin"})"));
  for (const char* list : {"meshes", "accessors", "materials"})
    EXPECT_EQ(glb.document[list], plain.document[list]) << list;
  for (std::size_t k = 1; k < 3; ++k) EXPECT_EQ(nodes[k], plain.document["nodes"][k]);
}

TEST(GltfWriter, SourceMaterialsComeFirstInOrderThenTheInterior) {
  const FracturedSolid made = two_halves();
  const Glb glb(write_glb(made, {}));
  const json& materials = glb.document["materials"];
  ASSERT_EQ(materials.size(), 3u);
  EXPECT_EQ(materials[0], made.set.source->library->materials[0]);
  EXPECT_EQ(materials[1], made.set.source->library->materials[1]);
  EXPECT_THAT(materials[2]["name"].get<std::string>(), ::testing::HasSubstr("Interior"));
  const json& primitives = glb.document["meshes"][0]["primitives"];
  EXPECT_EQ(primitives[0]["material"], 0);
  EXPECT_EQ(primitives[1]["material"], 1);
  EXPECT_EQ(primitives[2]["material"], 2);
}

TEST(GltfWriter, TangentsStandExactlyWhereAMaterialHasANormalMap) {
  FracturedSolid made = two_halves();
  const json primitives = Glb(write_glb(made, {})).document["meshes"][0]["primitives"];
  EXPECT_TRUE(primitives[0]["attributes"].contains("TANGENT"));
  EXPECT_FALSE(primitives[1]["attributes"].contains("TANGENT"));
  EXPECT_FALSE(primitives[2]["attributes"].contains("TANGENT"));
}

TEST(GltfWriter, PrimitivesOfTheOutsideKeepTheirVariants) {
  FracturedSolid made = two_halves();
  auto mesh = std::make_shared<Mesh>(*made.set.source);
  auto library = std::make_shared<MaterialLibrary>(*mesh->library);
  const json mapping = {{"material", 0}, {"variants", json::array({0})}};
  const json mappings = {{"mappings", json::array({mapping})}};
  library->variants = json::array({{{"name", "winter"}}});
  library->variant_mappings = json::array({json::object(), mappings});  // paint becomes wood
  library->extensions_used = {"KHR_materials_variants"};
  mesh->library = library;
  made.set.source = mesh;
  for (const Physics physics : {Physics::kNone, Physics::kKhr}) {
    GltfOptions options;
    options.physics = physics;
    const json document = Glb(write_glb(made, options)).document;
    EXPECT_EQ(document["extensions"]["KHR_materials_variants"]["variants"], library->variants);
    EXPECT_EQ(document["extensions"].size(), physics == Physics::kNone ? 1u : 2u);
    EXPECT_EQ(document["extensionsUsed"][0], "KHR_materials_variants");
    const json& primitives = document["meshes"][0]["primitives"];
    EXPECT_FALSE(primitives[0].contains("extensions"));
    EXPECT_EQ(primitives[1]["extensions"]["KHR_materials_variants"], mappings);
    EXPECT_FALSE(primitives[2].contains("extensions")) << "cuts have the interior material in every variant";
    EXPECT_TRUE(primitives[1]["attributes"].contains("TANGENT")) << "wood has a normal map";
  }
}

TEST(GltfWriter, PrimitiveWithoutMaterialNamesNone) {
  FracturedSolid made = two_halves();
  made.set.fragments[0].primitives[1].material = kNoIndex;
  EXPECT_FALSE(Glb(write_glb(made, {})).document["meshes"][0]["primitives"][1].contains("material"));
}

TEST(GltfWriter, ImagesPassThroughByteForByte) {
  const FracturedSolid made = two_halves();
  const Glb glb(write_glb(made, {}));
  const json& view = glb.document["bufferViews"][glb.document["images"][0]["bufferView"].get<std::size_t>()];
  const auto& source = made.set.source->library->images[0].bytes;
  ASSERT_EQ(view["byteLength"], source.size());
  EXPECT_FALSE(view.contains("target"));
  EXPECT_EQ(std::memcmp(&glb.binary.at(view["byteOffset"].get<std::size_t>()), source.data(), source.size()),
            0);
}

TEST(GltfWriter, ViewsAreAlignedAndSayWhatTheyAreFor) {
  GltfOptions options;
  options.mesh_manifold = false;  // whose merges are neither vertices nor indices: no target
  const Glb glb(write_glb(two_halves_with_hulls(), options));
  for (const json& accessor : glb.document["accessors"]) {
    const json& view = glb.document["bufferViews"][accessor["bufferView"].get<std::size_t>()];
    const bool index = accessor["type"] == "SCALAR";
    EXPECT_EQ(view["target"], index ? 34963 : 34962);
    EXPECT_EQ(view.contains("byteStride"), !index);
    EXPECT_EQ(view.value("byteOffset", 0u) % 4, 0u);
    EXPECT_EQ(accessor.value("byteOffset", 0u) % (index ? 2 : 4), 0u);
  }
}

TEST(GltfWriter, PositionBoundsAreTheStoredFloats) {
  FracturedSolid made = two_halves();
  made.set.fragments[0].positions[0] = {0.1f, -0.3f, 1e-20f};
  const Glb glb(write_glb(made, {}));
  const json& accessor =
      glb.document["accessors"]
                  [glb.document["meshes"][0]["primitives"][0]["attributes"]["POSITION"].get<std::size_t>()];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double low = std::numeric_limits<double>::max(), high = -low;
    for (const Vec3f& p : made.set.fragments[0].positions) {
      low = std::min(low, to_double(p)[static_cast<int>(axis)]);
      high = std::max(high, to_double(p)[static_cast<int>(axis)]);
    }
    EXPECT_EQ(accessor["min"][axis].get<double>(), low);
    EXPECT_EQ(accessor["max"][axis].get<double>(), high);
  }
}

/// One triangle fan over n vertices: only the number matters.
FracturedSolid fragment_with_vertices(std::uint32_t n) {
  FracturedSolid made = two_halves();
  made.set.bonds.clear();
  made.set.fragments.resize(1);
  Fragment& f = made.set.fragments[0];
  f.attributes = {};
  f.topology.clear();
  f.positions.resize(n);
  for (std::uint32_t k = 0; k < n; ++k)
    f.positions[k] = {static_cast<float>(k), static_cast<float>(k % 7), 0};
  f.indices = {0, 1, n - 1};
  f.primitives = {{kNoIndex, 0, 3}};
  return made;
}

TEST(GltfWriter, IndicesHave16BitsUpTo65535VerticesAnd32Beyond) {
  const Glb narrow(write_glb(fragment_with_vertices(65535), {})),
      wide(write_glb(fragment_with_vertices(65536), {}));
  const auto type = [](const Glb& glb) {
    return glb.document["accessors"][glb.document["meshes"][0]["primitives"][0]["indices"].get<std::size_t>()]
                       ["componentType"];
  };
  EXPECT_EQ(type(narrow), 5123);
  EXPECT_EQ(type(wide), 5125);
  EXPECT_EQ(narrow.read<std::uint16_t>(narrow.document["meshes"][0]["primitives"][0]["indices"])[2], 65534);
  EXPECT_EQ(wide.read<std::uint32_t>(wide.document["meshes"][0]["primitives"][0]["indices"])[2], 65535u);
}

TEST(GltfWriter, NormalsAndTangentsWithoutLengthAreMended) {
  FracturedSolid made = two_halves();
  Fragment& f = made.set.fragments[0];
  f.attributes.normals[0] = {};
  f.attributes.normals[1] = {0, 0, 5};
  f.attributes.tangents[0] = {};
  f.attributes.tangents[1] = {3, 0, 0, -0.5f};
  const Glb glb(write_glb(made, {}));
  const json& attributes = glb.document["meshes"][0]["primitives"][0]["attributes"];
  const auto normals = glb.read<Vec3f>(attributes["NORMAL"]);
  EXPECT_EQ(normals[0], (Vec3f{0, 0, 1}));  // of the triangle: the face z = const
  EXPECT_EQ(normals[1], (Vec3f{0, 0, 1}));
  const auto tangents = glb.read<Vec4f>(attributes["TANGENT"]);
  EXPECT_NEAR(length({tangents[0].x, tangents[0].y, tangents[0].z}), 1, 1e-6);
  EXPECT_EQ(std::abs(tangents[0].w), 1);
  EXPECT_EQ(tangents[1], (Vec4f{1, 0, 0, -1}));
}

TEST(GltfWriter, NamesAreUniqueAndBeginWithTheSourceNode) {
  const Glb glb(write_glb(two_halves(), {}));
  EXPECT_EQ(glb.document["nodes"][1]["name"], "Kiste_\xc3\xa4__1__0");
  EXPECT_EQ(glb.document["nodes"][2]["name"], "Kiste_\xc3\xa4__1__1");
  EXPECT_EQ(fragment_name("mesh", 7, 1001), "mesh_0007");
  EXPECT_EQ(fragment_name("a", 0, 1), "a_0");
}

TEST(GltfWriter, ExtrasCarryFiguresBondsAndCertificateKeyedById) {
  GltfOptions options;
  options.parameters = {{"sites", 2}, {"seed", 1}};
  options.mesh_digest = "sha256:00";
  options.density = 500;
  const FracturedSolid made = two_halves();
  const json document = Glb(write_glb(made, options)).document;
  EXPECT_EQ(document["asset"]["copyright"], "CC0 \"test\"");
  EXPECT_EQ(document["asset"]["extras"]["parameters"], options.parameters);
  const json& root = document["nodes"][0]["extras"]["fracture"];
  EXPECT_EQ(root, fracture_extras(made, options));
  EXPECT_EQ(root["mesh"], "sha256:00");
  EXPECT_EQ(root["parameters"]["sites"], 2);
  EXPECT_EQ(root["certificate"]["open_edges"], 0);
  EXPECT_EQ(root["report"]["solid"]["parts"], 1);
  EXPECT_EQ(root["bonds"]["a"], json::array({9007199254740991}));
  EXPECT_EQ(root["bonds"]["b"], json::array({7}));
  EXPECT_EQ(root["bonds"]["area"], json::array({1}));
  EXPECT_EQ(root["bonds"]["centroid"], json::array({json::array({1, 0.5, 0.5})}));
  EXPECT_EQ(root["bonds"]["normal"], json::array({json::array({1, 0, 0})}));
  EXPECT_EQ(root["bonds"]["strength"], json::array({1e6}));
  const json& fragment = document["nodes"][2]["extras"]["fracture"];
  EXPECT_EQ(fragment["id"], 7);
  EXPECT_EQ(fragment["mass"], 500);
  EXPECT_EQ(fragment["sites"], json({1, 2}));
  EXPECT_TRUE(fragment["parent"].is_null());
}

TEST(GltfWriter, SitesAreTheNumbersOfThePointsThatWereGiven) {
  FracturedSolid made = two_halves();
  made.point_of_site = {0, 4, 9};
  const json document = Glb(write_glb(made, {})).document;
  EXPECT_EQ(document["nodes"][2]["extras"]["fracture"]["sites"], json({4, 9}));
}

TEST(GltfWriter, AFragmentWhoseVolumeRoundsToNothingHasThatOfItsPositions) {
  FracturedSolid made = two_halves();
  made.set.fragments[1].mass.volume = -4.6e-20;
  const json fragment = Glb(write_glb(made, {})).document["nodes"][2]["extras"]["fracture"];
  EXPECT_EQ(fragment["volume"], 1) << "the half of a box of 2 x 1 x 1";
  EXPECT_EQ(fragment["mass"].get<double>(), fragment["volume"].get<double>() * GltfOptions{}.density);
}

TEST(GltfWriter, FiguresStandWhereItSaysThatTheyStand) {
  const FracturedSolid made = two_halves();
  for (const OutputFormat format : {OutputFormat::kGlb, OutputFormat::kGltf}) {
    const GltfFile file = write_file(made, {}, format);
    EXPECT_EQ(file.bytes, format == OutputFormat::kGlb ? write_glb(made, {}) : write_gltf(made, {}));
    ASSERT_LE(file.figures.at + file.figures.size, file.bytes.size());
    const auto begin = file.bytes.begin() + static_cast<std::ptrdiff_t>(file.figures.at);
    EXPECT_EQ(json::parse(begin, begin + static_cast<std::ptrdiff_t>(file.figures.size)),
              fracture_extras(made, {}));
  }
}

TEST(GltfWriter, WhatItWritesTheImporterReadsBackInWorldSpace) {
  const std::vector<std::uint8_t> glb = write_glb(two_halves(), {});
  const Expected<Mesh> mesh =
      import_mesh({reinterpret_cast<const std::byte*>(glb.data()), glb.size()}, MeshFormat::kGlb, {});
  ASSERT_TRUE(mesh) << mesh.error().detail;
  const FracturedSolid made = two_halves();
  std::vector<Vec3f> world;
  for (const Fragment& f : made.set.fragments)
    for (const Vec3f& p : f.positions)
      world.push_back({p.x + static_cast<float>(f.pivot.x), p.y + static_cast<float>(f.pivot.y),
                       p.z + static_cast<float>(f.pivot.z)});
  // The importer reads primitives with and without tangents as two surfaces. So vertices may occur twice, but
  // triangles may not.
  ASSERT_EQ(mesh->triangles.size(), 24u);
  std::multiset<std::array<float, 9>> before, after;
  const auto corners = [](const std::vector<Vec3f>& p, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    return std::array<float, 9>{p[a].x, p[a].y, p[a].z, p[b].x, p[b].y, p[b].z, p[c].x, p[c].y, p[c].z};
  };
  std::uint32_t base = 0;
  for (const Fragment& f : made.set.fragments) {
    for (std::size_t k = 0; k < f.indices.size(); k += 3)
      before.insert(corners(world, base + f.indices[k], base + f.indices[k + 1], base + f.indices[k + 2]));
    base += static_cast<std::uint32_t>(f.positions.size());
  }
  for (const auto& t : mesh->triangles) after.insert(corners(mesh->positions, t[0], t[1], t[2]));
  EXPECT_EQ(before, after);
  EXPECT_EQ(mesh->library->materials.size(), 3u);
  EXPECT_EQ(mesh->library->images[0].bytes, made.set.source->library->images[0].bytes);
}

TEST(GltfWriter, FragmentThatContradictsItselfIsABugNotAFile) {
  const auto broken = [](auto&& change) {
    FracturedSolid made = two_halves();
    change(made.set.fragments[1]);
    return made;
  };
  EXPECT_THROW(write_glb(broken([](Fragment& f) { f.indices[0] = 1000; }), {}), InternalError);
  EXPECT_THROW(write_glb(broken([](Fragment& f) { f.attributes.normals.pop_back(); }), {}), InternalError);
  EXPECT_THROW(write_glb(broken([](Fragment& f) { f.primitives.pop_back(); }), {}), InternalError);
  EXPECT_THROW(
      write_glb(broken([](Fragment& f) { f.mass.volume = std::numeric_limits<double>::quiet_NaN(); }), {}),
      InternalError);
}

TEST(GltfWriter, ACompanionOfAnotherSetIsABugNotAFile) {
  FracturedSolid hulls = two_halves(), anchored = two_halves(), clusters = two_halves();
  hulls.hulls.of_fragment.resize(1);
  anchored.anchored.held.resize(3);
  clusters.hierarchy.cluster_of_fragment.resize(1);
  for (const FracturedSolid& made : {hulls, anchored, clusters})
    EXPECT_THROW(write_glb(made, {}), InternalError);
}

TEST(JsonText, NumbersReadBackAsTheSameDouble) {
  for (const double number : {0.1, 1.0 / 3, 5e-324, 1.7976931348623157e308, -0.0, 1e21, 123456789012345680.0,
                              static_cast<double>(0.1f)}) {
    JsonText text;
    text.value(number);
    const double back = json::parse(text.text()).get<double>();
    EXPECT_EQ(std::memcmp(&back, &number, 8), 0) << text.text();
  }
}

TEST(JsonText, StringsAreEscaped) {
  JsonText text;
  const std::string odd = std::string("a\"b\\c\n\x01") + "\xc3\xa4";
  text.begin_object().key("k").value(odd).end_object();
  EXPECT_EQ(json::parse(text.text())["k"], odd);
  JsonText nested;
  const json document = {{"a \"quoted\" key", {1, -2, 2.5, true, nullptr, {{"x", json::array()}}}}};
  nested.value(document);
  EXPECT_EQ(json::parse(nested.text()), document);
}

}  // namespace
}  // namespace fracture::test
