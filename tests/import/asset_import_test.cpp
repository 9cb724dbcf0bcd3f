// Compares real files with a table that other programs made (triangle counts, stored next to the files). Also
// compares nine files that describe the same barrel in nine ways.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "common/import/complete_attributes.hpp"
#include "common/mesh/material_library.hpp"
#include "tests/import/make_files.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/mesh_files.hpp"

namespace fracture::test {
namespace {

namespace fs = std::filesystem;

std::string read_whole(const fs::path& path) {
  std::string text(fs::file_size(path), '\0');
  std::ifstream(path, std::ios::binary).read(text.data(), static_cast<std::streamsize>(text.size()));
  return text;
}

/// Imports the file with all files in its folder as additional parts, as a client uploads a multi-file asset.
Expected<Mesh> import_with_siblings(const MeshFile& file) {
  const fs::path path(file.path);
  std::vector<std::pair<std::string, std::string>> parts;
  for (const auto& entry : fs::recursive_directory_iterator(path.parent_path()))
    if (entry.is_regular_file() && entry.path() != path)
      parts.emplace_back(fs::relative(entry.path(), path.parent_path()).generic_string(),
                         read_whole(entry.path()));
  std::vector<ImportFile> files;
  for (const auto& [name, content] : parts) files.push_back({name, bytes_of(content)});
  const auto format = format_from_extension(path.extension().string().substr(1));
  const std::string whole = read_whole(path);
  return import_mesh(bytes_of(whole), *format, {}, files);
}

/// Reads "| file | triangles | …" from that table. Rows without a count are left out.
std::map<std::string, std::size_t> listed_triangles() {
  std::map<std::string, std::size_t> counts;
  const std::optional<MeshFile> in_the_table = find_test_mesh("cube.glb");
  if (!in_the_table) return counts;
  std::ifstream table(fs::path(in_the_table->path).parent_path() / "licences.md");
  for (std::string line; std::getline(table, line);) {
    std::istringstream cells(line);
    std::string empty, name, count;
    std::getline(cells, empty, '|');
    std::getline(cells, name, '|');
    std::getline(cells, count, '|');
    const auto trim = [](std::string text) {
      text.erase(0, text.find_first_not_of(' '));
      text.erase(text.find_last_not_of(' ') + 1);
      return text;
    };
    if (const std::string number = trim(count);
        !number.empty() && number.find_first_not_of("0123456789") == std::string::npos)
      counts[trim(name)] = std::stoul(number);
  }
  return counts;
}

TEST(AssetImport, EveryFileHasTheTrianglesThatTheTableLists) {
  const auto listed = listed_triangles();
  if (listed.empty()) GTEST_SKIP() << "no licences.md in FRACTURE_TEST_MESHES";
  std::size_t compared = 0;
  for (const MeshFile& file : test_meshes()) {
    const Expected<Mesh> mesh = import_with_siblings(file);
    ASSERT_TRUE(mesh) << file.name << ": " << mesh.error().detail;
    const auto row = listed.find(file.name);
    if (row == listed.end()) continue;
    // The table counts the mesh of the instanced barrel once. The scene shows it six times.
    const std::size_t instances = file.name == "variants/barrel_instanced.glb" ? 6 : 1;
    EXPECT_EQ(mesh->triangles.size(), row->second * instances) << file.name;
    ++compared;
  }
  EXPECT_EQ(compared, listed.size());
}

TEST(AssetImport, TwinsOfTheBarrelAreTheSameSolid) {
  const auto original = find_test_mesh("kk_barrel_large.glb");
  if (!original) GTEST_SKIP() << "no kk_barrel_large.glb in FRACTURE_TEST_MESHES";
  const double volume = signed_volume(*import_with_siblings(*original));
  struct Twin {
    const char* name;
    double times, tolerance;
  };
  for (const Twin& twin : {Twin{"formats/barrel_large.obj", 1, 1e-5},
                           {"formats/barrel_large.fbx", 1, 1e-5},
                           {"variants/barrel.gltf", 1, 1e-7},
                           {"variants/barrel_unindexed.glb", 1, 1e-7},
                           {"variants/barrel_transforms.glb", 1, 1e-5},
                           {"variants/barrel_quantized.glb", 1, 1e-3},
                           {"variants/barrel_meshopt.glb", 1, 1e-3},
                           {"variants/barrel_draco.glb", 1, 1e-3},
                           {"variants/barrel_instanced.glb", 6, 1e-5}}) {
    const auto file = find_test_mesh(twin.name);
    ASSERT_TRUE(file) << twin.name;
    const Expected<Mesh> mesh = import_with_siblings(*file);
    ASSERT_TRUE(mesh) << twin.name << ": " << mesh.error().detail;
    EXPECT_EQ(mesh->triangles.size(), 561 * static_cast<std::size_t>(twin.times)) << twin.name;
    EXPECT_NEAR(signed_volume(*mesh) / (volume * twin.times), 1, twin.tolerance) << twin.name;
    EXPECT_EQ(mesh->attributes.uvs.size(), 1u) << twin.name;
    EXPECT_EQ(mesh->attributes.normals.size(), mesh->positions.size()) << twin.name;
    for (const Vec3f& n : mesh->attributes.normals) ASSERT_NEAR(length(to_double(n)), 1, 1e-6) << twin.name;
    ASSERT_EQ(mesh->library->images.size(), 1u) << twin.name;
    EXPECT_EQ(mesh->library->images[0].mime_type, "image/png") << twin.name;
  }
}

TEST(AssetImport, TexturedAssetKeepsItsSixMaterialsAndFifteenImages) {
  const auto file = find_test_mesh("FlightHelmet/FlightHelmet.gltf");
  if (!file) GTEST_SKIP() << "no FlightHelmet in FRACTURE_TEST_MESHES";
  const Expected<Mesh> mesh = import_with_siblings(*file);
  ASSERT_TRUE(mesh) << mesh.error().detail;
  EXPECT_EQ(mesh->library->materials.size(), 6u);
  EXPECT_EQ(mesh->library->images.size(), 15u);
  EXPECT_EQ(mesh->node_names.size(), 6u);
  EXPECT_EQ(mesh->attributes.tangents.size(), mesh->positions.size());
  EXPECT_TRUE(mesh->remarks.empty());
}

// The authors' tangents (MikkTSpace) are the oracle. Our tangents must point the same way and have the same
// handedness, although they are averaged by area instead of angle and never split a wedge.
TEST(AssetImport, ComputedTangentsAgreeWithThoseTheAuthorsWrote) {
  const auto file = find_test_mesh("FlightHelmet/FlightHelmet.gltf");
  if (!file) GTEST_SKIP() << "no FlightHelmet in FRACTURE_TEST_MESHES";
  Expected<Mesh> mesh = import_with_siblings(*file);
  ASSERT_TRUE(mesh) << mesh.error().detail;
  const std::vector<Vec4f> theirs = mesh->attributes.tangents;
  compute_tangents(*mesh, std::vector<std::uint32_t>(mesh->library->materials.size(), 0));
  std::size_t same_hand = 0, close = 0;
  for (std::size_t v = 0; v < theirs.size(); ++v) {
    const Vec4f &a = theirs[v], &b = mesh->attributes.tangents[v];
    same_hand += a.w == b.w;
    close += double{a.x} * b.x + double{a.y} * b.y + double{a.z} * b.z > 0.9;
  }
  EXPECT_GT(static_cast<double>(same_hand), 0.99 * static_cast<double>(theirs.size()));
  EXPECT_GT(static_cast<double>(close), 0.97 * static_cast<double>(theirs.size()));
}

TEST(AssetImport, TheMonkeyOfThePaperIsRead) {
  const auto file = assimp_model("BLEND/Suzanne_248.blend");
  if (!file) GTEST_SKIP() << "assimp-testmodels is not installed";
  const std::string whole = read_whole(file->path);
  const Expected<Mesh> mesh = import_text(whole, MeshFormat::kBlend);
  ASSERT_TRUE(mesh) << mesh.error().detail;
  EXPECT_EQ(mesh->node_names, std::vector<std::string>{"Suzanne"});
  EXPECT_EQ(mesh->triangles.size(), 4 * 968u);  // the primitive's triangles, subdivided once
  EXPECT_EQ(open_directed_edges(*mesh), 84u);   // around the eyes and their sockets
  EXPECT_GT(signed_volume(*mesh), 0);
  EXPECT_EQ(mesh->attributes.normals.size(), mesh->positions.size());
}

TEST(AssetImport, CompressedBlendIsInflatedUpToTheLimit) {
  const auto file = assimp_model("BLEND/MirroredCube_252.blend");
  if (!file) GTEST_SKIP() << "assimp-testmodels is not installed";
  const std::string whole = read_whole(file->path);
  ASSERT_EQ(whole.substr(0, 2), "\x1f\x8b");
  EXPECT_TRUE(import_text(whole, MeshFormat::kBlend));
  ImportLimits limits;
  limits.max_decoded_bytes = whole.size();
  EXPECT_EQ(import_text(whole, MeshFormat::kBlend, limits).error().code, ErrorCode::kTooLarge);
}

}  // namespace
}  // namespace fracture::test
