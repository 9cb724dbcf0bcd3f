// Random damage to closed meshes. make_solid() must always end with a valid solid or a typed refusal, and
// with the same one every time.
#include <gtest/gtest.h>

#include "common/base/random.hpp"
#include "common/solid/solid.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/repetitions.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/surface_mesh.hpp"

namespace fracture::test {
namespace {

/// Removes, reverses, copies and reconnects random triangles.
Mesh damaged(Mesh mesh, Random& random, int blows) {
  for (int i = 0; i < blows && !mesh.triangles.empty(); ++i) {
    const std::size_t t = random.below(mesh.triangles.size());
    const std::uint64_t kind = random.below(6);
    if (kind == 0) {
      mesh.triangles.erase(mesh.triangles.begin() + static_cast<std::ptrdiff_t>(t));
    } else if (kind == 1) {
      std::swap(mesh.triangles[t][0], mesh.triangles[t][1]);
    } else if (kind == 2) {
      const auto copy = mesh.triangles[t];
      mesh.triangles.push_back(copy);
    } else if (kind == 3) {
      auto copy = mesh.triangles[t];
      std::swap(copy[1], copy[2]);
      mesh.triangles.push_back(copy);
    } else if (kind == 4) {
      const auto corner = random.below(3);
      const auto vertex = random.below(mesh.positions.size());
      mesh.triangles[t][corner] = static_cast<std::uint32_t>(vertex);
    } else {  // two vertices at one place
      const auto a = random.below(mesh.positions.size()), b = random.below(mesh.positions.size());
      mesh.positions[a] = mesh.positions[b];
    }
  }
  mesh.material.assign(mesh.triangles.size(), kNoIndex);
  mesh.node.assign(mesh.triangles.size(), 0);
  return mesh;
}

TEST(RandomDamage, EndsAsAValidSolidOrATypedRefusal) {
  std::size_t solids = 0;
  for (std::uint64_t seed = 0; seed < static_cast<std::uint64_t>(test::repetitions(600)); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    Mesh base;
    const std::uint64_t shape = seed % 5;
    base = shape == 0   ? cube(3)
           : shape == 1 ? sphere_with(200)
           : shape == 2 ? torus(10, 6)
           : shape == 3 ? nested_spheres(3, 100)
                        : joined({two_cubes_sharing_an_edge(), two_cubes_sharing_a_face()});
    const auto blows = static_cast<int>(1 + random.below(seed % 7 == 0 ? 200 : 12));
    const auto mesh = std::make_shared<const Mesh>(damaged(base, random, blows));
    const SolidOptions options{.thickness = seed % 2 == 0 ? 0 : 0.02};
    const Expected<Solid> solid = make_solid(mesh, options, {});
    if (!solid) {
      EXPECT_TRUE(solid.error().code == ErrorCode::kMeshNotClosed ||
                  solid.error().code == ErrorCode::kEmptyMesh);
      continue;
    }
    ++solids;
    ASSERT_NO_THROW(solid->validate());
    // The solid's surface as a mesh is closed and needs no repair.
    const Mesh again = surface_mesh(*solid);
    EXPECT_EQ(open_directed_edges(again), 0u);
    EXPECT_NEAR(volume_of(again), solid->report.volume, 1e-9 * solid->report.volume + 1e-12);
    const Expected<Solid> repeated = make_solid(mesh, options, {});
    EXPECT_EQ(repeated->triangles, solid->triangles);
    EXPECT_EQ(repeated->edges, solid->edges);
  }
  EXPECT_GT(solids, static_cast<std::size_t>(test::repetitions(500)));
}

}  // namespace
}  // namespace fracture::test
