// Our OBJ reader compared with Assimp's on every OBJ file of assimp-testmodels and FRACTURE_TEST_MESHES.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "common/import/assimp_import.hpp"
#include "common/import/obj_import.hpp"
#include "common/import/text_encoding.hpp"
#include "tests/import/make_files.hpp"
#include "tests/support/full_tests.hpp"
#include "tests/support/mesh_files.hpp"

namespace fracture::test {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> obj_files() {
  std::vector<fs::path> files;
#ifndef FRACTURE_SANITIZED  // Assimp leaks memory on some of its own files.
  if (const fs::path models = "/usr/share/assimp/models"; fs::is_directory(models))
    for (const auto& entry : fs::recursive_directory_iterator(models))
      if (entry.is_regular_file() && entry.path().extension() == ".obj") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
#endif
  for (const MeshFile& file : test_meshes())
    if (file.name.ends_with(".obj")) files.emplace_back(file.path);
  return files;
}

struct Triangle {
  Vec3d corners[3];
  std::string node;
  Vec3d area() const { return 0.5 * cross(corners[1] - corners[0], corners[2] - corners[0]); }
};

std::vector<Triangle> triangles_of(const Mesh& mesh) {
  std::vector<Triangle> list;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    Triangle triangle{{}, mesh.node_names[mesh.node[t]]};
    for (std::size_t k = 0; k < 3; ++k)
      triangle.corners[k] = to_double(mesh.positions[mesh.triangles[t][k]]) + mesh.frame.offset;
    list.push_back(triangle);
  }
  return list;
}

bool alike(const Triangle& a, const Triangle& b, double tolerance) {
  for (int k = 0; k < 3; ++k)
    for (int axis = 0; axis < 3; ++axis)
      if (std::fabs(a.corners[k][axis] - b.corners[k][axis]) > tolerance) return false;
  return a.node == b.node;
}

/// The triangles are in the same order in both. Only concave polygons may have other diagonals: the vector area and the area
/// of such triangles are the same in total.
void compare(const Mesh& ours, const Mesh& assimps) {
  ASSERT_EQ(ours.triangles.size(), assimps.triangles.size());
  const std::vector<Triangle> a = triangles_of(ours), b = triangles_of(assimps);
  double size = 0;
  for (const Triangle& triangle : a)
    for (const Vec3d& p : triangle.corners) size = std::fmax(size, length(p));
  const double tolerance = 4e-7 * size;  // Assimp's numbers are up to three float steps off
  Vec3d vector;
  double area = 0, all = 0;
  for (std::size_t t = 0; t < a.size(); ++t) {
    all += length(a[t].area());
    if (alike(a[t], b[t], tolerance)) continue;
    EXPECT_EQ(a[t].node, b[t].node) << t;
    vector = vector + a[t].area() - b[t].area();
    area += length(a[t].area()) - length(b[t].area());
  }
  EXPECT_LE(length(vector), 1e-4 * all);
  EXPECT_LE(std::fabs(area), 1e-4 * all);
}

TEST(ObjDifferential, TrianglesAreThoseThatAssimpReads) {
  const std::vector<fs::path> files = obj_files();
  if (files.empty()) GTEST_SKIP() << "neither assimp-testmodels nor FRACTURE_TEST_MESHES is present";
  std::size_t compared = 0;
  for (const fs::path& path : files) {
    SCOPED_TRACE(path.string());
    std::ifstream in(path, std::ios::binary);
    std::string text{std::istreambuf_iterator<char>(in), {}};
    if (text.empty() || (short_tests() && text.size() > 300'000)) continue;
    if (auto converted = utf16_to_utf8(bytes_of(text))) text = std::move(*converted);
    const Expected<Mesh> ours = import_obj(bytes_of(text), {}, {});
    const Expected<Mesh> assimps = import_with_assimp(bytes_of(text), MeshFormat::kObj, {}, {});
    // Files without faces, or with an index 0 (invalid/malformed.obj), are refused by both.
    ASSERT_EQ(ours.has_value(), assimps.has_value()) << (ours ? assimps.error().detail : ours.error().detail);
    if (!ours) continue;
    compare(*ours, *assimps);
    ++compared;
  }
  EXPECT_GT(compared, 0u);
}

}  // namespace
}  // namespace fracture::test
