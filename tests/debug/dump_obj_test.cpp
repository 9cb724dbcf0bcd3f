#include "common/debug/dump_obj.hpp"

#include <gtest/gtest.h>

#include <sstream>

#include "tests/gltf/two_halves.hpp"
#include "tests/import/make_files.hpp"

namespace fracture::test {
namespace {

TEST(DumpObj, MeshReadsBackBitForBit) {
  Tetrahedron tet;
  std::string odd;
  put<float>(odd, {0.1f, 0, 0, 1.0000001f, 0, 0, 0, 3.14159274f, 0, 0, 0, 16777216.0f});
  tet.binary.replace(0, 48, odd);
  const Mesh mesh = *import_text(tet.glb(), MeshFormat::kGlb);
  std::ostringstream out;
  debug::dump_obj(out, mesh);
  std::istringstream in(out.str());
  std::vector<Vec3f> positions;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  for (std::string word; in >> word;) {
    if (word == "v") {
      Vec3f p;
      in >> p.x >> p.y >> p.z;
      positions.push_back(p);
    } else if (word == "f") {
      std::array<std::uint32_t, 3> t{};
      in >> t[0] >> t[1] >> t[2];
      triangles.push_back({t[0] - 1, t[1] - 1, t[2] - 1});
    } else {
      in >> word;
    }
  }
  EXPECT_EQ(positions, mesh.positions);
  EXPECT_EQ(triangles, mesh.triangles);
}

TEST(DumpObj, FragmentsAreASolidEachInWorldSpace) {
  std::ostringstream out;
  debug::dump_obj(out, two_halves());
  const Expected<Mesh> mesh = import_text(out.str(), MeshFormat::kObj);
  ASSERT_TRUE(mesh) << mesh.error().detail;
  EXPECT_DOUBLE_EQ(signed_volume(*mesh), 2.0);
  Box box;
  for (const Vec3f& p : mesh->positions) box.add(to_double(p));
  EXPECT_EQ(box.min, (Vec3d{0, 0, 0}));
  EXPECT_EQ(box.max, (Vec3d{2, 1, 1}));
}

TEST(DumpObj, ExplodedFragmentsKeepTheirShapeAndMoveApart) {
  std::ostringstream out;
  debug::dump_obj(out, two_halves(), 1.0);
  const Expected<Mesh> mesh = import_text(out.str(), MeshFormat::kObj);
  ASSERT_TRUE(mesh) << mesh.error().detail;
  EXPECT_NEAR(signed_volume(*mesh), 2.0, 1e-6);
  Box box;
  for (const Vec3f& p : mesh->positions) box.add(to_double(p));
  EXPECT_EQ(box.size().x, 3);
}

}  // namespace
}  // namespace fracture::test
