#include <gtest/gtest.h>

#include <cmath>

#include "common/sites/sites.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/solids.hpp"

namespace fracture::test {
namespace {

std::vector<Vec3d> sites_of(const Solid& solid, std::uint32_t count, std::uint64_t seed = 1) {
  return *uniform_sites(solid, count, seed, {});
}

TEST(SiteLattice, IsAPowerOfTwoAndTheBoxAtMostTwoToThe21StepsWide) {
  for (const double side : {1.0, 1.5, 2.0, 3e-5, 1e6, 0.9999999}) {
    Box box;
    box.add(Vec3d{10, 10, 10});
    box.add(Vec3d{10, 10 + side, 10 + side / 3});
    const double step = site_lattice(box).step;
    int exponent = 0;
    EXPECT_EQ(std::frexp(step, &exponent), 0.5);
    EXPECT_LE(box.longest_side() / step, 0x1p21);
    EXPECT_GT(box.longest_side() / step, 0x1p20 * 0.999999);
  }
}

TEST(SiteLattice, SnapsToTheNearestPointTiesToEven) {
  const SiteLattice lattice{0.25};
  EXPECT_EQ(lattice.snap({0.3, -0.3, 0.125}), (Vec3d{0.25, -0.25, 0}));
  EXPECT_EQ(lattice.snap({0.375, 1e9, -0.01}), (Vec3d{0.5, 1e9, 0}));
  EXPECT_FALSE(std::signbit(lattice.snap({0, 0, -0.01}).z));
}

TEST(UniformSites, LieInsideUpToTheLattice) {
  for (const NamedMesh& shape : closed_shapes()) {
    SCOPED_TRACE(shape.name);
    const Solid solid = solid_of(shape.mesh);
    const std::vector<Vec3d> sites = sites_of(solid, 100);
    ASSERT_EQ(sites.size(), 100u);
    const double step = site_lattice(solid.box).step;
    std::size_t outside = 0;
    for (const Vec3d& p : sites) {
      EXPECT_EQ(site_lattice(solid.box).snap(p), p);
      for (int a = 0; a < 3; ++a) {
        EXPECT_GE(p[a], solid.box.min[a] - step);
        EXPECT_LE(p[a], solid.box.max[a] + step);
      }
      outside += winding_number(shape.mesh, p) < 0.5;
    }
    EXPECT_LE(outside, 2u) << "only points within a lattice step of the surface may fall out";
  }
}

TEST(UniformSites, AreAPrefixOfEveryLongerSequence) {
  const Solid solid = solid_of(torus(32, 16));
  const std::vector<Vec3d> all = sites_of(solid, 1000, 42);
  for (const std::uint32_t n : {0u, 1u, 2u, 50u, 999u}) {
    const std::vector<Vec3d> some = sites_of(solid, n, 42);
    EXPECT_EQ(some, std::vector<Vec3d>(all.begin(), all.begin() + n));
  }
}

TEST(UniformSites, DependOnTheSeed) {
  const Solid solid = solid_of(cube());
  EXPECT_EQ(sites_of(solid, 20, 1), sites_of(solid, 20, 1));
  EXPECT_NE(sites_of(solid, 20, 1), sites_of(solid, 20, 2));
}

/// Pearson's statistic of counts compared with expected counts.
double chi_square(const std::vector<double>& counts, const std::vector<double>& expected) {
  double chi = 0;
  for (std::size_t i = 0; i < counts.size(); ++i)
    chi += (counts[i] - expected[i]) * (counts[i] - expected[i]) / expected[i];
  return chi;
}

TEST(UniformSites, FillTheOctantsAndRadiiOfABallEvenly) {
  const Solid solid = solid_of(sphere_with(8000));
  constexpr int kCount = 16000;
  std::vector<double> octants(8, 0), radii(8, 0);
  for (const Vec3d& p : sites_of(solid, kCount, 3)) {
    ++octants[static_cast<std::size_t>((p.x > 0) + 2 * (p.y > 0) + 4 * (p.z > 0))];
    const double r = length(p);
    ++radii[std::min<std::size_t>(7, static_cast<std::size_t>(8 * r * r * r))];
  }
  // 7 degrees of freedom: chance exceeds 24.3 once in a thousand runs (the polyhedron's last shell is
  // slightly smaller).
  EXPECT_LT(chi_square(octants, std::vector<double>(8, kCount / 8.0)), 24.3);
  EXPECT_LT(chi_square(radii, std::vector<double>(8, kCount / 8.0)), 28);
}

TEST(UniformSites, FillASpongeInProportionToItsSubcubes) {
  const Solid solid = solid_of(menger_sponge(2));
  constexpr int kCount = 20000;
  std::vector<double> cells(27, 0);
  for (const Vec3d& p : sites_of(solid, kCount, 9)) {
    const auto index = [](double t) { return std::min(2, std::max(0, static_cast<int>(3 * t))); };
    ++cells[static_cast<std::size_t>(index(p.x) + 3 * index(p.y) + 9 * index(p.z))];
  }
  std::vector<double> solid_cells;
  double stray = 0;
  for (int z = 0; z < 3; ++z)
    for (int y = 0; y < 3; ++y)
      for (int x = 0; x < 3; ++x) {
        const double count = cells[static_cast<std::size_t>(x + 3 * y + 9 * z)];
        if ((x == 1) + (y == 1) + (z == 1) < 2)
          solid_cells.push_back(count);
        else
          stray += count;
      }
  ASSERT_EQ(solid_cells.size(), 20u);
  EXPECT_LE(stray, 2);  // 19 degrees of freedom: 43.8 once in a thousand
  EXPECT_LT(chi_square(solid_cells, std::vector<double>(20, kCount / 20.0)), 43.8);
}

TEST(UniformSites, CountOverlapsOnceAndPartsByVolume) {
  // Two boxes overlap at [0,2] and [1,3] in x. Their union is [0,3], and each third gets a third of its
  // sites. A separate third box has volume 1.
  const Solid solid =
      solid_of(joined({box({0, 0, 0}, {2, 1, 1}), box({1, 0, 0}, {3, 1, 1}), box({5, 0, 0}, {6, 1, 1})}));
  constexpr int kCount = 12000;
  std::vector<double> counts(4, 0);
  for (const Vec3d& p : sites_of(solid, kCount, 4))
    ++counts[static_cast<std::size_t>(p.x < 3 ? std::max(0.0, p.x) : 3)];
  EXPECT_LT(chi_square(counts, std::vector<double>(4, kCount / 4.0)), 16.3);  // 3 degrees of freedom
}

TEST(UniformSites, LeaveCavitiesEmpty) {
  const Mesh mesh = nested_spheres(2, 800, 0.5);
  const Solid solid = solid_of(mesh);
  for (const Vec3d& p : sites_of(solid, 500)) EXPECT_GT(length(p), 0.45);
}

TEST(UniformSites, FillThinAndSlantedSolidsToo) {
  // A plate of thickness 1e-4, turned so that it is thin along no axis.
  Mesh plate = thin_plate(1e-4, 8);
  for (Vec3f& p : plate.positions) {
    const double x = p.x, y = p.y, z = p.z;
    p = {static_cast<float>(x + 0.5 * y - z), static_cast<float>(y + z), static_cast<float>(x + y + z)};
  }
  const Solid solid = solid_of(plate);
  const std::vector<Vec3d> sites = sites_of(solid, 2000, 6);
  ASSERT_EQ(sites.size(), 2000u);
  std::vector<double> quarters(4, 0);
  for (const Vec3d& p : sites) {  // back to plate coordinates, up to its thickness
    const double y = 2 * (p.z - p.x), x = p.z - y;
    ++quarters[static_cast<std::size_t>((x > 0.5) + 2 * (y > 0.5))];
  }
  EXPECT_LT(chi_square(quarters, std::vector<double>(4, 500)), 16.3);
}

TEST(UniformSites, WorkForSelfCrossingSurfacesFarFromTheOrigin) {
  const Mesh mesh = translated(self_crossing_tube(), {1000, -2000, 500});
  const Solid solid = solid_of(mesh);
  std::size_t outside = 0;
  for (const Vec3d& p : sites_of(solid, 200)) outside += winding_number(mesh, p) < 0.5;
  EXPECT_LE(outside, 2u);
}

}  // namespace
}  // namespace fracture::test
