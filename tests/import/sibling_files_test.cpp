// The other files that an asset names, and the ones of them that are read.
#include "common/import/sibling_files.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "common/import/uri.hpp"
#include "common/mesh/material_library.hpp"
#include "tests/import/make_files.hpp"
#include "tests/support/mesh_files.hpp"
#include "tests/support/peak_memory.hpp"

namespace fracture::test {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(ReferencedFiles, OfGltfAreItsBuffersAndImagesButNoDataUris) {
  const char* text = R"({"buffers":[{"uri":"a%20b.bin"},{"uri":"data:;base64,AA=="},{}],
                         "images":[{"uri":".\\tex\\c.png"},{"uri":"a b.bin"},{"uri":"http://x/y.png"},{"uri":5}]})";
  EXPECT_THAT(referenced_files(bytes_of(text), MeshFormat::kGltf), ElementsAre("a b.bin", "tex/c.png"));
  const std::string glb = make_glb(nlohmann::json::parse(text), "");
  EXPECT_THAT(referenced_files(bytes_of(glb), MeshFormat::kGlb), ElementsAre("a b.bin", "tex/c.png"));
}

TEST(ReferencedFiles, OfGltfAreOnlyThoseOfTheListsThemselves) {
  const char* text =
      R"({"images":[{"uri":"b.png","extras":{"uri":"no","list":[{"uri":"no"}]}},[{"uri":"no"}],"no",
      {"uri":["no"]},{"name":"a","uri":"c.png"}],"buffers":[{"uri":"a.bin"}],"extras":{"images":[{"uri":"no"}]},
      "meshes":[{"uri":"no"}],"uri":"no"})";
  EXPECT_THAT(referenced_files(bytes_of(text), MeshFormat::kGltf), ElementsAre("a.bin", "b.png", "c.png"));
  EXPECT_THAT(referenced_files(bytes_of(std::string("[") + text + "]"), MeshFormat::kGltf), IsEmpty());
}

TEST(ReferencedFiles, OfAGltfThatIsAllBracketsTakeNoMemory) {
  const std::string brackets(8'000'000, '[');
  const PeakMemory peak;
  EXPECT_THAT(referenced_files(bytes_of(brackets), MeshFormat::kGltf), IsEmpty());
  EXPECT_TRUE(peak.grew_by_less_than(100'000'000)) << "a parsed document takes several hundred million";
}

TEST(ReferencedFiles, OfObjAreItsLibrariesAndOfThoseTheirTextures) {
  EXPECT_THAT(referenced_files(bytes_of("# mtllib no.mtl\nmtllib my parts.mtl\r\n v 0 0 0\n  mtllib b.mtl"),
                               MeshFormat::kObj),
              ElementsAre("my parts.mtl", "b.mtl"));
  EXPECT_THAT(textures_of_mtl("newmtl a\nmap_Kd wood grain.png\r\nbump -bm 0.2 tex\\n.png\nKd 1 0 0\n"),
              ElementsAre("wood grain.png", "tex/n.png"));
  EXPECT_THAT(referenced_files(bytes_of("mtllib a.mtl b c.mtl\rmtllib \\\r\n d.mtl\r"), MeshFormat::kObj),
              ElementsAre("a.mtl", "b c.mtl", "d.mtl"));
  EXPECT_THAT(textures_of_mtl("MAP_KD -s 1 1 1 -clamp on wood grain.png\rnorm n.png"),
              ElementsAre("wood grain.png", "n.png"));
}

TEST(ReferencedFiles, OfPlyAreTheTexturesInItsComments) {
  EXPECT_THAT(referenced_files(
                  bytes_of("ply\r\ncomment TextureFile wood grain.png\r\ncomment no.png\r\n"
                           "comment  TextureFile ./b.png \r\nend_header\r\ncomment TextureFile no.png\r\n"),
                  MeshFormat::kPly),
              ElementsAre("wood grain.png", "b.png"));
}

TEST(ReferencedFiles, OfFbxAndDaeAreTheirTextures) {
  std::string binary = "Kaydara...RelativeFilenameS";
  put<std::uint32_t>(binary, {8});
  binary += "..\\t.png>";
  EXPECT_THAT(referenced_files(bytes_of(binary), MeshFormat::kFbx), ElementsAre("../t.png"));
  EXPECT_THAT(referenced_files(bytes_of("RelativeFilename: \"a.png\"\n"), MeshFormat::kFbx),
              ElementsAre("a.png"));
  EXPECT_THAT(
      referenced_files(bytes_of("<image><init_from>./a%20b.png</init_from></image>"), MeshFormat::kDae),
      ElementsAre("a b.png"));
}

TEST(ReferencedFiles, OfDamagedFilesAreNone) {
  EXPECT_THAT(referenced_files(bytes_of("{\"buffers\":[{"), MeshFormat::kGltf), IsEmpty());
  EXPECT_THAT(referenced_files(bytes_of("[1]"), MeshFormat::kGltf), IsEmpty());
  EXPECT_THAT(referenced_files(bytes_of("glTF"), MeshFormat::kGlb), IsEmpty());
  EXPECT_THAT(referenced_files(bytes_of("RelativeFilenameS\xff\xff\xff\xff..."), MeshFormat::kFbx),
              IsEmpty());
}

