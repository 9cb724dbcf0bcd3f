#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/physics/collision_hulls.hpp"
#include "common/physics/principal_axes.hpp"
#include "common/pipeline/fracture.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/site_families.hpp"

namespace fracture::test {
namespace {

FracturedSolid fracture_at(const Mesh& mesh, FractureParameters p) {
  p.hulls = Hulls::kConvex;
  StageTimings timings;
  const Expected<Solid> solid = make_solid(std::make_shared<Mesh>(mesh), {}, {});
  return *fracture(*solid, *make_diagram(*solid, p, {}, timings), p, {}, timings);
}

/// The tensor computed back from moments and rotation.
std::array<double, 6> tensor_of(const PrincipalAxes& p) {
  const auto [x, y, z, w] = p.rotation;
  const double r[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)},
                          {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)},
                          {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}};
  double t[3][3] = {};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 3; ++k) t[i][j] += r[i][k] * p.moments[static_cast<std::size_t>(k)] * r[j][k];
  return {t[0][0], t[1][1], t[2][2], t[0][1], t[0][2], t[1][2]};
}

TEST(PrincipalAxes, GiveTheTensorBack) {
  for (const std::array<double, 6>& t : {std::array<double, 6>{1, 2, 3, 0, 0, 0},
                                         {2, 2, 2, 0, 0, 0},
                                         {3, 3, 3, 1, 1, 1},
                                         {5, 4, 6, 0.1, -1.5, 0.7},
                                         {1, 1, 1, 1e-13, 0, 0},
                                         {1e-9, 2e-9, 3e-9, 1e-10, 1e-10, -1e-10}}) {
    const PrincipalAxes p = principal_axes(t);
    const auto back = tensor_of(p);
    double scale = 0, norm = 0;
    for (const double v : t) scale = std::max(scale, std::fabs(v));
    for (int k = 0; k < 6; ++k)
      EXPECT_NEAR(back[static_cast<std::size_t>(k)], t[static_cast<std::size_t>(k)], 1e-12 * scale);
    for (const double c : p.rotation) norm += c * c;
    EXPECT_NEAR(norm, 1, 1e-14);
  }
}

TEST(BodyInertia, IsTheFragmentsOwnUnlessNoBodyHasIt) {
  Fragment f;
  f.mass.volume = 6;
  f.mass.center_of_mass = {1.5, 1, 0.5};  // of the box [1, 2] x [0, 2] x [-1, 2]
  f.pivot = {1, 0, 0};
  for (int k = 0; k < 8; ++k)
    f.positions.push_back({k & 1 ? 1.0f : 0.0f, k & 2 ? 2.0f : 0.0f, k & 4 ? 2.0f : -1.0f});
  const std::array<double, 6> solid{6 * 13 / 12.0, 6 * 10 / 12.0, 6 * 5 / 12.0, 0, 0, 0};
  for (const std::array<double, 6>& own :
       {solid, std::array<double, 6>{-2, 3, 4, 0, 0, 0}, {1, 1, 3, 0, 0, 0}, {0, 0, 0, 0, 0, 0}}) {
    f.mass.inertia = own;
    const auto tensor = tensor_of(body_inertia(f));
    for (std::size_t k = 0; k < 6; ++k) EXPECT_NEAR(tensor[k], solid[k], 1e-12);
  }
  f.mass.inertia = {2, 2, 3, 0.1, 0, 0};
  const auto tensor = tensor_of(body_inertia(f));
  for (std::size_t k = 0; k < 6; ++k) EXPECT_NEAR(tensor[k], f.mass.inertia[k], 1e-12);
}

TEST(BodyVolume, IsThatOfAThinSheetWhereThereIsNone) {
  Fragment f;
  f.positions = {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {0, 1, 0}};
  f.mass.area = 4;  // both sides
  for (const double none : {0.0, -6e-20}) {
    f.mass.volume = none;
    EXPECT_DOUBLE_EQ(body_volume(f), 2 * 2e-6);
    // Its own tensor is only rounding. The result must be that of a box of 2 x 1 x 0 with this mass.
    f.mass.inertia = {1e-22, 1e-22, 1.5e-22, 0, 0, 0};
    f.mass.center_of_mass = {1, 0.5, 0};
    const auto tensor = tensor_of(body_inertia(f));
    EXPECT_NEAR(tensor[0], 4e-6 / 12, 1e-12);
    EXPECT_NEAR(tensor[1], 4e-6 * 4 / 12, 1e-12);
    EXPECT_NEAR(tensor[2], 4e-6 * 5 / 12, 1e-12);
  }
  f.mass.volume = 1e-9;
  EXPECT_EQ(body_volume(f), 1e-9);
}

Mesh mesh_of(const CollisionHull& hull) {
  Mesh m;
  m.positions = hull.points;
  m.triangles = hull.triangles;
  return m;
}

