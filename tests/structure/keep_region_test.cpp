// A region that never breaks: no cut runs through it, and all other invariants hold.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/bvh/surface_tree.hpp"
#include "common/materials/materials.hpp"
#include "common/solid/cut_materials.hpp"
#include "tests/property/judge.hpp"
#include "tests/structure/seed.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/fractured.hpp"
#include "tests/support/full_tests.hpp"
#include "tests/support/pattern_requests.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/site_families.hpp"

namespace fracture::test {
namespace {

/// Calls visit(a, b, c) with the corners of each triangle of the cuts.
template <class Visit>
void each_cut(const FragmentSet& set, const Visit& visit) {
  for (const Fragment& f : set.fragments)
    for (const FragmentPrimitive& p : f.primitives) {
      if (!is_of_cuts(p.material)) continue;
      const auto at = [&](std::uint32_t k) { return to_double(f.positions[f.indices[k]]) + f.pivot; };
      for (std::uint32_t k = p.first_index; k < p.first_index + p.index_count; k += 3)
        visit(at(k), at(k + 1), at(k + 2));
    }
}

/// Checks by brute force: a cell that contains a sampled point of the region must be among `found`.
void expect_holds_every_cell(const Region& region, const std::vector<SiteId>& found,
                             const std::vector<Vec3d>& sites, const Box& bounds) {
  Box box = region.box;
  if (region.shape == Region::Shape::kSphere) {
    const Vec3d r{region.radius, region.radius, region.radius};
    box = {region.center - r, region.center + r};
  }
  const int steps = sized(8, 24);
  for (int x = 0; x <= steps; ++x)
    for (int y = 0; y <= steps; ++y)
      for (int z = 0; z <= steps; ++z) {
        const Vec3d s = box.size();
        const Vec3d p{box.min.x + s.x * x / steps, box.min.y + s.y * y / steps, box.min.z + s.z * z / steps};
        if (region.shape == Region::Shape::kSphere && length(p - region.center) > region.radius) continue;
        bool outside = false;
        for (int a = 0; a < 3; ++a) outside = outside || p[a] < bounds.min[a] || p[a] > bounds.max[a];
        if (outside) continue;
        const auto nearest = std::min_element(
            sites.begin(), sites.end(),
            [&](const Vec3d& a, const Vec3d& b) { return dot(a - p, a - p) < dot(b - p, b - p); });
        EXPECT_TRUE(
            std::binary_search(found.begin(), found.end(), static_cast<SiteId>(nearest - sites.begin())));
      }
}

TEST(KeepRegion, HoldsEveryCellThatMeetsItAndNoneThatIsFarAway) {
  const Mesh mesh = cube();
  const Box bounds = box_of(mesh);
  const std::vector<Vec3d> sites = random_sites(bounds, 300, kSeed);
  const Expected<Tetrahedralization> t = tetrahedralize(sites, bounds, {});
  ASSERT_TRUE(t);
  ASSERT_EQ(t->site_count(), sites.size());
  const VoronoiDiagram voronoi(*t, bounds);
  for (const double size : {1e-6, 0.05, 0.2, 0.45}) {
    for (const Vec3d& center : {Vec3d{0.1, -0.2, 0.05}, Vec3d{0.5, 0.5, 0.5}, Vec3d{-0.6, 0, 0.1}}) {
      SCOPED_TRACE(size);
      Region ball;
      ball.center = center;
      ball.radius = size;
      const auto in_ball = cells_meeting(ball, voronoi, bounds);
      expect_holds_every_cell(ball, in_ball, sites, bounds);
      Region box;
      box.shape = Region::Shape::kBox;
      box.box = {center - Vec3d{size, size / 2, size / 4}, center + Vec3d{size, size / 2, size / 4}};
      const auto in_box = cells_meeting(box, voronoi, bounds);
      expect_holds_every_cell(box, in_box, sites, bounds);
      // The distance of a cell to the region is at least the distance of its site minus the extent of a cell
      // (one of 300).
      for (const SiteId s : in_ball) EXPECT_LE(length(sites[s] - center), size + 0.3);
    }
  }
  Region elsewhere;
  elsewhere.center = {3, 0, 0};
  elsewhere.radius = 1;
  EXPECT_TRUE(cells_meeting(elsewhere, voronoi, bounds).empty());
}

TEST(KeepRegion, NothingInsideIsCutAndAllInvariantsHold) {
  std::size_t input = 0;
  for (const NamedMesh& shape : closed_shapes()) {
    if (!has_turn(input++, 2, 3)) continue;
    SCOPED_TRACE(shape.name);
    const Mesh mesh = with_traced_triangles(shape.mesh);
    const Box box = box_of(mesh);
    FractureParameters p;
    p.pattern = PointsPattern{random_sites(box, 60, kSeed)};
    Region ball;
    ball.center = box.center() + 0.3 * Vec3d{box.size().x, 0, 0};
    ball.radius = 0.2 * box.longest_side();
    p.keep = ball;
    const Fractured f = fracture_mesh(mesh, p);
    expect_closed(f.set);
    expect_partition(f.set, volume_of(mesh), area_of(mesh));
    expect_outside_untouched(f.set, mesh);
    EXPECT_GT(f.report.kept_cells.value(), 0u);
    each_cut(f.set, [&](const Vec3d& a, const Vec3d& b, const Vec3d& c) {
      EXPECT_GT(distance_to_triangle(ball.center, a, b, c), ball.radius * (1 - 1e-6));
    });
  }
}

TEST(KeepRegion, NoRoughCutRunsThroughIt) {
  std::size_t rough = 0, cuts = 0;
  for (const MaterialPreset& preset : material_presets()) {
    if (!(preset.roughness.amplitude > 0)) continue;
    ++rough;
    SCOPED_TRACE(preset.name);
    std::size_t turn = 0;
    for (const Mesh& mesh : {cube(), torus(24, 12), box({0, 0, 0}, {3, 1, 0.5})})
      for (const std::uint64_t seed : {kSeed, kSeed + 1}) {
        if (!has_turn(rough, turn++, 3)) continue;
        const Box bounds = box_of(mesh);
        const double side = bounds.longest_side();
        FractureParameters p = of_material(preset, 60, seed);
        const Region ball{.center = bounds.center() + 0.3 * Vec3d{bounds.size().x, 0, 0},
                          .radius = 0.12 * side};
        p.keep = ball;
        each_cut(fracture_mesh(mesh, p).set, [&](const Vec3d& a, const Vec3d& b, const Vec3d& c) {
          ++cuts;
          EXPECT_GT(distance_to_triangle(ball.center, a, b, c), ball.radius * (1 - 1e-6));
        });
        const Vec3d half = side * Vec3d{0.15, 0.05, 0.1};
        const Region block{.shape = Region::Shape::kBox, .box = {ball.center - half, ball.center + half}};
        p.keep = block;
        each_cut(fracture_mesh(mesh, p).set, [&](const Vec3d& a, const Vec3d& b, const Vec3d& c) {
          ++cuts;
          for (const Vec3d& q : {a, b, c, 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)}) {
            const Vec3d off = q - ball.center;
            const double slack = 1e-6 * side;
            EXPECT_FALSE(std::fabs(off.x) < half.x - slack && std::fabs(off.y) < half.y - slack &&
                         std::fabs(off.z) < half.z - slack);
          }
        });
      }
  }
  EXPECT_GE(rough, 10u);
  EXPECT_GT(cuts, 10'000u);
}

TEST(KeepRegion, AllOfTheSolidKeptIsTheSolid) {
  const Mesh mesh = torus(24, 12);
  FractureParameters p;
  p.pattern = PointsPattern{random_sites(box_of(mesh), 60, kSeed)};
  Region region;
  region.shape = Region::Shape::kBox;
  region.box = {{-9, -9, -9}, {9, 9, 9}};
  p.keep = region;
  const FragmentSet set = fracture_mesh(mesh, p).set;
  ASSERT_EQ(set.fragments.size(), 1u);
  EXPECT_EQ(set.fragments[0].indices.size(), 3 * mesh.triangles.size());
}

}  // namespace
}  // namespace fracture::test
