// How polygons with more than three corners become triangles.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "common/import/import.hpp"

namespace fracture::test {
namespace {

Mesh obj(const std::string& text) {
  Expected<Mesh> mesh = import_mesh(std::as_bytes(std::span(text.data(), text.size())), MeshFormat::kObj, {});
  if (!mesh) throw std::runtime_error(mesh.error().detail);
  return std::move(*mesh);
}

/// The sum of |area| of the triangles, and the sum of the signed area along z.
std::pair<double, double> areas(const Mesh& m) {
  double total = 0, up = 0;
  for (const auto& t : m.triangles) {
    const Vec3d a = to_double(m.positions[t[0]]),
                n = cross(to_double(m.positions[t[1]]) - a, to_double(m.positions[t[2]]) - a);
    total += length(n) / 2;
    up += n.z / 2;
  }
  return {total, up};
}

TEST(Polygons, AFlatOneWithAReflexCornerIsNotFolded) {
  // An arrow head. The fan from its first corner would fold over itself. Its area by the shoelace formula is
  // 4.
  const Mesh quad = obj("v 0 2 0\nv -2 -1 0\nv 0 0 0\nv 2 -1 0\nf 2 3 4 1\n");
  const auto [total, up] = areas(quad);
  EXPECT_EQ(quad.triangles.size(), 2u);
  EXPECT_NEAR(total, 4, 1e-6);
  EXPECT_NEAR(up, 4, 1e-6);
  const Mesh l = obj("v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nf 3 4 5 6 1 2\n");
  EXPECT_EQ(l.triangles.size(), 4u);
  EXPECT_NEAR(areas(l).first, 3, 1e-6);
  EXPECT_NEAR(areas(l).second, 3, 1e-6);
}

TEST(Polygons, ABentOneIsTheFanFromItsFirstCorner) {
  const Mesh m = obj("v 0 0 0\nv 1 0 1\nv 1 1 0\nv 0 1 1\nf 1 2 3 4\nf 2 3 4 1\n");
  ASSERT_EQ(m.triangles.size(), 4u);
  const auto corner = [&](std::size_t t, std::size_t k) { return m.positions[m.triangles[t][k]]; };
  EXPECT_EQ(corner(0, 0), (Vec3f{0, 0, 0}));
  EXPECT_EQ(corner(1, 0), (Vec3f{0, 0, 0}));
  EXPECT_EQ(corner(1, 1), (Vec3f{1, 1, 0}));
  EXPECT_EQ(corner(2, 0), (Vec3f{1, 0, 1}));
  EXPECT_EQ(corner(3, 1), (Vec3f{0, 1, 1}));
}

}  // namespace
}  // namespace fracture::test