TEST(CollisionHulls, AreClosedConvexAndOutward) {
  for (const Mesh& mesh : {torus(32, 16), menger_sponge(1), sphere_with(2000)}) {
    FractureParameters p;
    p.sites = 40;
    p.hull_limits.count = 1;
    const FracturedSolid made = fracture_at(mesh, p);
    for (std::size_t k = 0; k < made.set.fragments.size(); ++k) {
      const Fragment& f = made.set.fragments[k];
      ASSERT_EQ(made.hulls.of(k).size(), 1u);
      const Mesh hull = mesh_of(made.hulls.of(k)[0]);
      EXPECT_LE(hull.positions.size(), kMaxHullPoints);
      EXPECT_EQ(open_directed_edges(hull), 0u);
      // The hull holds the fragment, except for the amount that shrinking takes.
      EXPECT_GT(volume_of(hull), (1 - 3 * kLeastHullShrink) * f.mass.volume - 3 * kHullInset * f.mass.area);
    }
  }
}

TEST(CollisionHulls, OfNeighboursAreSeparatedByTheBisectorOfTheirSites) {
  FractureParameters p;
  const std::vector<Vec3d> points = random_sites(box_of(cube()), 60, 9);
  p.pattern = PointsPattern{points};
  const FracturedSolid made = fracture_at(cube(), p);
  for (const Bond& b : made.set.bonds) {
    const Fragment &f = made.set.fragments[b.a], &g = made.set.fragments[b.b];
    const Vec3d i = points[f.sites[0]], j = points[g.sites[0]], u = j - i, middle = 0.5 * (i + j);
    for (const Vec3f& q : made.hulls.of(b.a)[0].points) EXPECT_LT(dot(to_double(q) + f.pivot - middle, u), 0);
    for (const Vec3f& q : made.hulls.of(b.b)[0].points) EXPECT_GT(dot(to_double(q) + g.pivot - middle, u), 0);
  }
}

TEST(CollisionHulls, AGroupCarriesOneForEachMemberCell) {
  FractureParameters p;
  PointsPattern pattern{random_sites(box_of(cube()), 30, 9)};
  for (std::uint32_t k = 0; k < 30; ++k) pattern.groups.push_back(k < 10 ? 0 : k);
  p.pattern = std::move(pattern);
  p.hull_limits.count = 10;
  const FracturedSolid made = fracture_at(cube(), p);
  std::size_t shared = 0;
  for (std::size_t k = 0; k < made.set.fragments.size(); ++k) {
    const Fragment& f = made.set.fragments[k];
    const std::span<const CollisionHull> hulls = made.hulls.of(k);
    if (f.sites.size() == 1) {
      EXPECT_EQ(hulls.size(), 1u);
      continue;
    }
    shared += hulls.size();
    double volume = 0;
    for (const CollisionHull& h : hulls) volume += volume_of(mesh_of(h));
    // Cells of a convex body: their hulls fill the group, except for the amount that shrinking takes.
    EXPECT_LT(volume, f.mass.volume);
    EXPECT_GT(volume, 0.95 * f.mass.volume);
  }
  EXPECT_EQ(shared, 10u);
}

TEST(CollisionHulls, AreInsetByAFewTenthsOfAMillimetreOrAThousandth) {
  for (const float size : {0.0001f, 0.01f, 1.0f, 1000.0f}) {
    Mesh mesh = cube();
    for (Vec3f& p : mesh.positions) p = {size * p.x, size * p.y, size * p.z};
    FractureParameters p;
    p.pattern = PointsPattern{{{0.5 * size, 0.5 * size, 0.5 * size}}};
    const FracturedSolid made = fracture_at(mesh, p);
    ASSERT_EQ(made.hulls.of(0)[0].points.size(), 8u);
    const Box box = box_of(mesh_of(made.hulls.of(0)[0]));
    // For a cube, A / V = 6 / size: its faces move by three times the inset.
    const double expected =
        std::clamp(3 * kHullInset, kLeastHullShrink * size / 2, kMostHullShrink * size / 2);
    for (int a = 0; a < 3; ++a)
      EXPECT_NEAR((size - (box.max[a] - box.min[a])) / 2, expected, 1e-6 * size) << size;
  }
}

TEST(CollisionHulls, ManyPointsAreSimplified) {
  FractureParameters p;
  p.pattern = PointsPattern{{{0, 0, 0}}};
  const FracturedSolid made = fracture_at(sphere_with(20'000), p);
  ASSERT_EQ(made.set.fragments.size(), 1u);
  EXPECT_EQ(made.hulls.of(0)[0].points.size(), kMaxHullPoints);
  // 255 points spread evenly over a sphere enclose 0.97 of its ball.
  EXPECT_GT(volume_of(mesh_of(made.hulls.of(0)[0])), 0.95 * made.set.fragments[0].mass.volume);
  EXPECT_EQ(made.report.hulls.value().simplified, 1u);
}

}  // namespace
}  // namespace fracture::test
