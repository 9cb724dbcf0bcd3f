// Bonds of rough cuts. Every two fragments that share a cap have one bond, with the area of the caps across
// their cut. That also holds if the surface crosses itself and caps face both ways.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "common/solid/cut_materials.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/fractured.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/site_families.hpp"

namespace fracture::test {
namespace {

constexpr std::uint64_t kSeed = 20261129;

/// A prism along z over a four-sided polygon whose sides cross. Its ends are 2 wide at x = -2 and `end` wide
/// at x = 2.
Mesh bowtie(double end) {
  Mesh mesh;
  for (const float z : {0.0f, 4.0f})
    for (const auto& [x, y] : {std::pair{-2.0, -1.0}, {-2.0, 1.0}, {2.0, -end / 2}, {2.0, end / 2}})
      mesh.positions.push_back({static_cast<float>(x), static_cast<float>(y), z});
  mesh.triangles = {{0, 5, 1}, {0, 4, 5}, {1, 6, 2}, {1, 5, 6}, {2, 7, 3}, {2, 6, 7},
                    {3, 4, 0}, {3, 7, 4}, {0, 1, 2}, {0, 2, 3}, {4, 6, 5}, {4, 7, 6}};
  mesh.material.assign(mesh.triangles.size(), kNoIndex);
  return mesh;
}

/// For two fragments: the area of the triangles that both contain, and that area across the line between
/// their sites (for fragments of one cell).
struct Shared {
  double area = 0, across = 0;
  bool counted = true;  ///< none of their triangles is in more than two fragments
};

/// Found only by corners in world space.
std::map<std::pair<std::uint32_t, std::uint32_t>, Shared> shared_caps(const FragmentSet& set,
                                                                      const std::vector<Vec3d>& sites) {
  using Corner = std::array<double, 3>;
  std::map<std::array<Corner, 3>, std::vector<std::uint32_t>> owners;
  for (std::uint32_t n = 0; n < set.fragments.size(); ++n) {
    const Fragment& f = set.fragments[n];
    for (const FragmentPrimitive& p : f.primitives) {
      if (p.material != kInteriorMaterial) continue;
      for (std::uint32_t k = p.first_index; k < p.first_index + p.index_count; k += 3) {
        std::array<Corner, 3> t;
        for (std::uint32_t c = 0; c < 3; ++c) {
          const Vec3d w = to_double(f.positions[f.indices[k + c]]) + f.pivot;
          t[c] = {w.x, w.y, w.z};
        }
        std::sort(t.begin(), t.end());
        if (t[0] != t[1] && t[1] != t[2]) owners[t].push_back(n);
      }
    }
  }
  std::map<std::pair<std::uint32_t, std::uint32_t>, Shared> shared;
  for (const auto& [t, of] : owners) {
    if (of.size() != 2)
      for (const std::uint32_t a : of)
        for (const std::uint32_t b : of)
          if (a < b) shared[{a, b}].counted = false;
    if (of.size() != 2 || of[0] == of[1]) continue;
    const auto at = [&](std::size_t c) { return Vec3d{t[c][0], t[c][1], t[c][2]}; };
    const Vec3d n = 0.5 * cross(at(1) - at(0), at(2) - at(0));
    Shared& both = shared[{of[0], of[1]}];
    both.area += length(n);
    const Fragment &a = set.fragments[of[0]], &b = set.fragments[of[1]];
    if (a.sites.size() > 1 || b.sites.size() > 1) continue;
    const Vec3d u = sites[b.sites[0]] - sites[a.sites[0]];
    both.across += std::fabs(dot(n, u)) / length(u);
  }
  return shared;
}

void expect_a_bond_for_each_shared_cap(const Mesh& mesh, std::vector<Vec3d> sites,
                                       const Roughness& roughness) {
  FractureParameters p;
  p.pattern = PointsPattern{sites};
  p.roughness = roughness;
  const Fractured made = fracture_mesh(mesh, p);
  const Tetrahedralization& t = made.diagram.tetrahedralization;
  const auto shared = shared_caps(made.set, t.points);
  std::map<std::pair<std::uint32_t, std::uint32_t>, const Bond*> bonds;
  for (const Bond& b : made.set.bonds) bonds[{b.a, b.b}] = &b;
  ASSERT_EQ(bonds.size(), made.set.bonds.size());
  EXPECT_GT(bonds.size(), 0u);
  const double size = box_of(mesh).longest_side();
  const double rounding = 2e-6 * size * size;  // bonds are measured before positions are rounded
  std::size_t judged = 0;
  for (const auto& [pair, both] : shared) {
    SCOPED_TRACE(std::to_string(pair.first) + " and " + std::to_string(pair.second));
    if (!both.counted) continue;
    if (!bonds.contains(pair)) {
      EXPECT_LT(both.area, rounding);
      continue;
    }
    ++judged;
    const Bond& bond = *bonds.at(pair);
    EXPECT_GT(bond.area, 0);
    EXPECT_LE(bond.area, both.area + rounding);
    EXPECT_NEAR(length(bond.normal), 1, 1e-9);
    const Fragment &a = made.set.fragments[bond.a], &b = made.set.fragments[bond.b];
    if (a.sites.size() > 1 || b.sites.size() > 1) continue;
    EXPECT_NEAR(bond.area, both.across, rounding);
    const Vec3d u = t.points[b.sites[0]] - t.points[a.sites[0]];
    EXPECT_GT(dot(bond.normal, u), 0);
    Box box = box_of(mesh);
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_GE(bond.centroid[axis], box.min[axis] - 1e-6 * size);
      EXPECT_LE(bond.centroid[axis], box.max[axis] + 1e-6 * size);
    }
  }
  for (const auto& [pair, bond] : bonds) EXPECT_TRUE(shared.contains(pair) || bond->area < rounding);
  EXPECT_GT(2 * judged, bonds.size());
}

TEST(RoughBonds, ASurfaceThatCrossesItselfKeepsTheAreaOfItsCuts) {
  // The sides from (-2, 1) to (2, -end / 2) and their mirror images cross. They make two triangles, one of
  // them inverted.
  for (const double end : {1.2, 0.4, 1.9}) {
    SCOPED_TRACE(end);
    const double left = 4 * 2 / (2 + end), section = left + (4 - left) * end / 2;
    double flat = 0;  // overlapping triangles count once each, also after they are divided
    for (const double amplitude : {0.0, 1e-3, 0.01, 0.03}) {
      SCOPED_TRACE(amplitude);
      FractureParameters p;
      p.pattern = PointsPattern{{{0, 0, 0.5}, {0, 0, 1.5}, {0, 0, 2.5}, {0, 0, 3.5}}};
      p.roughness = {amplitude, 5, 2};
      const Fractured made = fracture_mesh(bowtie(end), p);
      ASSERT_EQ(made.set.fragments.size(), 4u);
      ASSERT_EQ(made.set.bonds.size(), 3u);
      for (const Bond& bond : made.set.bonds) {
        EXPECT_GE(bond.area, section * (1 - 2 * amplitude));
        if (amplitude == 0) flat = bond.area;
        EXPECT_NEAR(bond.area, flat, 1e-5);
        EXPECT_GT(bond.normal.z, 0.9);
        EXPECT_LE(std::fabs(bond.centroid.x), 2);
      }
    }
  }
}

TEST(RoughBonds, StandForEverySharedCap) {
  for (const double amplitude : {0.0, 0.02, 0.05}) {
    SCOPED_TRACE(amplitude);
    const Roughness roughness{amplitude, 6, 2};
    for (const double end : {1.2, 0.4})
      expect_a_bond_for_each_shared_cap(bowtie(end), random_sites(box_of(bowtie(end)), 12, kSeed), roughness);
    const Mesh tube = self_crossing_tube(48, 8);
    expect_a_bond_for_each_shared_cap(tube, random_sites(box_of(tube), 40, kSeed), roughness);
    expect_a_bond_for_each_shared_cap(torus(24, 12), random_sites(box_of(torus(24, 12)), 40, kSeed),
                                      roughness);
  }
}

}  // namespace
}  // namespace fracture::test
