// Bodies whose collision hulls were wrong: corners that rounding merges, rows of strips that each bend a
// little, planes that graze faces, sheets far from their pivot.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>

#include "common/physics/collision_hulls.hpp"
#include "common/physics/hull_maker.hpp"
#include "common/pipeline/fracture.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/fractured.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/site_families.hpp"

namespace fracture::test {
namespace {

/// Expects that no corner occurs twice, that the centre of the corners is below each triangle, and that the
/// surface is one sphere. Hulls are made on a grid of 2^19 steps: a triangle narrower than two of them may be
/// turned over.
void expect_clean(const CollisionHull& hull) {
  std::set<std::tuple<float, float, float>> distinct;
  Vec3d middle;
  Box box;
  for (const Vec3f& p : hull.points) box.add(to_double(p));
  const double side = box.longest_side(), narrow = 0x1p-18 * side * side * side;
  for (const Vec3f& p : hull.points) {
    distinct.emplace(p.x, p.y, p.z);
    middle = middle + (1.0 / static_cast<double>(hull.points.size())) * to_double(p);
  }
  EXPECT_EQ(distinct.size(), hull.points.size());
  EXPECT_EQ(hull.triangles.size() + 4, 2 * hull.points.size());
  for (const auto& t : hull.triangles) {
    const Vec3d a = to_double(hull.points[t[0]]);
    const Vec3d n = cross(to_double(hull.points[t[1]]) - a, to_double(hull.points[t[2]]) - a);
    EXPECT_LT(dot(n, middle - a), narrow);
    EXPECT_NE(n, Vec3d{});
  }
}

void expect_clean_hulls(const Mesh& mesh, FractureParameters p) {
  p.hulls = Hulls::kConvex;
  const Fractured made = fracture_mesh(mesh, p);
  for (std::size_t k = 0; k < made.set.fragments.size(); ++k) {
    SCOPED_TRACE("fragment " + std::to_string(k));
    ASSERT_FALSE(made.hulls.of(k).empty());
    for (const CollisionHull& hull : made.hulls.of(k)) expect_clean(hull);
  }
}

TEST(HullTraps, CornersOfCellsThatRoundingUnites) {
  // Eight cells meet at each corner of a lattice. If sites are a little off, a cell has several corners
  // there.
  for (const double off : {1e-10, 1e-9, 1e-7, 1e-6, 1e-5}) {
    SCOPED_TRACE(off);
    std::vector<Vec3d> sites = lattice_sites(box_of(cube()), 4);
    const std::vector<Vec3d> noise = random_sites(box_of(cube()), sites.size(), 7);
    for (std::size_t k = 0; k < sites.size(); ++k) sites[k] = sites[k] + off * noise[k];
    FractureParameters p;
    p.pattern = PointsPattern{sites};
    expect_clean_hulls(cube(), p);
  }
}

TEST(HullTraps, CellsOfThePaper) {
  FractureParameters p;
  p.sites = 50;
  p.dual = Dual::kBarycenter;
  expect_clean_hulls(cube(), p);
}

TEST(HullTraps, ChunksOfManyCells) {
  for (const double spread : {0.0, 1.0}) {
    FractureParameters p;
    p.sites = 40;
    p.aggregation = {6, spread};
    expect_clean_hulls(cube(), p);
  }
}

/// A block whose top is a groove of n strips along z. The middle of the groove is lower by the sagitta. The
/// other faces of the block are larger than the strips.
Mesh groove(int n, float sagitta) {
  Mesh mesh;
  const auto corner = [&](float x, float y, float z) {
    mesh.positions.push_back({x, y, z});
    return static_cast<std::uint32_t>(mesh.positions.size() - 1);
  };
  const float bulge = 1.2f, width = 0.4f;
  std::vector<std::array<std::uint32_t, 2>> rows;
  for (int k = 0; k <= n; ++k) {
    const float x = static_cast<float>(k) / static_cast<float>(n), arc = x * (1 - x);
    rows.push_back(
        {corner(x, -4 * sagitta * arc, -bulge * arc), corner(x, -4 * sagitta * arc, width + bulge * arc)});
  }
  const std::uint32_t back = corner(0.5f, -0.6f, 0), front = corner(0.5f, -0.6f, width);
  const auto triangle = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    mesh.triangles.push_back({a, b, c});
  };
  for (std::size_t k = 0; k + 1 < rows.size(); ++k) {
    const auto [a, b] = rows[k];
    const auto [c, d] = rows[k + 1];
    triangle(a, b, d);
    triangle(a, d, c);
    triangle(a, c, back);
    triangle(d, b, front);
  }
  const auto quad = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    const auto at = [&](std::uint32_t v) { return to_double(mesh.positions[v]); };
    const Vec3d m = 0.25 * (at(a) + at(b) + at(c) + at(d));
    const std::uint32_t middle =
        corner(static_cast<float>(m.x), static_cast<float>(m.y), static_cast<float>(m.z));
    for (const auto& [from, to] : {std::pair(a, b), {b, c}, {c, d}, {d, a}}) {
      const Vec3d third = (1.0 / 3) * (at(from) + at(to) + m);
      const std::uint32_t inner =
          corner(static_cast<float>(third.x), static_cast<float>(third.y), static_cast<float>(third.z));
      triangle(from, to, inner);
      triangle(to, middle, inner);
      triangle(middle, from, inner);
    }
  };
  quad(rows.front()[1], rows.front()[0], back, front);
  quad(rows.back()[0], rows.back()[1], front, back);
  return mesh;
}

