// Fragments united because they are small: the union is exact and keeps every invariant, and budgets are
// kept.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/materials/materials.hpp"
#include "tests/property/judge.hpp"
#include "tests/structure/seed.hpp"
#include "tests/support/closed_inputs.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/fractured.hpp"
#include "tests/support/full_tests.hpp"
#include "tests/support/growth_families.hpp"
#include "tests/support/mesh_files.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/site_families.hpp"

namespace fracture::test {
namespace {

std::uint64_t triangles_of(const FragmentSet& set) {
  std::uint64_t sum = 0;
  for (const Fragment& f : set.fragments) sum += f.indices.size() / 3;
  return sum;
}

FractureParameters at_random(const Mesh& mesh, std::uint32_t sites) {
  FractureParameters p;
  p.pattern = PointsPattern{random_sites(box_of(mesh), sites, kSeed)};
  return p;
}

void expect_invariants(const FragmentSet& set, const Mesh& traced) {
  expect_closed(set);
  expect_partition(set, volume_of(traced), area_of(traced));
  expect_outside_untouched(set, traced);
  const Certificate& c = set.certificate;
  EXPECT_EQ(c.fragments, c.cells + c.islands - c.united - c.dropped);
  EXPECT_EQ(c.fragments, set.fragments.size());
}

TEST(SizeLimits, WithoutAnyNothingIsUnited) {
  const Mesh mesh = ico_sphere(2);
  const Fractured made = fracture_mesh(mesh, at_random(mesh, 40));
  EXPECT_EQ(made.set.size.united, 0u);
  EXPECT_FALSE(made.report.size.limits.any()) << "none is in the file";
}

// The loop of x < 0 winds around its inside once, and the smaller loop of x > 0 minus once. The last two of
// seven slices are in the smaller loop, beyond x = 0.143. The slice before contains more of the smaller loop than of the larger.
TEST(SizeLimits, ManyPiecesThatAreInsideOutAreReported) {
  const Mesh mesh = prism_over({{-1, -1}, {0.6, 0.6}, {0.6, -0.6}, {-1, 1}});
  FractureParameters p;
  p.pattern = PointsPattern{row_of_sites(box_of(mesh), 7)};
  const Fractured made = fracture_mesh(mesh, p);
  EXPECT_GE(made.set.size.inside_out, 2u);
  EXPECT_LE(made.set.size.inside_out, 3u);
  EXPECT_GE(made.set.certificate.united, made.set.size.inside_out);
  EXPECT_TRUE(
      warns(made.report, "a negative volume, because the surface crosses itself with opposite winding"));

  p.size.min_of_mean = 0.01;  // the same pieces are merged, but as the smallest ones
  const Fractured limited = fracture_mesh(mesh, p);
  EXPECT_EQ(limited.set.size.inside_out, made.set.size.inside_out);
  EXPECT_TRUE(warns(limited.report, "a negative volume"));

  p.size = {.fragments = 7};
  EXPECT_TRUE(warns(fracture_mesh(mesh, p).report, "because the surface crosses itself. Ask for more"));

  const Mesh clean = ico_sphere(2);
  const Fractured sphere = fracture_mesh(clean, at_random(clean, 40));
  EXPECT_EQ(sphere.set.size.inside_out, 0u);
  EXPECT_FALSE(warns(sphere.report, "negative volume"));
}

TEST(SizeLimits, CrumbsThatTouchNothingAreReported) {
  // A screw next to a block, smaller than a 500th of the mean piece.
  const Mesh mesh = joined({box({0, 0, 0}, {1, 1, 1}), box({2, 0, 0}, {2.01, 0.01, 0.01})});
  FractureParameters p;
  p.sites = 20;
  EXPECT_FALSE(has_note(fracture_mesh(mesh, p).report, "no other piece"));
  p.size.min_of_mean = kLeastOfMean;
  const Fractured made = fracture_mesh(mesh, p);
  EXPECT_EQ(made.set.size.alone, 1u);
  EXPECT_TRUE(has_note(made.report, "1 piece is smaller than "));
  EXPECT_TRUE(has_note(made.report, " m³ and touches no other piece, so it stays as it is."));
  EXPECT_FALSE(warns(made.report, "no other piece"));
}

// The mean is known only after the last union, because fewer fragments have a larger mean.
TEST(SizeLimits, CrumbsBesideTheMeanOfWhatIsLeftAreReported) {
  std::vector<Mesh> boxes;
  double x = 0;
  for (const double side : {1.0, 0.8, 0.6, 0.4, 0.3, 0.2}) {
    boxes.push_back(box({x, 0, 0}, {x + side, side, side}));
    x += 2;
  }
  const double mean = (1 + 0.512 + 0.216 + 0.064 + 0.027 + 0.008) / 6;  // half of it: 0.152
  for (const bool by_triangles : {false, true}) {
    FractureParameters p;
    p.sites = 60;
    p.size.min_of_mean = 0.5;
    p.size.max_fragments = by_triangles ? 0 : 6;
    p.size.max_triangles = by_triangles ? 6 * 12 : 0;
    const Fractured made = fracture_mesh(joined(boxes), p);
    ASSERT_EQ(made.set.fragments.size(), 6u);
    EXPECT_EQ(made.set.size.alone, 3u);
    EXPECT_NEAR(made.set.size.min_volume, 0.5 * mean, 1e-6);
    EXPECT_TRUE(has_note(made.report, "3 pieces are smaller than"));
  }
}

TEST(SizeLimits, AFractionOfTheMeanHoldsForTheMeanOfWhatIsLeft) {
  const Mesh mesh = with_traced_triangles(torus(24, 12));
  const auto expect_none_smaller = [&](const SizeLimits& limits) {
    FractureParameters p = at_random(mesh, 80);
    p.size = limits;
    const Fractured made = fracture_mesh(mesh, p);
    expect_invariants(made.set, mesh);
    const double mean = made.solid.report.volume / static_cast<double>(made.set.fragments.size());
    for (const Fragment& f : made.set.fragments)
      EXPECT_GE(f.mass.volume, limits.min_of_mean * mean * (1 - 1e-9));
    EXPECT_EQ(made.set.size.alone, 0u);
    EXPECT_NEAR(made.set.size.min_volume, limits.min_of_mean * mean, 1e-9 * mean);
  };
  std::size_t input = 0;
  for (const double least : {0.3, 0.7, 0.95}) {
    SCOPED_TRACE(least);
    std::size_t turn = 0;
    for (const SizeLimits& limits :
         {SizeLimits{.min_of_mean = least}, SizeLimits{.min_of_mean = least, .max_fragments = 12},
          SizeLimits{.min_of_mean = least, .max_triangles = 1200},
          SizeLimits{.min_of_mean = least, .max_fragments = 20, .max_triangles = 1000}})
      if (has_turn(input, turn++, 3)) expect_none_smaller(limits);
    ++input;
  }
}

TEST(SizeLimits, SmallFragmentJoinsTheNeighborOfLargestSharedArea) {
  // A bar along x in pieces of length 1, 0.52 and 0.7.
  const Mesh mesh = box({0, 0, 0}, {2.22, 1, 1});
  FractureParameters p;
  p.pattern = PointsPattern{{{0.5, 0.5, 0.5}, {1.5, 0.5, 0.5}, {1.54, 0.5, 0.5}}};  // cuts at x = 1, 1.52
  p.size.min_volume = 0.6;
  const FragmentSet set = fracture_mesh(with_traced_triangles(mesh), p).set;
  expect_invariants(set, with_traced_triangles(mesh));
  // The middle piece (0.52) shares the same area of 1 with both neighbours. The one with the lower number
  // takes it.
  ASSERT_EQ(set.fragments.size(), 2u);
  EXPECT_EQ(set.size.united, 1u);
  std::vector<double> volumes;
  for (const Fragment& f : set.fragments) volumes.push_back(f.mass.volume);
  EXPECT_NEAR(volumes[0], 1.52, 1e-6);
  EXPECT_NEAR(volumes[1], 0.70, 1e-6);
  ASSERT_EQ(set.bonds.size(), 1u);
  EXPECT_NEAR(set.bonds[0].area, 1, 1e-9);
}

TEST(SizeLimits, MinimalVolumeHoldsForAllButTheLonely) {
  std::size_t input = 0;
  for (const NamedMesh& shape : closed_shapes()) {
    if (!has_turn(input++, 0, 3)) continue;
    SCOPED_TRACE(shape.name);
    const Mesh mesh = with_traced_triangles(shape.mesh);
    FractureParameters p = at_random(mesh, 60);
    p.size.min_fraction = 0.02;
    const Fractured f = fracture_mesh(mesh, p);
    expect_invariants(f.set, mesh);
    const double least = 0.02 * f.solid.report.volume;
    const auto small = static_cast<std::uint32_t>(
        std::count_if(f.set.fragments.begin(), f.set.fragments.end(),
                      [&](const Fragment& x) { return x.mass.volume < least * (1 - 1e-9); }));
    EXPECT_LE(small, f.set.size.alone);
    // A fragment that is still too small touches no other.
    for (const Bond& b : f.set.bonds)
      for (const std::uint32_t k : {b.a, b.b}) EXPECT_GE(f.set.fragments[k].mass.volume, least * (1 - 1e-9));
  }
}

TEST(SizeLimits, UnitingAllOfOnePartGivesTheInputTrianglesBack) {
  std::size_t input = 0;
  for (const NamedMesh& shape : closed_shapes()) {
    if (!has_turn(input++, 1, 3)) continue;
    SCOPED_TRACE(shape.name);
    const Mesh mesh = with_traced_triangles(shape.mesh);
    FractureParameters p = at_random(mesh, 40);
    p.size.max_fragments = 1;
    const Fractured f = fracture_mesh(mesh, p);
    expect_invariants(f.set, mesh);
    EXPECT_EQ(f.set.fragments.size(), f.solid.parts.size());
    EXPECT_TRUE(f.set.bonds.empty());
    EXPECT_EQ(triangles_of(f.set), mesh.triangles.size());
  }
}

TEST(SizeLimits, NumberOfFragmentsHoldsItsBudget) {
  const Mesh mesh = with_traced_triangles(torus(24, 12));
  for (const std::uint32_t most : {60u, 23u, 7u}) {
    FractureParameters p = at_random(mesh, 80);
    p.size.max_fragments = most;
    const Fractured made = fracture_mesh(mesh, p);
    expect_invariants(made.set, mesh);
    EXPECT_EQ(made.set.fragments.size(), most);
    EXPECT_EQ(made.report.size.limits.max_fragments, most);
  }
}

TEST(SizeLimits, NumberOfTrianglesHoldsItsBudgetAndNoMoreIsUnitedThanNeeded) {
  const Mesh mesh = with_traced_triangles(torus(24, 12));  // 576 triangles
  FractureParameters p = at_random(mesh, 80);
  const std::uint64_t all = triangles_of(fracture_mesh(mesh, p).set);
  for (const std::uint64_t most : {all - 1, all * 3 / 4, std::uint64_t{700}, std::uint64_t{576}}) {
    SCOPED_TRACE(most);
    p.size.max_triangles = most;
    const FragmentSet set = fracture_mesh(mesh, p).set;
    expect_invariants(set, mesh);
    EXPECT_LE(triangles_of(set), most);
    EXPECT_EQ(set.size.fewest_triangles, 576u);
    FractureParameters fewer = p;
    fewer.size = {};
    fewer.size.max_fragments = static_cast<std::uint32_t>(set.fragments.size() + 1);
    EXPECT_GT(triangles_of(fracture_mesh(mesh, fewer).set), most);
  }
}

TEST(SizeLimits, BudgetOfTrianglesBelowTheUncutSolidUnitesNothingAndSaysSo) {
  const Mesh mesh = torus(24, 12);
  FractureParameters p = at_random(mesh, 30);
  const std::size_t fragments = fracture_mesh(mesh, p).set.fragments.size();
  p.size.max_triangles = 575;
  const Fractured made = fracture_mesh(mesh, p);
  EXPECT_EQ(made.set.fragments.size(), fragments);
  EXPECT_EQ(made.set.size.united, 0u);
  EXPECT_TRUE(warns(made.report, "although 'max_triangles' is 575"));
}

TEST(SizeLimits, SameForAnyNumberOfThreads) {
  const Mesh mesh = torus(24, 12);
  FractureParameters p = at_random(mesh, 80);
  p.size.min_fraction = 0.01;
  p.size.max_triangles = 1500;
  p.levels = {3, 9};
  const Fractured first = fracture_mesh(mesh, p, 1), second = fracture_mesh(mesh, p, 2);
  const FragmentSet &one = first.set, &two = second.set;
  ASSERT_EQ(one.fragments.size(), two.fragments.size());
  for (std::size_t k = 0; k < one.fragments.size(); ++k) {
    EXPECT_EQ(one.fragments[k].id, two.fragments[k].id);
    EXPECT_EQ(one.fragments[k].positions, two.fragments[k].positions);
    EXPECT_EQ(one.fragments[k].indices, two.fragments[k].indices);
  }
  EXPECT_EQ(first.hierarchy.cluster_of_fragment, second.hierarchy.cluster_of_fragment);
}

TEST(SizeLimits, LargestVolumeIsReachedByFurtherSites) {
  for (const char* name : {"cube", "uv_sphere", "torus"})
    for (const NamedMesh& shape : closed_shapes()) {
      if (shape.name != name) continue;
      SCOPED_TRACE(name);
      const Mesh mesh = with_traced_triangles(shape.mesh);
      FractureParameters p = at_random(mesh, 5);
      p.max_volume = volume_of(mesh) / 20;
      const Fractured f = fracture_mesh(mesh, p);
      expect_invariants(f.set, mesh);
      EXPECT_EQ(f.diagram.split.too_large, 0u);
      EXPECT_GT(f.diagram.split.sites_added, 0u);
      EXPECT_GE(f.set.fragments.size(), 20u);
      EXPECT_LE(f.set.fragments.size(), 100u);
      for (const Fragment& x : f.set.fragments) EXPECT_LE(x.mass.volume, p.max_volume * (1 + 1e-9));
    }
}

class SizeLimitsOfMesh : public OnClosedMesh {};

TEST_P(SizeLimitsOfMesh, KeepsAllInvariantsWhenSmallPiecesAreUnited) {
  const Mesh traced = with_traced_triangles(mesh);
  FractureParameters p = at_random(traced, sized(40u, 100u));
  p.size.min_fraction = 0.01;
  p.size.max_fragments = 30;
  p.levels = {4, 12};
  const Fractured made = fracture_mesh(traced, p);
  expect_invariants(made.set, traced);
  EXPECT_EQ(made.hierarchy.cluster_of_fragment.size(), made.set.fragments.size());
}

INSTANTIATE_TEST_SUITE_P(Dev, SizeLimitsOfMesh, every_closed_mesh(), name_of_mesh);

}  // namespace
}  // namespace fracture::test
