// Sites so close together that products of their differences underflow. All invariants must hold, and cuts
// must lie on the bisectors.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/property/judge.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/fractured.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::test {
namespace {

/// A turned cube. No edge has round components.
Mesh turned_cube() {
  Mesh mesh = cube();
  for (Vec3f& p : mesh.positions) {
    const double c = 0.8253356149096783, s = 0.5646424733950354;  // c² + s² = 1, up to rounding
    const double x = c * p.x - s * p.y, y = s * p.x + c * p.y, z = p.z;
    p = {static_cast<float>(x), static_cast<float>(c * y - s * z), static_cast<float>(s * y + c * z)};
  }
  return with_traced_triangles(std::move(mesh));
}

void expect_invariants(const FragmentSet& set, const Mesh& mesh) {
  expect_closed(set);
  expect_partition(set, volume_of(mesh), area_of(mesh));
  expect_outside_untouched(set, mesh);
}

TEST(NearSites, TwoAreCutAtTheirBisector) {
  const Mesh mesh = turned_cube();
  for (const double tiny : {1e-100, 1e-160, 1e-310, 1e-320, 0x8p-1074}) {
    SCOPED_TRACE(tiny);
    const Vec3d u{tiny, 0.75 * tiny, -1.25 * tiny};
    FractureParameters p;
    p.pattern = PointsPattern{{{0, 0, 0}, u}};
    const FragmentSet set = fracture_mesh(mesh, p).set;
    ASSERT_EQ(set.fragments.size(), 2u);
    expect_invariants(set, mesh);
    // The bisector passes through the origin, as nearly as a double can tell. u has few bits, or is an
    // integer multiple of the smallest double, so 2^k u is exact.
    Vec3d normal;
    for (int a = 0; a < 3; ++a) normal[a] = std::ldexp(u[a], -std::ilogb(tiny));
    normal = (1 / length(normal)) * normal;
    double farthest = 0;
    for (const Fragment& f : set.fragments)
      for (const FragmentPrimitive& primitive : f.primitives)
        if (primitive.material == kInteriorMaterial)
          for (std::uint32_t k = 0; k < primitive.index_count; ++k) {
            const Vec3d q = to_double(f.positions[f.indices[primitive.first_index + k]]) + f.pivot;
            farthest = std::fmax(farthest, std::fabs(dot(q, normal)));
          }
    EXPECT_LE(farthest, set.lattice_step.x + set.lattice_step.y + set.lattice_step.z);
  }
}

TEST(NearSites, FourAroundOnePlaceKeepAllInvariants) {
  const Mesh mesh = turned_cube();
  for (const double tiny : {1e-100, 1e-150, 1e-160, 1e-161, 1e-162, 1e-170, 1e-310}) {
    SCOPED_TRACE(tiny);
    FractureParameters p;
    p.pattern = PointsPattern{{{0, 0, 0},
                               {tiny, 0.7 * tiny, -1.3 * tiny},
                               {-0.4 * tiny, 1.1 * tiny, 0.3 * tiny},
                               {0.2 * tiny, -0.9 * tiny, 0.6 * tiny}}};
    const FragmentSet set = fracture_mesh(mesh, p).set;
    EXPECT_EQ(set.fragments.size(), 4u);
    expect_invariants(set, mesh);
  }
}

}  // namespace
}  // namespace fracture::test
