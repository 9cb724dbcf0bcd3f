// The hulls of fragments of shapes and real meshes, for harmless and adversarial sites. They must be convex,
// and as large as required. Most hulls are the surfaces of their fragments. Their convexity follows from
// tests of a few of their edges, or of none.
#include <gtest/gtest.h>

#include <algorithm>

#include "common/physics/collision_hulls.hpp"
#include "common/pipeline/fracture.hpp"
#include "tests/support/closed_inputs.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/fractured.hpp"
#include "tests/support/full_tests.hpp"
#include "tests/support/site_families.hpp"

namespace fracture::test {
namespace {

constexpr std::uint64_t kSeed = 20261127;
/// A share of the longest side of the hull's box: 64 steps of 2^-19 (SurfaceHull::kMostAbove), and rounding
/// to floats.
constexpr double kConvexTo = 2e-4;
/// A hull may lose 10.4 tolerances of its volume (see convex_hull_test).
constexpr double kLeastOfVolume = 1 - 10.4 * kHullTolerance;
/// Steps of the lattice.
constexpr double kWide = 1000;

void expect_convex(const CollisionHull& hull) {
  Box box;
  for (const Vec3f& p : hull.points) box.add(to_double(p));
  double most = 0;
  for (const auto& t : hull.triangles) {
    const Vec3d a = to_double(hull.points[t[0]]);
    const Vec3d n = cross(to_double(hull.points[t[1]]) - a, to_double(hull.points[t[2]]) - a);
    // Compares twice the area times a height, because a sliver's own plane says little about the points above
    // it.
    for (const Vec3f& p : hull.points) most = std::max(most, dot(n, to_double(p) - a));
  }
  const double side = box.longest_side();
  EXPECT_LE(most, kConvexTo * side * side * side);
}

/// `input` is the number of has_turn(). In short tests each family runs on some of the inputs.
void expect_sound_hulls(const Mesh& mesh, const std::vector<SiteFamily>& families, std::size_t input) {
  for (std::size_t turn = 0; turn < families.size(); ++turn) {
    if (!has_turn(input, turn, 4)) continue;
    const SiteFamily& family = families[turn];
    SCOPED_TRACE("sites: " + family.name);
    FractureParameters p;
    p.pattern = PointsPattern{family.sites};
    const Fractured f = fracture_mesh(mesh, p);
    const CollisionHulls hulls = make_collision_hulls(f.set, {}, HullLimits{.count = 1}, {});
    for (std::size_t k = 0; k < f.set.fragments.size(); ++k) {
      const Fragment& fragment = f.set.fragments[k];
      SCOPED_TRACE("fragment " + std::to_string(k));
      for (const CollisionHull& hull : hulls.of(k)) expect_convex(hull);
      if (hulls.of(k).size() != 1 || hulls.of_fragment[k].flat > 0) continue;
      // Rounding changes crumbs of a few lattice steps into other bodies.
      if (2 * fragment.mass.volume < kWide * length(f.set.lattice_step) * fragment.mass.area) continue;
      Mesh body;
      body.positions = hulls.of(k)[0].points;
      body.triangles = hulls.of(k)[0].triangles;
      EXPECT_EQ(open_directed_edges(body), 0u);
      EXPECT_GT(volume_of(body), kLeastOfVolume * (1 - 3 * kLeastHullShrink) * fragment.mass.volume -
                                     3 * kHullInset * fragment.mass.area);
    }
  }
}

class HullsOfClosedShape : public OnClosedShape {};
TEST_P(HullsOfClosedShape, AreConvexAndLargeEnough) {
  expect_sound_hulls(shape().mesh, site_families(shape().mesh, kSeed), GetParam());
}
INSTANTIATE_TEST_SUITE_P(Seed20261127, HullsOfClosedShape, every_closed_shape(), name_of_shape);

class HullsOfClosedMesh : public OnClosedMesh {};
TEST_P(HullsOfClosedMesh, AreConvexAndLargeEnough) {
  expect_sound_hulls(mesh, small_site_families(mesh, kSeed), number());
}
INSTANTIATE_TEST_SUITE_P(Dev, HullsOfClosedMesh, every_closed_mesh(), name_of_mesh);

}  // namespace
}  // namespace fracture::test