TEST(SiblingFiles, AreReadFromTheFolderAndBelowOnly) {
  const fs::path top = fs::temp_directory_path() / ("fracture_siblings_" + std::to_string(::getpid()));
  fs::create_directories(top / "asset" / "tex");
  const auto write = [&](const fs::path& name, const std::string& text) {
    std::ofstream(top / name, std::ios::binary) << text;
  };
  write("outside.png", "no");
  write("asset/tex/in.png", "yes");
  write("asset/flat.png", "flat");
  fs::create_symlink(top / "outside.png", top / "asset" / "link.png");
  const auto read = [&](const std::string& uri) {
    const nlohmann::json document = {{"images", {{{"uri", uri}}}}};
    const std::string text = document.dump();
    std::vector<std::string> found;
    for (const SiblingFile& f :
         read_sibling_files((top / "asset" / "a.gltf").string(), bytes_of(text), MeshFormat::kGltf))
      found.push_back(f.name + "=" + f.bytes);
    return found;
  };
  EXPECT_THAT(read("tex/in.png"), ElementsAre("tex/in.png=yes"));
  EXPECT_THAT(read("/somewhere/else/flat.png"), ElementsAre("flat.png=flat"));
  EXPECT_THAT(read("C:\\Users\\me\\flat.png"), ElementsAre("flat.png=flat"));
  for (const std::string& bad :
       {std::string("../outside.png"), std::string("tex/../../outside.png"), (top / "outside.png").string(),
        std::string("link.png"), std::string("tex"), std::string(".."), std::string("absent.png")})
    EXPECT_THAT(read(bad), IsEmpty()) << bad;
  fs::remove_all(top);
}

TEST(FindFile, ByWholeNameThenByItsLastComponent) {
  const std::vector<ImportFile> files{{"a.png", {}}, {"x/a.png", {}}, {"y/b.png", {}}};
  EXPECT_EQ(find_file(files, "x/a.png"), &files[1]);
  EXPECT_EQ(find_file(files, "./x%2Fa.png"), &files[1]);
  EXPECT_EQ(find_file(files, "x\\a.png"), &files[1]);
  EXPECT_EQ(find_file(files, "C:\\z\\a.png"), &files[0]);
  EXPECT_EQ(find_file(files, "b.png"), nullptr);
}

TEST(FindFile, IgnoresCaseOnlyWhereOneFileIsMeant) {
  const std::vector<ImportFile> files{{"Wood.PNG", {}}, {"a.png", {}}, {"A.png", {}}};
  EXPECT_EQ(find_file(files, "tex\\wood.png"), &files[0]);
  EXPECT_EQ(find_file(files, "A.png"), &files[2]);
  EXPECT_EQ(find_file(files, "A.PNG"), nullptr);
}

TEST(SiblingFiles, OfOtherFormatsAreThoseThatTheyMentionAndTheirCompanions) {
  const fs::path top = fs::temp_directory_path() / ("fracture_mentioned_" + std::to_string(::getpid()));
  fs::create_directories(top / "objects");
  const auto write = [&](const fs::path& name, const std::string& text) {
    std::ofstream(top / name, std::ios::binary) << text;
  };
  write("scene.lws", "itself: scene.lws");
  write("objects/Hull.lwo", "FORM....LWO2 rust.png");
  write("rust.png", "of the object");
  write("other.lwo", "not named");
  write("box_a.3d", "vertices");
  write("box_d.3d", "animation");
  write("crate_a.3d", "another");
  fs::create_symlink(top / "other.lwo", top / "link.lwo");
  const auto read = [&](const char* name, const std::string& text, MeshFormat format) {
    std::vector<std::string> found;
    for (const SiblingFile& f : read_sibling_files((top / name).string(), bytes_of(text), format))
      found.push_back(f.name);
    return found;
  };
  EXPECT_THAT(read("scene.lws", "LoadObject C:\\OBJECTS\\hull.lwo\nlink.lwo", MeshFormat::kLws),
              ElementsAre("objects/Hull.lwo", "rust.png"));
  EXPECT_THAT(read("box_d.3d", "", MeshFormat::k3d), ElementsAre("box_a.3d"));
  EXPECT_THAT(read("scene.lws", "nothing", MeshFormat::kLws), IsEmpty());
  fs::remove_all(top);
}

TEST(SiblingFiles, OfRealAssetsMakeThemReadable) {
  if (test_meshes().empty()) GTEST_SKIP() << "FRACTURE_TEST_MESHES is absent";
  for (const char* name :
       {"FlightHelmet/FlightHelmet.gltf", "citybits/building_A.gltf", "variants/barrel.gltf",
        "formats/barrel_large.obj", "formats/barrel_large.fbx", "kenney-city/building-small-c.glb"}) {
    const auto file = find_test_mesh(name);
    ASSERT_TRUE(file) << name;
    const Expected<Mesh> mesh = load_mesh(*file);
    ASSERT_TRUE(mesh) << name << ": " << mesh.error().detail;
    EXPECT_GE(mesh->library->images.size(), 1u) << name;
  }
}

}  // namespace
}  // namespace fracture::test
