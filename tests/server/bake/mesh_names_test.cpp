// The names in a mesh file by which rules choose their parts.
#include "server/bake/mesh_names.hpp"

#include <gtest/gtest.h>

#include <optional>
#include <set>
#include <span>
#include <string>

#include "server/bake/explain.hpp"
#include "server/bake/plan.hpp"
#include "tests/support/peak_memory.hpp"

namespace fracture::bake {
namespace {

/// Returns nothing if the mesh exceeds one of the limits of names_in().
std::optional<MeshNames> names_of(const std::string& called, const std::string& text,
                                  std::optional<MeshFormat> given = std::nullopt) {
  const Expected<MeshNames> names = names_in(called, std::as_bytes(std::span(text)), given);
  return names ? std::optional(*names) : std::nullopt;
}

TEST(MeshNamesInFile, AreThoseOfTheFile) {
  const auto names = [](const std::string& called, const std::string& text) {
    return names_of(called, text).value();
  };
  const MeshNames obj =
      names("a.obj",
            "o The  Lid \r\nv 0 0 0\n g a b\n\tusemtl\toak dark\r\nf 1 2 3\nf 1 2 4\nnewmtl no\no\n"
            "# o c\nusemtl x\n f\t1 2 3\n");
  EXPECT_EQ(obj.nodes, (std::set<std::string>{"The  Lid", "a b"}));
  EXPECT_EQ(obj.materials, (std::set<std::string>{"oak dark", "x"}));
  const std::string document =
      R"({"asset": {"version": "2.0"}, "nodes": [{"name": "lid"}, {}, 3, {"name": 4}], "meshes": [{"name": "shape"}],)"
      R"( "materials": [{"name": "oak"}]})";
  std::string glb = "glTF";
  for (const std::size_t number :
       {std::size_t{2}, 20 + document.size(), document.size(), std::size_t{0x4E4F534A}})
    for (int shift = 0; shift < 32; shift += 8) glb += static_cast<char>((number >> shift) & 255);
  for (const auto& [name, text] : {std::pair("a.gltf", document), std::pair("-", glb + document)}) {
    EXPECT_EQ(names(name, text).nodes, (std::set<std::string>{"lid", "shape"})) << name;
    EXPECT_EQ(names(name, text).materials, (std::set<std::string>{"oak"})) << name;
  }
  EXPECT_TRUE(names("a.glb", glb + document.substr(0, 30)).nodes.empty()) << "cut off";
  EXPECT_TRUE(names("a.glb", "glTF").nodes.empty());
  EXPECT_TRUE(names("a.gltf", "[]").nodes.empty());
  EXPECT_TRUE(names("a.stl", "solid oak").nodes.empty());
}

TEST(MeshNamesInFile, OfAnObjAreThoseThatItsImporterHas) {
  const auto obj = [](const std::string& text) { return names_of("a.obj", text).value(); };
  EXPECT_EQ(obj("usemtl \\\noak\nf 1 2 3\n").materials, (std::set<std::string>{"oak"}))
      << "a backslash at its end joins a line with the next";
  EXPECT_EQ(obj("usemtl oak\\\r\n_\\\r\ndark\r\nf 1 2 3\n").materials, (std::set<std::string>{"oak_dark"}));
  EXPECT_EQ(obj("o lid\\").nodes, (std::set<std::string>{"lid\\"})) << "the file ends after the backslash";
  EXPECT_EQ(obj("usemtl oak\nusemtl pine\nf 1 2 3\nusemtl iron\nl 1 2\n").materials,
            (std::set<std::string>{"pine"}))
      << "no face uses the others";
  EXPECT_EQ(obj("g lid body\n").nodes, (std::set<std::string>{"lid body"})) << "one group";
}

TEST(MeshNamesInFile, AreReadInTheFormatOfTheMesh) {
  const std::string text = "o lid\nv 0 0 0\n";
  EXPECT_TRUE(names_of("a.dat", text)->nodes.empty());
  EXPECT_EQ(names_of("a.dat", text, MeshFormat::kObj)->nodes, (std::set<std::string>{"lid"}));
  EXPECT_EQ(names_of("-", text, MeshFormat::kObj)->nodes, (std::set<std::string>{"lid"}));
  EXPECT_TRUE(names_of("a.obj", text, MeshFormat::kStl)->nodes.empty());
  const std::string gltf = R"({"nodes": [{"name": "lid"}]})";
  EXPECT_TRUE(names_of("a.obj", gltf)->nodes.empty()) << "the ending says more than the first bytes";
  BakeJob job{.input = "a.dat", .output = "b.glb", .parameters = {{"sites", "3", true}}};
  EXPECT_EQ(format_given(job), std::nullopt);
  job.parameters.push_back({"format", "obj", true});
  EXPECT_EQ(format_given(job), MeshFormat::kObj);
}

TEST(MeshNamesInFile, OfAGltfAreThoseOfNodesMeshesAndMaterials) {
  const MeshNames names = names_of("a.gltf", R"({"asset": {"name": "no"}, "name": "no", "nodes":
      [{"name": "lid", "extras": {"name": "no", "list": [{"name": "no"}]}}, [{"name": "no"}], "no", {"name": {"name": "no"}},
       {"children": [1], "name": "rim"}, {"name": ["no"]}], "scenes": [{"name": "no"}], "meshes": {"a": {"name": "no"}},
      "materials": [{"name": "oak"}], "extras": [{"nodes": [{"name": "no"}]}]})")
                              .value();
  EXPECT_EQ(names.nodes, (std::set<std::string>{"lid", "rim"}));
  EXPECT_EQ(names.materials, (std::set<std::string>{"oak"}));
}

TEST(MeshNamesInFile, BeyondTheLimitsAreRefusedAndBracketsHoldNothing) {
  std::string many;
  for (std::size_t k = 0; k < kMaxMeshNames; ++k) many += "o " + std::to_string(k) + "\n";
  ASSERT_TRUE(names_of("a.obj", many));
  EXPECT_EQ(names_of("a.obj", many)->nodes.size(), kMaxMeshNames);
  EXPECT_TRUE(names_of("a.obj", many + "o 7\n")) << "it is there already";
  const std::string more = many + "o x\n";
  const auto refused = names_in("a.obj", std::as_bytes(std::span(more)));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kTooLarge);
  EXPECT_NE(refused.error().detail.find(std::to_string(kMaxMeshNames)), std::string::npos);
  EXPECT_FALSE(
      names_of("a.gltf", R"({"nodes": [{"name": ")" + std::string(kMaxMeshNameBytes + 1, 'a') + R"("}]})"));
  const std::string brackets(8'000'000, '[');
  const test::PeakMemory peak;
  EXPECT_TRUE(names_of("a.gltf", brackets)->nodes.empty());
  EXPECT_TRUE(peak.grew_by_less_than(100'000'000)) << "a parsed document takes several hundred million";
}

}  // namespace
}  // namespace fracture::bake
