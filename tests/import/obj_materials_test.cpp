// Material libraries (MTL) of OBJ files: which file is meant, how its statements become glTF materials, and what is lost.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/words.hpp"
#include "common/import/obj_names.hpp"
#include "common/mesh/material_library.hpp"
#include "tests/import/make_files.hpp"

namespace fracture::test {
namespace {

using nlohmann::json;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

const std::string kPng = "\x89PNG\r\n\x1a\n";
const std::string kTriangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

Mesh read(const std::string& obj, const std::vector<std::pair<std::string, std::string>>& given) {
  std::vector<ImportFile> files;
  for (const auto& [name, text] : given) files.push_back({name, bytes_of(text)});
  Expected<Mesh> mesh = import_text(obj, MeshFormat::kObj, {}, files);
  EXPECT_TRUE(mesh) << (mesh ? "" : mesh.error().detail);
  return mesh ? std::move(*mesh) : Mesh{};
}

/// Reads a library with one material "m", which a face uses. Returns the mesh.
Mesh with(const std::string& statements, std::vector<std::pair<std::string, std::string>> files = {}) {
  files.emplace_back("a.mtl", "newmtl m\n" + statements);
  return read("mtllib a.mtl\n" + kTriangle + "usemtl m\nf 1 2 3\n", files);
}
json material(const std::string& statements) { return with(statements).library->materials.at(0); }
json pbr(const std::string& statements) { return material(statements).at("pbrMetallicRoughness"); }

TEST(ObjMaterials, SlotsSurviveWithoutTheMtlAndTakeItsColoursWithIt) {
  const std::string obj =
      std::string("mtllib box.mtl\n") +
      "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nusemtl red\nf 1 3 2\nf 1 2 4\nusemtl blue\nf 1 4 3\nf 2 3 4\n";
  const Mesh mesh = read(obj, {{"box.mtl", "newmtl red\nKd 1 0 0\nnewmtl blue\nKd 0 0 0.8\nd 0.5\n"}});
  ASSERT_EQ(mesh.library->materials.size(), 2u);
  const auto& blue = mesh.library->materials[mesh.material[3]];
  EXPECT_EQ(blue["name"], "blue");
  EXPECT_EQ(blue["pbrMetallicRoughness"]["baseColorFactor"], (json{0.0, 0.0, 0.8, 0.5}));
  EXPECT_EQ(blue["alphaMode"], "BLEND");
  EXPECT_THAT(mesh.remarks.warnings, IsEmpty());
  const Mesh without = read(obj, {});
  EXPECT_NE(without.material[0], without.material[3]);
}

TEST(ObjMaterials, AMissingLibraryIsNamed) {
  const std::string obj = "mtllib c.mtl\n" + kTriangle;
  EXPECT_THAT(read(obj + "usemtl red\nf 1 2 3\n", {}).remarks.warnings,
              ElementsAre(HasSubstr("c.mtl was not given, so materials are missing.")));
  EXPECT_THAT(read("mtllib d.mtl e.mtl\n" + obj + "usemtl red\nf 1 2 3\n", {}).remarks.warnings,
              ElementsAre(HasSubstr("d.mtl and 2 more libraries were not given, so materials are missing.")));
  EXPECT_THAT(read(obj + "f 1 2 3\n", {}).remarks.warnings, IsEmpty()) << "no face uses a material";
  EXPECT_THAT(read(obj + "usemtl red\nf 1 2 3\n", {{"c.mtl", "newmtl blue\n"}}).remarks.warnings,
              ElementsAre(HasSubstr("\"red\"")));
}

TEST(ObjMaterials, AFileOutsideTheUploadIsNotOpened) {
  EXPECT_EQ(read("mtllib /etc/passwd\n" + kTriangle + "f 1 2 3\n", {}).triangles.size(), 1u);
}

TEST(ObjMaterials, TheOnlyLibraryIsMeantIfItsNameIsWrong) {
  const std::string obj = "mtllib C:\\old\\name.mat\n" + kTriangle + "usemtl red\nf 1 2 3\n";
  const std::string red = "newmtl red\nKd 1 0 0\n";
  const Mesh mesh = read(obj, {{"x.png", ""}, {"other.MTL", red}});
  EXPECT_EQ(mesh.library->materials.at(0)["pbrMetallicRoughness"]["baseColorFactor"],
            (json{1.0, 0.0, 0.0, 1.0}));
  EXPECT_THAT(read(obj, {{"a.mtl", red}, {"b.mtl", red}}).remarks.warnings,
              Contains(HasSubstr("was not given")));
}

TEST(ObjMaterials, SeveralLibrariesWithBlanksInTheirNamesAreRead) {
  const Mesh mesh = read("mtllib my parts.mtl \"b c.mtl\" d.mtl\nmtllib d.mtl\n" + kTriangle +
                             "usemtl late\nf 1 2 3\nmtllib e.mtl\n",
                         {{"my parts.mtl", "newmtl a\n"},
                          {"b c.mtl", "newmtl b\n"},
                          {"d.mtl", "newmtl d\n"},
                          {"e.mtl", "newmtl late\nKd 0 1 0\n"}});
  std::vector<std::string> names;
  for (const json& m : mesh.library->materials) names.push_back(m.at("name").get<std::string>());
  EXPECT_THAT(names, ElementsAre("a", "b", "d", "late")) << "in the order in which they are loaded or used";
  EXPECT_EQ(mesh.library->materials[3]["pbrMetallicRoughness"]["baseColorFactor"][1], 1.0)
      << "defined after its use";
  EXPECT_EQ(mesh.material[0], 3u);
  EXPECT_THAT(mesh.remarks.warnings, IsEmpty());
}

TEST(ObjMaterials, NamesOfLibrariesEndAtTheirEnding) {
  EXPECT_THAT(material_libraries("  a.mtl\tb c.MTL  d.mat "), ElementsAre("a.mtl", "b c.MTL", "d.mat"));
  EXPECT_THAT(material_libraries("\"a b.mtl\" c.mtl"), ElementsAre("a b.mtl", "c.mtl"));
  EXPECT_THAT(material_libraries("./no ending"), ElementsAre("./no ending"));
  EXPECT_THAT(material_libraries(" \t"), IsEmpty());
}

TEST(ObjMaterials, ColoursAndOpacityAreThoseOfTheStatements) {
  EXPECT_EQ(pbr("Kd 0.25 0.5 1\n")["baseColorFactor"], (json{0.25, 0.5, 1.0, 1.0}));
  EXPECT_EQ(pbr("Kd 0.3 # grey\n")["baseColorFactor"], (json{0.3, 0.3, 0.3, 1.0}))
      << "the others repeat the first";
  EXPECT_EQ(pbr("")["baseColorFactor"], (json{0.6, 0.6, 0.6, 1.0})) << "the usual grey";
  EXPECT_EQ(pbr("Kd 2 -1 nan\n")["baseColorFactor"], (json{1.0, 0.0, 1.0, 1.0})) << "within [0, 1]";
  EXPECT_EQ(pbr("d 0.5\n")["baseColorFactor"][3], 0.5);
  EXPECT_EQ(pbr("d -halo 0.5\n")["baseColorFactor"][3], 0.5);
  EXPECT_EQ(pbr("Tr 0.25\n")["baseColorFactor"][3], 0.75);
  EXPECT_EQ(material("Tr 0.25\n")["alphaMode"], "BLEND");
  EXPECT_FALSE(material("Tr 0\n").contains("alphaMode"));
  EXPECT_EQ(material("Ke 0 0.5 0\n")["emissiveFactor"], (json{0.0, 0.5, 0.0}));
  EXPECT_FALSE(material("Ke 0 0 0\n").contains("emissiveFactor"));
}

TEST(ObjMaterials, ShininessBecomesRoughnessUnlessThePbrExtensionStatesIt) {
  EXPECT_EQ(pbr("Ns 30\n")["roughnessFactor"], 0.5);  // (2 / (30 + 2))^(1/4)
  EXPECT_FALSE(pbr("Ns 0\n").contains("roughnessFactor"));
  const json both = pbr("Ns 30\nPr 0.75\nPm 1\n");
  EXPECT_EQ(both["roughnessFactor"], 0.75);
  EXPECT_EQ(both["metallicFactor"], 1.0);
  EXPECT_EQ(pbr("Ns 30\n")["metallicFactor"], 0);
}

TEST(ObjMaterials, MapsAreFoundAfterTheirOptions) {
  const auto name = [](std::string_view rest) { return std::string(file_of_map(rest).name); };
  EXPECT_EQ(name(" wood grain.png \t"), "wood grain.png");
  EXPECT_EQ(name("-s 2 2 2 -o 0.5 -clamp on -bm 0.5 -mm 0 1 -imfchan r -blendu off wood grain.png"),
            "wood grain.png");
  EXPECT_EQ(name("-o 1 1 -texres 256 -t 1e-3 a.png"), "a.png");
  EXPECT_EQ(name("-type sphere \"a b.png\""), "a b.png");
  EXPECT_EQ(name("-s 1 1 1 5"), "5");
  EXPECT_EQ(name("-o 5"), "5") << "the last word is the name";
  EXPECT_EQ(name("-unknown a.png"), "a.png");
  EXPECT_EQ(name("-bm"), "");
  EXPECT_TRUE(file_of_map("-s 2 2 a.png").placed);
  EXPECT_TRUE(file_of_map("-t 0 0 1 a.png").placed);
  EXPECT_FALSE(file_of_map("-s 1 1 1 -o 0 0 0 a.png").placed);
}

TEST(ObjMaterials, TexturesBelongToColourNormalAndEmission) {
  const Mesh mesh = with("map_Kd tex\\c.png\nnorm n.png\nmap_Ke c.png\n",
                         {{"c.png", kPng}, {"tex/c.png", kPng}, {"n.png", kPng}});
  ASSERT_EQ(mesh.library->images.size(), 3u);
  const json m = mesh.library->materials.at(0);
  const auto image = [&](const json& texture) {
    return mesh.library->images
        .at(mesh.library->textures.at(texture.at("index").get<std::size_t>()).at("source").get<std::size_t>())
        .name;
  };
  EXPECT_EQ(image(m["pbrMetallicRoughness"]["baseColorTexture"]), "c.png");
  EXPECT_EQ(image(m["normalTexture"]), "n.png");
  EXPECT_EQ(m["emissiveFactor"], (json{1, 1, 1})) << "a map without a colour shows as it is";
  EXPECT_THAT(mesh.dropped, IsEmpty());
}

TEST(ObjMaterials, TexturesAreInTheFolderOfTheirLibrary) {
  const Mesh mesh =
      read("mtllib lib/a.mtl\n" + kTriangle + "usemtl m\nf 1 2 3\n",
           {{"lib/a.mtl", "newmtl m\nmap_Kd c.png\n"}, {"c.png", "wrong"}, {"lib/c.png", kPng}});
  EXPECT_EQ(mesh.library->images.size(), 1u);
}

TEST(ObjMaterials, TexturesThatGltfCannotHaveAreListed) {
  const Mesh mesh = with(
      "map_Ka c.png\nmap_Kd -s 2 2 1 c.png\nmap_Bump -bm 1 b.png\nmap_Pr r.png\nmap_d o.png\nmap_Ks s.png\nbump\n",
      {{"c.png", kPng}, {"b.png", kPng}});
  std::vector<std::string> names;
  for (const Dropped& dropped : mesh.dropped)
    if (dropped.what == "texture") names.push_back(dropped.name);
  EXPECT_THAT(names, ElementsAre("b.png", "r.png", "o.png", "s.png")) << "map_Ka repeats map_Kd";
  EXPECT_THAT(mesh.dropped, Contains(Dropped{"texture placement", "c.png",
                                             "the options -o, -s and -t of a texture are not applied"}));
}

TEST(ObjMaterials, TexturesThatWereNotGivenAreListed) {
  EXPECT_THAT(with("map_Kd absent.png\n", {}).dropped,
              ElementsAre(Dropped{"image", "absent.png", "its file was not given"}));
  EXPECT_THAT(with("map_Kd a.bmp\n", {{"a.bmp", "BM"}}).dropped,
              ElementsAre(Dropped{"image", "a.bmp", "it is neither PNG nor JPEG"}));
}

TEST(ObjMaterials, StatementsThatAreNotMtlAreAWarning) {
  const Mesh mesh = with("Kd spectral a.rfl\nNs\nillum 2\nKs x\n");
  EXPECT_THAT(mesh.remarks.warnings, ElementsAre(HasSubstr("line 2 of \"a.mtl\": \"Kd spectral a.rfl\"")));
  EXPECT_THAT(mesh.remarks.warnings[0], HasSubstr("2 statements"));
  EXPECT_THAT(read("mtllib a.mtl\n" + kTriangle + "f 1 2 3\n", {{"a.mtl", "Kd 1 0 0\nnewmtl\nKd x\n"}})
                  .library->materials,
              IsEmpty());
}

TEST(ObjMaterials, LibrariesMayEndLinesInAnyWayAndBeUtf16) {
  const std::string mtl = "\xef\xbb\xbfnewmtl m\rKd 0 \\\r 1 0\r";
  std::string wide = "\xff\xfe";
  for (const char c : std::string("newmtl m\r\nKd 0 1 0")) wide += {c, '\0'};
  for (const std::string& text : {mtl, wide}) {
    const Mesh mesh = read("mtllib a.mtl\n" + kTriangle + "usemtl m\nf 1 2 3\n", {{"a.mtl", text}});
    EXPECT_EQ(mesh.library->materials.at(0)["pbrMetallicRoughness"]["baseColorFactor"],
              (json{0.0, 1.0, 0.0, 1.0}));
  }
}

TEST(ObjMaterials, MoreThanTheLimitAreRefused) {
  std::string mtl;
  for (int k = 0; k < 200'000; ++k) mtl += "newmtl m" + std::to_string(k) + "\n";
  const ImportFile file{"a.mtl", bytes_of(mtl)};
  const auto mesh = import_text("mtllib a.mtl\n" + kTriangle + "f 1 2 3\n", MeshFormat::kObj, {}, {&file, 1});
  ASSERT_FALSE(mesh);
  EXPECT_EQ(mesh.error().code, ErrorCode::kTooLarge);
  EXPECT_THAT(mesh.error().detail, HasSubstr(data_size(kMaxLibraryBytes)));
}

}  // namespace
}  // namespace fracture::test
