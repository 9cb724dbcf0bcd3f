// I1, I2 and I3 for regular patterns under a stretch. Four or more of their cells meet along lines and at
// points that many cells share. Bricks are groups of cells, so their outlines touch themselves and each other
// there.
#include <gtest/gtest.h>

#include <array>
#include <string>
#include <vector>

#include "common/base/random.hpp"
#include "tests/property/judge.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/fractured.hpp"
#include "tests/support/full_tests.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::test {
namespace {

/// A UV sphere around the y axis: the mesh of the answer that was refused.
Mesh upright_sphere(int rings) {
  Mesh sphere = reversed(uv_sphere(rings, 2 * rings));
  for (Vec3f& p : sphere.positions) p = {p.x, p.z, p.y};
  return sphere;
}

std::vector<NamedMesh> small_meshes() {
  std::vector<NamedMesh> all;
  all.push_back({"upright_sphere", upright_sphere(8)});
  all.push_back({"ellipsoid", scaled(uv_sphere(6, 9), {1, 0.37, 1.3})});
  all.push_back({"cube", cube(2)});
  all.push_back({"menger_sponge", menger_sponge(1)});
  all.push_back({"plate", thin_plate()});
  all.push_back({"nested_spheres", nested_spheres(3, 100)});
  all.push_back({"torus", torus(12, 6)});
  return all;
}

class Judged {
 public:
  explicit Judged(const Mesh& mesh)
      : traced_(with_traced_triangles(mesh)), volume_(volume_of(mesh)), area_(area_of(mesh)) {}

  void expect_invariants(const FractureParameters& parameters) const {
    const Fractured made = fracture_mesh(traced_, parameters);  // throws if the answer does not prove itself
    expect_closed(made.set);
    expect_partition(made.set, volume_, area_);
    expect_outside_untouched(made.set, traced_);
    EXPECT_EQ(made.set.certificate.open_edges, 0u);
  }

 private:
  Mesh traced_;
  double volume_, area_;
};

FractureParameters stretched(SitePattern pattern, std::uint32_t sites, Anisotropy anisotropy,
                             std::uint64_t seed = 1) {
  FractureParameters p;
  p.pattern = std::move(pattern);
  p.sites = sites;
  p.anisotropy = anisotropy;
  p.seed = seed;
  return p;
}

TEST(RegularPatterns, ThirtyBricksInASphereAreSoundAtTheStretchesThatWereRefused) {
  const Judged sphere(upright_sphere(8));
  for (const double stretch : {0.6329708009652465, 0.63288, 0.63291, 0.633, 0.63306})
    for (const std::uint32_t sites : {28u, 30u, 31u}) {
      SCOPED_TRACE(std::to_string(stretch) + " " + std::to_string(sites));
      EXPECT_NO_THROW(sphere.expect_invariants(stretched(BrickPattern{}, sites, {.stretch = stretch})));
    }
}

TEST(RegularPatterns, OtherRefusedAnswersAreSound) {
  const BrickPattern thirds{.bond = BrickPattern::Bond::kThird};
  const Anisotropy oblique{.stretch = 4, .grain = Vec3d{1, 2, -0.5}};
  EXPECT_NO_THROW(Judged(menger_sponge(1)).expect_invariants(stretched(thirds, 62, oblique, 782109)));
  EXPECT_NO_THROW(
      Judged(thin_plate())
          .expect_invariants(stretched(BrickPattern{}, 30,
                                       {.stretch = 3.2272616132980634, .grain = Vec3d{1, 2, -0.5}}, 494594)));
  EXPECT_NO_THROW(
      Judged(cube_field(3))
          .expect_invariants(stretched(BrickPattern{}, 41,
                                       {.stretch = 1.3714273797615142, .grain = Vec3d{1, 2, -0.5}}, 562213)));
}

TEST(RegularPatterns, KeepTheInvariantsAtManyStretches) {
  Random random(20261204);
  std::size_t input = 0;
  for (const auto& [name, mesh] : small_meshes()) {
    const Judged judged(mesh);
    ++input;
    for (int step = 0; step < 8; ++step)
      for (int kind = 0; kind < 5; ++kind) {
        // From a quarter to four times, including round numbers.
        const double stretch =
            step % 4 == 3 ? 0.5 * static_cast<double>(1 + random.below(8)) : 0.25 + 3.75 * random.uniform();
        const auto sites = static_cast<std::uint32_t>(10 + random.below(50));
        Anisotropy anisotropy{.stretch = stretch};
        if (step % 3 == 1) anisotropy.grain = Vec3d{1, 2, -0.5};
        if (step % 3 == 2) anisotropy.grain = Vec3d{1, 1, 0};
        SitePattern pattern = BrickPattern{};
        if (kind == 1) pattern = BrickPattern{.bond = BrickPattern::Bond::kThird};
        if (kind == 2) pattern = BrickPattern{.impacts = {box_of(mesh).max}};
        if (kind == 3) pattern = GridPattern{};
        if (kind == 4) pattern = RadialPattern{};
        if (!has_turn(input, static_cast<std::size_t>(5 * step + kind), 4)) continue;
        SCOPED_TRACE(name + " " + std::to_string(kind) + " " + std::to_string(stretch) + " " +
                     std::to_string(sites));
        EXPECT_NO_THROW(judged.expect_invariants(stretched(pattern, sites, anisotropy)));
      }
  }
}

// No stretch. The cells of a cubic lattice are in a few groups, whose outlines touch at every corner of the
// lattice.
TEST(RegularPatterns, CellsOfALatticeInGroupsKeepTheInvariants) {
  Random random(20261205);
  std::size_t input = 0;
  for (const auto& [name, mesh] : small_meshes()) {
    const Judged judged(mesh);
    ++input;
    const Box box = box_of(mesh);
    for (int k = 0; k < 12; ++k) {
      PointsPattern points;
      std::array<int, 3> cells{};
      for (int& n : cells) n = static_cast<int>(2 + random.below(7));
      const std::uint64_t groups = 2 + random.below(4);
      for (int z = 0; z < cells[2]; ++z)
        for (int y = 0; y < cells[1]; ++y)
          for (int x = 0; x < cells[0]; ++x) {
            if (k % 3 == 2 && (x + y + z) % 2 == 1) continue;  // face-centred
            const Vec3d at{(x + 0.5) / cells[0], (y + 0.5) / cells[1], (z + 0.5) / cells[2]};
            points.points.push_back(box.min +
                                    Vec3d{at.x * box.size().x, at.y * box.size().y, at.z * box.size().z});
            points.groups.push_back(static_cast<std::uint32_t>(random.below(groups)));
          }
      if (!has_turn(input, static_cast<std::size_t>(k), 4)) continue;
      SCOPED_TRACE(name + " " + std::to_string(k));
      const auto count = static_cast<std::uint32_t>(points.points.size());
      EXPECT_NO_THROW(judged.expect_invariants(stretched(std::move(points), count, {})));
    }
  }
}

}  // namespace
}  // namespace fracture::test