TEST(HullTraps, AGrooveOfManyStrips) {
  for (const auto& [strips, sagitta] : {std::pair(90, 0.008f), {110, 0.015f}, {118, 0.02f}}) {
    SCOPED_TRACE(strips);
    FractureParameters p;
    p.pattern = PointsPattern{{{0.5, -0.3, 0.2}}};
    p.hulls = Hulls::kConvex;
    const Fractured made = fracture_mesh(groove(strips, sagitta), p);
    ASSERT_EQ(made.set.fragments.size(), 1u);
    const CollisionHull& hull = made.hulls.of(0)[0];
    double most = 0;
    for (const auto& t : hull.triangles) {
      const Vec3d a = to_double(hull.points[t[0]]);
      const Vec3d n = cross(to_double(hull.points[t[1]]) - a, to_double(hull.points[t[2]]) - a);
      for (const Vec3f& q : hull.points) most = std::max(most, dot(n, to_double(q) - a) / length(n));
    }
    EXPECT_LT(most, 0.1 * static_cast<double>(sagitta));
  }
}

/// The distance of a point from the triangle (a, b, c).
double distance_to_triangle(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  // Takes the minimum over a fine grid of its points: an oracle, not a formula.
  double least = HUGE_VAL;
  constexpr int kSteps = 200;
  for (int i = 0; i <= kSteps; ++i)
    for (int j = 0; i + j <= kSteps; ++j)
      least = std::min(least, length(p - (a + (1.0 * i / kSteps) * (b - a) + (1.0 * j / kSteps) * (c - a))));
  return least;
}

// The centre of a tilted triangle's box is far from the triangle.
TEST(HullTraps, TheHullOfATiltedFlatBodyIsAtTheBody) {
  const std::vector<Vec3f> points{{0, 0, 0}, {2, 0, 2}, {0, 2, 2}, {1, 1, 2}, {0.5f, 0.5f, 1}};
  HullMaker maker;
  FragmentHulls hulls;
  add_hull(points, {}, maker, hulls, {});
  ASSERT_EQ(hulls.flat, 1u);
  expect_clean(hulls.hulls[0]);
  for (const Vec3f& p : hulls.hulls[0].points)
    EXPECT_LT(distance_to_triangle(to_double(p), {0, 0, 0}, {2, 0, 2}, {0, 2, 2}), 2e-4 + 0.02)
        << "0.02: a step of the oracle's grid";
}

// At 1e5, a step of the lattice is 0.016 along x. So corners of neighbours lie up to that far behind each
// other's cuts.
TEST(HullTraps, HullsFarFromTheOriginAreApart) {
  FractureParameters p;
  p.sites = 40;
  p.hulls = Hulls::kConvex;
  for (const std::uint64_t seed : {1, 2, 3}) {
    p.seed = seed;
    const Fractured made = fracture_mesh(translated(sphere_with(400), {1e5, 0.3, -0.2}), p);
    ASSERT_GT(made.set.lattice_step.x, 0.01);
    const Vec3d step = made.set.lattice_step;
    std::size_t pairs = 0;
    for (const Bond& bond : made.set.bonds) {
      const Fragment &a = made.set.fragments[bond.a], &b = made.set.fragments[bond.b];
      // Crumbs of a few steps have no shape of their own.
      if (std::min(a.mass.volume / a.mass.area, b.mass.volume / b.mass.area) < 2 * length(step)) continue;
      ++pairs;
      const Tetrahedralization& t = made.diagram.tetrahedralization;
      const Vec3d i = t.points[a.sites[0]], j = t.points[b.sites[0]], n = j - i;
      const Vec3d middle = 0.5 * (i + j);
      const auto beyond = [&](const Fragment& f, std::size_t k, double side) {
        double most = -HUGE_VAL;
        for (const CollisionHull& hull : made.hulls.of(k))
          for (const Vec3f& q : hull.points)
            most = std::max(most, side * dot(to_double(q) + f.pivot - middle, n) / length(n));
        return most;
      };
      EXPECT_LT(beyond(a, bond.a, 1) + beyond(b, bond.b, -1), 0)
          << "seed " << seed << " bond " << bond.a << " " << bond.b;
    }
    EXPECT_GT(pairs, 20u);
  }
}

TEST(HullTraps, ASheetFarFromItsPivot) {
  std::vector<Vec3f> points;
  for (int k = 0; k < 4; ++k) points.push_back({1e4f, k & 1 ? 0.01f : 0.0f, k & 2 ? 0.01f : 0.0f});
  HullMaker maker;
  FragmentHulls hulls;
  add_hull(points, {}, maker, hulls, {});
  ASSERT_EQ(hulls.hulls.size(), 1u);
  EXPECT_EQ(hulls.flat, 1u);
  expect_clean(hulls.hulls[0]);
}

}  // namespace
}  // namespace fracture::test
