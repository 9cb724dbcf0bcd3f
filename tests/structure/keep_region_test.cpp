// A region that never breaks: no cut runs through it, and all other invariants hold.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <tuple>

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
    EXPECT_GT(f.report.kept.value().cells, 0u);
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

/// The lower 30 % of a cube of 1 m; the box is wider than the cube.
const Region kLower{.shape = Region::Shape::kBox, .box = {{-1, -1, -1}, {1, -0.2, 1}}};
/// 3.4 % of the cube.
const Region kBall{.center = {0.1, 0.05, -0.1}, .radius = 0.2};

const Fragment& fragment_at(const FragmentSet& set, const Vec3d& place) {
  return *std::min_element(
      set.fragments.begin(), set.fragments.end(), [&](const Fragment& a, const Fragment& b) {
        return length(a.mass.center_of_mass - place) < length(b.mass.center_of_mass - place);
      });
}

TEST(KeepRegion, TheKeptShareIsThatOfTheRegionWithEveryPatternAndMaterial) {
  const Mesh mesh = cube();
  std::size_t turn = 0;
  for (const std::uint64_t seed : {kSeed, kSeed + 1, kSeed + 2}) {
    std::vector<NamedParameters> requests = pattern_requests(box_of(mesh), 50, seed);
    for (auto& [name, p] : requests) {
      if (p.dual != Dual::kCircumcenter || !has_turn(turn++, 2, 3)) continue;
      for (const auto& [region, share, middle] :
           {std::tuple(kLower, 0.3, Vec3d{0, -0.35, 0}),
            std::tuple(kBall, 4 * M_PI / 3 * std::pow(0.2, 3), kBall.center)}) {
        SCOPED_TRACE(name + " seed " + std::to_string(seed) + " share " + std::to_string(share));
        p.keep = region;
        p.size.min_of_mean = kLeastOfMean;
        const Fractured f = fracture_mesh(mesh, p);
        const double mean = 1.0 / static_cast<double>(f.set.fragments.size());
        const double most = share + std::fmax(mean, 0.05 * share);
        const double kept = fragment_at(f.set, middle).mass.volume;
        EXPECT_GE(kept, share * (1 - 1e-5));
        EXPECT_LE(kept, most);
        EXPECT_NEAR(f.report.kept.value().share, kept, 1e-9);
        EXPECT_GT(f.set.fragments.size(), 5u) << "the rest breaks";
        std::size_t inside = 0;
        each_cut(f.set, [&](const Vec3d& a, const Vec3d& b, const Vec3d& c) {
          if (region.shape == Region::Shape::kSphere)
            inside += distance_to_triangle(region.center, a, b, c) < region.radius * (1 - 1e-5);
          else
            inside += std::fmin(a.y, std::fmin(b.y, c.y)) < region.box.max.y - 2e-6;
        });
        EXPECT_EQ(inside, 0u);
      }
    }
  }
}

TEST(KeepRegion, ItsSurfaceIsOneFlatCut) {
  for (const char* material : {"wood", "brick", "stone", "cast_iron"}) {
    SCOPED_TRACE(material);
    FractureParameters p = of_material(*find_material_preset(material), 60, kSeed);
    p.keep = kLower;
    const Fractured f = fracture_mesh(cube(), p);
    const Fragment& kept = fragment_at(f.set, {0, -0.35, 0});
    double area = 0;
    for (const FragmentPrimitive& primitive : kept.primitives) {
      if (!is_of_cuts(primitive.material)) continue;
      for (std::uint32_t k = primitive.first_index; k < primitive.first_index + primitive.index_count;
           k += 3) {
        Vec3d corner[3];
        for (std::uint32_t c = 0; c < 3; ++c) {
          corner[c] = to_double(kept.positions[kept.indices[k + c]]) + kept.pivot;
          EXPECT_NEAR(corner[c].y, -0.2, 1e-5);
        }
        area += 0.5 * length(cross(corner[1] - corner[0], corner[2] - corner[0]));
      }
    }
    EXPECT_NEAR(area, 1, 1e-5) << "the section of the cube";
  }
}

