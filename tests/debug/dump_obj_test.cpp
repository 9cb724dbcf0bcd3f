#include "common/debug/dump_obj.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include "common/base/random.hpp"
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
  debug::dump_obj(out, two_halves().set);
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
  debug::dump_obj(out, two_halves().set, 1.0);
  const Expected<Mesh> mesh = import_text(out.str(), MeshFormat::kObj);
  ASSERT_TRUE(mesh) << mesh.error().detail;
  EXPECT_NEAR(signed_volume(*mesh), 2.0, 1e-6);
  Box box;
  for (const Vec3f& p : mesh->positions) box.add(to_double(p));
  EXPECT_EQ(box.size().x, 3);
}

Tetrahedralization random_tetrahedra() {
  Random random(5);
  std::vector<Vec3d> sites(40);
  Box box;
  for (Vec3d& p : sites) {
    for (int a = 0; a < 3; ++a) p[a] = random.uniform();
    box.add(p);
  }
  return *tetrahedralize(sites, box, {});
}

TEST(DumpObj, TetrahedraBetweenSitesAreSolidsApart) {
  const Tetrahedralization t = random_tetrahedra();
  double volume = 0;
  std::size_t inner = 0;
  for (const auto& tet : t.tets) {
    if (std::any_of(tet.v.begin(), tet.v.end(), [&](SiteId s) { return t.is_corner(s); })) continue;
    const Vec3d o = t.points[tet.v[0]];
    volume += dot(t.points[tet.v[1]] - o, cross(t.points[tet.v[2]] - o, t.points[tet.v[3]] - o)) / 6;
    ++inner;
  }
  ASSERT_GT(inner, 40u);
  for (const double shrink : {0.0, 0.1}) {
    std::ostringstream out;
    debug::dump_obj(out, t, shrink);
    const Expected<Mesh> mesh = import_text(out.str(), MeshFormat::kObj);
    ASSERT_TRUE(mesh) << mesh.error().detail;
    EXPECT_EQ(mesh->triangles.size(), 4 * inner);
    const double left = (1 - shrink) * (1 - shrink) * (1 - shrink);
    EXPECT_NEAR(signed_volume(*mesh), left * volume, 1e-5);
  }
}

TEST(DumpObj, SitesAreOctahedraAroundThem) {
  const Tetrahedralization t = random_tetrahedra();
  std::ostringstream out;
  debug::dump_obj_of_sites(out, t, 0.125);
  const Expected<Mesh> mesh = import_text(out.str(), MeshFormat::kObj);
  ASSERT_TRUE(mesh) << mesh.error().detail;
  ASSERT_EQ(mesh->triangles.size(), 8u * t.site_count());
  EXPECT_NEAR(signed_volume(*mesh), t.site_count() * 4.0 / 3 * 0.125 * 0.125 * 0.125, 1e-5);
  std::istringstream in(out.str());
  std::string word;
  std::vector<Vec3d> corners;
  while (in >> word) {
    Vec3d p;
    if (word == "v" && in >> p.x >> p.y >> p.z) corners.push_back(p);
  }
  ASSERT_EQ(corners.size(), 6u * t.site_count());
  for (const SiteId s : ids<SiteId>(t.site_count()))
    for (std::size_t k = 0; k < 6; k += 2) {
      const Vec3d middle = 0.5 * (corners[6 * s + k] + corners[6 * s + k + 1]);
      EXPECT_NEAR(length(middle - t.points[s]), 0, 1e-6);
    }
}

}  // namespace
}  // namespace fracture::test
