// Does glass break like glass and wood like wood? Tests lower limits of measurable properties for each
// material, from the positions in the file.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/pipeline/looks.hpp"
#include "tests/support/assemble.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/full_tests.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::test {
namespace {

/// The share of the cut area whose normal is within 15 degrees of radial or tangential about the z axis
/// through the centre.
double radial_share(const FragmentSet& set, const Vec3d& center) {
  double all = 0, good = 0;
  const double limit = std::cos(15 * M_PI / 180);
  for_each_cut(set, [&](const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    const Vec3d n = cross(b - a, c - a), middle = (1.0 / 3) * (a + b + c) - center;
    const double area = 0.5 * length(n), across = std::hypot(middle.x, middle.y);
    all += area;
    if (area == 0 || across == 0) return;
    const Vec3d unit = (0.5 / area) * n;
    const double radial = (unit.x * middle.x + unit.y * middle.y) / across,
                 tangential = (unit.y * middle.x - unit.x * middle.y) / across;
    if (std::fabs(radial) >= limit || std::fabs(tangential) >= limit) good += area;
  });
  return good / all;
}

TEST(GlassLooks, FourFifthsOfTheCutsAreRadialOrTangential) {
  for (std::uint64_t seed = 1; seed <= sized(1u, 3u); ++seed)
    for (const std::uint32_t sites : {20u, 50u, 200u}) {
      SCOPED_TRACE(sites);
      const FragmentSet pane =
          fractured(box({0, 0, 0}, {2, 1.5, 0.02}, 4), material("glass", sites, seed)).set;
      EXPECT_GE(radial_share(pane, {1, 0.75, 0.01}), 0.8);
      FractureParameters hit = material("glass", sites, seed);
      std::get<RadialPattern>(hit.pattern).impacts = {{0.3, 0.4, 0}};
      EXPECT_GE(radial_share(fractured(box({0, 0, 0}, {2, 1.5, 0.02}, 4), hit).set, {0.3, 0.4, 0}), 0.8);
      EXPECT_GE(pane.fragments.size(), sites / 2);
      EXPECT_LE(pane.fragments.size(), sites * 2);
    }
}

TEST(GlassLooks, APaneThatStandsAskewIsCutAcrossItsPlane) {
  const double c = std::cos(0.6), s = std::sin(0.6);
  const auto turned = [&](const Vec3d& p) { return Vec3d{p.x, c * p.y - s * p.z, s * p.y + c * p.z}; };
  Mesh pane = box({0, 0, 0}, {2, 1.5, 0.02}, 4);
  for (Vec3f& p : pane.positions) p = to_float(turned(to_double(p)));
  const FragmentSet set = fractured(pane, material("glass", 50)).set;
  const Vec3d normal = turned({0, 0, 1});
  double all = 0, across = 0;
  for_each_cut(set, [&](const Vec3d& a, const Vec3d& b, const Vec3d& d) {
    const Vec3d n = cross(b - a, d - a);
    all += length(n);
    if (std::fabs(dot(n, normal)) < std::sin(20 * M_PI / 180) * length(n)) across += length(n);
  });
  EXPECT_GT(across, 0.95 * all);
}

TEST(WoodLooks, MedianExtentAlongTheGrainIsFourTimesThatAcross) {
  const std::vector<Mesh> meshes{box({0, 0, 0}, {0.2, 2, 0.2}, 4), cube(4),
                                 box({0, 0, 0}, {1.2, 1, 0.05}, 4)};
  for (const Mesh& mesh : meshes)
    for (const std::uint32_t sites : {50u, 150u}) {
      const Vec3d size = box_of(mesh).size();
      SCOPED_TRACE(std::to_string(sites) + " sites, box " + std::to_string(size.x) + " x " +
                   std::to_string(size.y));
      const int grain = size.x > size.y ? 0 : 1;
      std::vector<double> along, across;
      for (const Fragment& f : fractured(mesh, material("wood", sites)).set.fragments) {
        const Vec3d s = extent_of(f);
        along.push_back(s[grain]);
        for (const int k : {1, 2}) across.push_back(s[(grain + k) % 3]);
      }
      EXPECT_GE(median(along), 4 * median(across));
    }
}

TEST(BrickLooks, NoCutIsFartherThanTheJitterFromAMortarPlane) {
  for (const double jitter : {0.0, 0.05, 0.5}) {
    SCOPED_TRACE(jitter);
    FractureParameters p = material("brick", 50);
    auto& brick = std::get<BrickPattern>(p.pattern);
    brick.cell = Vec3d{0.225, 0.075, 0.1125};
    brick.jitter = jitter;
    // 9 bricks long, 16 courses high, two wythes deep: the lattice of bricks begins at the corner of the box.
    const Mesh wall = box({0, 0, 0}, {9 * 0.225, 16 * 0.075, 2 * 0.1125}, 3);
    const FragmentSet set = fractured(wall, p).set;
    // 9 bricks per course and wythe, or 8 and two halves.
    EXPECT_EQ(set.fragments.size(), 2u * 8 * (9 + 10));
    const Vec3d mortar{0.225 / 2, 0.075, 0.1125};  // every second plane along x cuts a course
    double worst = 0;
    for_each_cut(set, [&](const Vec3d& a, const Vec3d& b, const Vec3d& c) {
      const Vec3d n = cross(b - a, c - a);
      int axis = 0;
      for (int k = 1; k < 3; ++k)
        if (std::fabs(n[k]) > std::fabs(n[axis])) axis = k;
      for (const Vec3d& q : {a, b, c}) {
        const double off = q[axis] - std::nearbyint(q[axis] / mortar[axis]) * mortar[axis];
        worst = std::max(worst, std::fabs(off) / mortar[axis]);
      }
    });
    EXPECT_LE(worst, 0.5 * jitter + 1e-4);
  }
}

TEST(BrickLooks, CutsOfAWallThatStandsAskewAreAlongItsAxes) {
  constexpr double kYaw = 0.5;
  const double c = std::cos(kYaw), s = std::sin(kYaw);
  Mesh wall = box({0, 0, 0}, {2.4, 1.5, 0.24}, 3);
  for (Vec3f& p : wall.positions)
    p = {static_cast<float>(c * p.x + s * p.z), p.y, static_cast<float>(c * p.z - s * p.x)};
  FractureParameters p = material("brick", 60);
  std::get<BrickPattern>(p.pattern).jitter = 0;
  const FragmentSet set = fractured(wall, p).set;
  EXPECT_EQ(set.fragments.size(), 60u);
  double all = 0, along = 0;
  for_each_cut(set, [&](const Vec3d& a, const Vec3d& b, const Vec3d& d) {
    const Vec3d n = cross(b - a, d - a);
    all += length(n);
    for (const Vec3d& axis : {Vec3d{c, 0, -s}, Vec3d{0, 1, 0}, Vec3d{s, 0, c}})
      if (std::fabs(dot(n, axis)) > 0.9999 * length(n)) along += length(n);
  });
  EXPECT_GT(along, 0.999 * all);
}

TEST(ConcreteLooks, TheLargestTenthOfTheFragmentsHoldsHalfOfTheVolume) {
  for (std::uint64_t seed = 1; seed <= sized(1u, 3u); ++seed)
    for (const Mesh& mesh : {cube(4), sphere_with(2000), box({0, 0, 0}, {0.4, 3, 0.4}, 4)})
      for (const std::uint32_t sites : {50u, 100u, 300u}) {
        SCOPED_TRACE(std::to_string(sites) + " sites, seed " + std::to_string(seed));
        EXPECT_GE(share_of_largest(fractured(mesh, material("concrete", sites, seed)).set, 0.1), 0.5);
      }
}

TEST(LloydLooks, FivePassesHalveTheCoefficientOfVariation) {
  for (const Mesh& mesh : {cube(4), sphere_with(2000), torus(48, 24)})
    for (const std::uint32_t sites : {50u, 200u}) {
      SCOPED_TRACE(std::to_string(sites) + " sites, " + std::to_string(mesh.triangles.size()) + " triangles");
      double uniform = 0, relaxed = 0;
      for (const std::uint64_t seed : {1u, 2u, 3u}) {
        FractureParameters p;
        p.sites = sites;
        p.seed = seed;
        uniform += coefficient_of_variation(fractured(mesh, p).set);
        p.lloyd = 5;
        const FracturedSolid even = fractured(mesh, p);
        relaxed += coefficient_of_variation(even.set);
        EXPECT_NEAR(even.report.size.volumes.coefficient_of_variation, coefficient_of_variation(even.set),
                    1e-12);
      }
      EXPECT_LE(relaxed, 0.5 * uniform);
    }
}

TEST(ImpactLooks, PiecesAreSmallerNearTheImpact) {
  FractureParameters p;
  p.sites = 200;
  p.pattern = ImpactPattern{.impacts = {{0.5, 0.5, 0.5}}, .radius = 0.3};
  std::vector<double> near, far;
  for (const Fragment& f : fractured(cube(4), p).set.fragments) {
    const double distance = length(f.mass.center_of_mass - Vec3d{0.5, 0.5, 0.5});
    (distance < 0.3 ? near : far).push_back(f.mass.volume);
  }
  ASSERT_GT(near.size(), 100u);
  ASSERT_GT(far.size(), 10u);
  EXPECT_LT(20 * median(near), median(far));
}

TEST(SliceLooks, ObliqueFamiliesCutOnlyAlongTheirPlanes) {
  FractureParameters p;
  p.sites = 60;
  const std::vector<Vec3d> normals{{1, 0.3, 0}, {0, 1, 0.2}, {0.4, -0.2, 1}};
  p.pattern = SlicePattern{.normals = normals};
  const FragmentSet set = fractured(cube(3), p).set;
  EXPECT_GT(set.fragments.size(), 30u);
  double worst = 0;
  for_each_cut(set, [&](const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    const Vec3d n = cross(b - a, c - a);
    if (length(n) < 1e-6) return;  // a sliver's normal is rounding error
    double best = 0;
    for (const Vec3d& m : normals) best = std::max(best, std::fabs(dot(n, m)) / (length(n) * length(m)));
    worst = std::max(worst, 1 - best);
  });
  EXPECT_LT(worst, 1e-4);
}

}  // namespace
}  // namespace fracture::test