TEST(KeepRegion, ARegionThatHoldsNothingOrEverythingIsNamed) {
  FractureParameters p;
  p.sites = 30;
  p.keep = Region{.center = {3, 0, 0}, .radius = 1};
  const Fractured nothing = fracture_mesh(cube(), p);
  EXPECT_TRUE(warns(nothing.report, "'keep_center' and 'keep_radius' contains no part of the mesh"));
  EXPECT_EQ(nothing.report.kept.value().share, 0);
  EXPECT_GT(nothing.set.fragments.size(), 20u);
  p.keep = Region{.shape = Region::Shape::kBox, .box = {{-1, -1, -1}, {1, 1, 1}}};
  const Fractured all = fracture_mesh(cube(), p);
  EXPECT_TRUE(warns(all.report, "'keep_box' contains the whole mesh"));
  EXPECT_EQ(all.set.fragments.size(), 1u);
  p.keep = kLower;
  EXPECT_TRUE(fracture_mesh(cube(), p).report.remarks.warnings.empty());
}

TEST(KeepRegion, SizeLimitsLeaveItAsItIs) {
  FractureParameters p;
  p.sites = p.size.fragments = 40;
  for (const Region& region : {kLower, kBall}) {
    p.keep = region;
    const Fractured f = fracture_mesh(cube(), p);
    EXPECT_NEAR(static_cast<double>(f.set.fragments.size()), 40, 4);
    const double share = region.shape == Region::Shape::kBox ? 0.3 : 4 * M_PI / 3 * std::pow(0.2, 3);
    EXPECT_NEAR(f.report.kept.value().share, share, 0.05 * share);
  }
  // A tenth of the volume at least: the ball is smaller, but no piece joins it.
  p.size = {.min_fraction = 0.1};
  p.keep = kBall;
  EXPECT_LT(fracture_mesh(cube(), p).report.kept.value().share, 0.04);
}

TEST(KeepRegion, HitsAndLimitsOfVolumeDoNotCutIt) {
  FractureParameters p;
  p.sites = 40;
  p.keep = kLower;
  p.hits = {{{0, -0.2, 0}, 0.4, 60}};
  p.rest = LocalRest::kFractured;
  const Fractured hit = fracture_mesh(cube(), p);
  FractureParameters before = p;
  before.hits.clear();
  const Fractured whole = fracture_mesh(cube(), before);
  EXPECT_EQ(hit.report.kept.value().share, whole.report.kept.value().share);
  EXPECT_GT(hit.set.fragments.size(), whole.set.fragments.size() + 5);
  std::size_t same = 0;  // the kept fragment is the largest one, and is not cut
  for (const Fragment& f : hit.set.fragments)
    for (const Fragment& g : whole.set.fragments)
      same += f.id == g.id && f.mass.volume > 0.25 && f.mass.volume == g.mass.volume;
  EXPECT_EQ(same, 1u);
  p.rest = LocalRest::kWhole;
  const Fractured around = fracture_mesh(cube(), p);
  // Cells of the hit that meet the region or the hit's boundary stay with the rest. That leaves few of the 60.
  EXPECT_GT(around.set.fragments.size(), 3u);
  double broken = 0, largest = 0;
  for (const Fragment& f : around.set.fragments) {
    broken += f.mass.volume;
    largest = std::fmax(largest, f.mass.volume);
  }
  broken -= largest;
  EXPECT_GT(broken, 0);
  EXPECT_NEAR(around.report.kept.value().share, 1 - broken, 1e-6);
  p.rest = LocalRest::kFractured;
  p.hits.clear();
  p.max_volume = 0.02;
  const Fractured divided = fracture_mesh(cube(), p);
  EXPECT_NEAR(divided.report.kept.value().share, 0.3, 0.03);
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
