// Our readers of STL, PLY and OFF on real files, compared with Assimp's readers.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>

#include "common/import/assimp_import.hpp"
#include "tests/import/own_readers.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/mesh_files.hpp"

namespace fracture::test {
namespace {

namespace fs = std::filesystem;

std::string bytes_of_file(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// The format of an STL, PLY or OFF file.
std::optional<MeshFormat> own_format(const fs::path& path) {
  const std::string extension = path.extension().string();
  if (extension.empty()) return std::nullopt;
  const auto format = format_from_extension(extension.substr(1));
  const bool ours = format == MeshFormat::kStl || format == MeshFormat::kPly || format == MeshFormat::kOff;
  return ours ? format : std::nullopt;
}

/// Those files of Debian's assimp-testmodels, sorted.
std::vector<fs::path> assimp_models() {
  std::vector<fs::path> files;
  std::error_code error;
  for (const auto& entry : fs::recursive_directory_iterator("/usr/share/assimp/models", error))
    if (entry.is_regular_file() && own_format(entry.path())) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

/// Assimp rounds decimal numbers in several steps.
void expect_near(const Vec3f& ours, const Vec3f& theirs) {
  const auto near = [](float a, float b) { return std::fabs(a - b) <= 1e-6f * std::max(1.0f, std::fabs(a)); };
  ASSERT_TRUE(near(ours.x, theirs.x) && near(ours.y, theirs.y) && near(ours.z, theirs.z))
      << ours.x << " " << ours.y << " " << ours.z << ", Assimp: " << theirs.x << " " << theirs.y << " "
      << theirs.z;
}

void expect_same_triangles(const Mesh& ours, const Mesh& theirs) {
  ASSERT_EQ(ours.triangles.size(), theirs.triangles.size());
  EXPECT_EQ(ours.node_names, theirs.node_names);
  EXPECT_EQ(ours.node, theirs.node);
  EXPECT_EQ(ours.attributes.normals.empty(), theirs.attributes.normals.empty());
  EXPECT_EQ(ours.attributes.uvs.size(), theirs.attributes.uvs.size());
  EXPECT_EQ(ours.attributes.colors.size(), theirs.attributes.colors.size());
  for (std::size_t t = 0; t < ours.triangles.size(); ++t) {
    const auto a = corners_of(ours, t), b = corners_of(theirs, t);
    for (std::size_t k = 0; k < 3; ++k) expect_near(a[k], b[k]);
    if (::testing::Test::HasFatalFailure()) return;
  }
}

TEST(OwnReaders, GiveTheTrianglesOfAssimp) {
  std::vector<fs::path> files = assimp_models();
  for (const MeshFile& file : test_meshes())
    if (own_format(file.path)) files.emplace_back(file.path);
  if (files.empty()) GTEST_SKIP() << "neither assimp-testmodels nor FRACTURE_TEST_MESHES is installed";
  // Files that we refuse, and why.
  const std::map<std::string, ErrorCode> refused{
      {"OFF/invalid.off",
       ErrorCode::kMalformedMesh},  // a face names vertex 20 of 3; Assimp replaces it by the last one
      {"PLY/issue623.ply", ErrorCode::kEmptyMesh},             // the element "face" is missing
      {"PLY/points.ply", ErrorCode::kEmptyMesh},               // a point cloud
      {"PLY/pond.0.ply", ErrorCode::kMalformedMesh},           // 69 bytes are missing
      {"invalid/OutOfMemory.off", ErrorCode::kMalformedMesh},  // declares 353,535,235,358 vertices
      {"invalid/empty.off", ErrorCode::kEmptyBody},
      {"invalid/empty.ply", ErrorCode::kEmptyBody},
  };
  for (const fs::path& path : files) {
    SCOPED_TRACE(path.string());
    const std::string bytes = bytes_of_file(path);
    const MeshFormat format = *own_format(path);
    const Expected<Mesh> ours = import_text(bytes, format);
    const auto listed = refused.find((path.parent_path().filename() / path.filename()).generic_string());
    if (listed != refused.end()) {
      ASSERT_FALSE(ours);
      EXPECT_EQ(ours.error().code, listed->second) << ours.error().detail;
      continue;
    }
    ASSERT_TRUE(ours) << ours.error().detail;
    Expected<Mesh> theirs = import_with_assimp(bytes_of(bytes), format, {}, {});
    ASSERT_TRUE(theirs) << theirs.error().detail;
    if (format == MeshFormat::kStl) theirs->attributes.normals.clear();  // they repeat the facets
    expect_same_triangles(*ours, *theirs);
  }
}

/// The folder "import" next to the folder of test meshes; empty if it is absent.
fs::path import_folder() {
  const std::optional<MeshFile> mesh = find_test_mesh("cube.glb");
  if (!mesh) return {};
  const fs::path folder = fs::path(mesh->path).parent_path().parent_path() / "import";
  return fs::is_directory(folder) ? folder : fs::path();
}

TEST(OwnReaders, ReadTheFilesThatWereRefused) {
  const fs::path folder = import_folder();
  if (folder.empty()) GTEST_SKIP() << "the folder import is absent";
  // Cubes of side 1. The first coordinate of starts_with_0a.ply has a line feed as its lowest byte.
  for (const char* name :
       {"plain.ply", "starts_with_0a.ply", "normal_empty.stl", "normal_nanind.stl", "normal_qnan.stl"}) {
    const fs::path path = folder / name;
    ASSERT_TRUE(fs::is_regular_file(path)) << name;
    const Mesh mesh = must_import(bytes_of_file(path), *own_format(path));
    EXPECT_EQ(mesh.triangles.size(), 12u) << name;
    EXPECT_EQ(mesh.positions.size(), 8u) << name;
    EXPECT_NEAR(signed_volume(mesh), 1, 1e-5) << name;
    EXPECT_EQ(open_directed_edges(mesh), 0u) << name;
  }
}

}  // namespace
}  // namespace fracture::test
