// PLY and STL, read back by the tests' own reader.
#include <gmock/gmock.h>

#include "tests/gltf/two_halves.hpp"
#include "tests/outputs/read_back.hpp"
#include "tests/support/mesh_files.hpp"

namespace fracture::outputs::test {
namespace {

using fracture::test::two_halves;
using testing::Contains;
using testing::HasSubstr;
using testing::StartsWith;

TEST(Ply, SaysOfEveryVertexAndFaceWhoseItIs) {
  const KeptAnswer answer = read(write_glb(two_halves(), {}));
  const PlyFile ply(ply_of(answer));
  EXPECT_EQ(ply.left, 0u);
  ASSERT_EQ(ply.vertices.size(), 48u) << "as in the GLB: four of each side of two cubes";
  ASSERT_EQ(ply.faces.size(), 24u);
  EXPECT_THAT(ply.comments, Contains(StartsWith("fracture, algorithm ")));
  EXPECT_THAT(ply.comments, Contains("fragment 0 Kiste_\xc3\xa4__1__0 id 9007199254740991"));
  EXPECT_THAT(ply.comments, Contains("fragment 1 Kiste_\xc3\xa4__1__1 id 7"));
  for (std::size_t f = 0; f < ply.faces.size(); ++f)
    for (const std::size_t v : ply.corners[f])
      EXPECT_EQ(ply.vertices.at(v).at("fragment"), ply.faces[f].at("fragment"));
  const auto fragments = ply.fragments();
  ASSERT_EQ(fragments.size(), 2u);
  for (const auto& [id, triangles] : fragments) {
    EXPECT_EQ(open_edges(triangles), 0u);
    EXPECT_EQ(volume_of(triangles), 1);
  }
}

TEST(Ply, HasNormalsUvsAndColors) {
  const KeptAnswer answer = read(write_glb(two_halves(), {}));
  for (const auto& v : PlyFile(ply_of(answer)).vertices) {
    const Vec3d n{v.at("nx"), v.at("ny"), v.at("nz")};
    EXPECT_EQ(dot(n, n), 1);
    EXPECT_TRUE(v.at("s") == 0 || v.at("s") == 1) << v.at("s");
    EXPECT_TRUE(v.at("t") == 0 || v.at("t") == 1) << v.at("t");
    EXPECT_EQ(v.at("red"), 255);
    EXPECT_EQ(v.at("green"), 188) << "sRGB of 1/2";
    EXPECT_EQ(v.at("blue"), 137) << "sRGB of 1/4";
    EXPECT_EQ(v.at("alpha"), 255);
  }
  for (const auto& v : PlyFile(ply_of(answer, VertexColors::kKeep)).vertices) {
    EXPECT_EQ(v.at("green"), 128) << "127.5, rounded away from 0";
    EXPECT_EQ(v.at("blue"), 64);
  }
}

TEST(Ply, HasNoColumnsForWhatNoFragmentHas) {
  FracturedSolid halves = two_halves();
  for (Fragment& f : halves.set.fragments) f.attributes = {};
  const PlyFile ply(ply_of(read(write_glb(halves, {}))));
  EXPECT_EQ(ply.left, 0u);
  EXPECT_EQ(ply.vertices.front().size(), 4u) << "x, y, z and fragment";
}

TEST(Stl, IsOneSolidOfAllFragments) {
  const std::string stl = stl_of(read(write_glb(two_halves(), {})));
  EXPECT_THAT(stl.substr(0, 80), HasSubstr("metres, y up"));
  EXPECT_FALSE(stl.starts_with("solid"));
  const std::vector<Triangle> triangles = stl_triangles(stl);
  ASSERT_EQ(triangles.size(), 24u);
  EXPECT_EQ(volume_of(triangles), 2);
  EXPECT_EQ(open_edges(triangles), 0u);
  for (std::size_t k = 0; k < triangles.size(); ++k) {
    float normal[3];
    std::memcpy(normal, &stl[84 + 50 * k], sizeof normal);
    EXPECT_EQ(stl.substr(84 + 50 * k + 48, 2), std::string(2, '\0'));
    const auto at = [&](std::size_t c) {
      return Vec3d{triangles[k][c][0], triangles[k][c][1], triangles[k][c][2]};
    };
    EXPECT_EQ((Vec3d{normal[0], normal[1], normal[2]}), cross(at(1) - at(0), at(2) - at(0)))
        << "of length 1: half of a unit square, twice";
  }
}

TEST(Stl, ATriangleWithoutAreaHasNoNormalAndStays) {
  FracturedSolid halves = two_halves();
  Fragment& f = halves.set.fragments[0];
  f.positions[1] = f.positions[0];
  const std::string stl = stl_of(read(write_glb(halves, {})));
  ASSERT_EQ(stl_triangles(stl).size(), 24u);
  EXPECT_EQ(stl.substr(84, 12), std::string(12, '\0'));
}

TEST(PlyAndStl, FragmentsOfARealBreakAreTheTrianglesOfTheObj) {
  const KeptAnswer answer = read(write_glb(broken_ball(), {}));
  const ObjFile obj(obj_of(answer));
  const auto fragments = PlyFile(ply_of(answer)).fragments();
  ASSERT_EQ(fragments.size(), obj.objects.size());
  std::vector<Triangle> all;
  for (std::size_t k = 0; k < obj.objects.size(); ++k) {
    EXPECT_EQ(fragments.at(static_cast<int>(k)), obj.objects[k].triangles) << "bit for bit, through decimals";
    EXPECT_EQ(open_edges(fragments.at(static_cast<int>(k))), 0u);
    all.insert(all.end(), obj.objects[k].triangles.begin(), obj.objects[k].triangles.end());
  }
  EXPECT_EQ(stl_triangles(stl_of(answer)), all);
}

TEST(PlyAndStl, FragmentsOfRealMeshesAreClosedInEveryFormat) {
  std::size_t tried = 0;
  for (const char* name :
       {"kk_wall_cracked.glb", "Fox.glb", "FlightHelmet/FlightHelmet.gltf", "cube_uv.ply", "nested.glb"}) {
    const auto file = fracture::test::find_test_mesh(name);
    if (!file) continue;
    ++tried;
    const Expected<Mesh> mesh = fracture::test::load_mesh(*file);
    ASSERT_TRUE(mesh) << name << ": " << mesh.error().detail;
    FractureParameters parameters;
    parameters.sites = 30;
    const auto made = fracture::test::fracture_mesh(*mesh, parameters);
    const KeptAnswer answer = read(write_glb(made, {}));
    const ObjFile obj(obj_of(answer));
    const auto fragments = PlyFile(ply_of(answer)).fragments();
    ASSERT_EQ(obj.objects.size(), made.set.fragments.size()) << name;
    ASSERT_EQ(fragments.size(), obj.objects.size()) << name;
    std::vector<Triangle> all;
    double volume = 0;
    for (std::size_t k = 0; k < obj.objects.size(); ++k) {
      const std::vector<Triangle>& triangles = obj.objects[k].triangles;
      EXPECT_EQ(open_edges(obj.objects[k].v), 0u) << name << ", " << obj.objects[k].name;
      EXPECT_EQ(fragments.at(static_cast<int>(k)), triangles) << name << ", " << obj.objects[k].name;
      volume += volume_of(triangles);
      all.insert(all.end(), triangles.begin(), triangles.end());
    }
    EXPECT_EQ(stl_triangles(stl_of(answer)), all) << name;
    // The volumes of fragments are exact. Here they are sums of products of doubles.
    EXPECT_NEAR(volume, made.set.certificate.volume_out, 1e-6 * made.set.certificate.volume_out) << name;
  }
  if (tried == 0) GTEST_SKIP() << "no real meshes: FRACTURE_TEST_MESHES";
}

}  // namespace
}  // namespace fracture::outputs::test
