// Compares figures of fragments with closed forms. Also tests attributes at cuts, and bonds.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "common/base/pacer.hpp"
#include "common/base/random.hpp"
#include "common/exact/volume_sum.hpp"
#include "common/fragment/certain_volume.hpp"
#include "common/fragment/closedness.hpp"
#include "common/fragment/mass_properties.hpp"
#include "common/pipeline/fracture.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::test {
namespace {

MassProperties mass_of(const Mesh& mesh, const Vec3d& origin) {
  MassIntegral m(origin);
  for (const auto& t : mesh.triangles)
    m.add(to_double(mesh.positions[t[0]]), to_double(mesh.positions[t[1]]), to_double(mesh.positions[t[2]]));
  return m.result();
}

FragmentSet fracture_at(const Mesh& mesh, std::vector<Vec3d> points) {
  FractureParameters p;
  p.pattern = PointsPattern{std::move(points)};
  StageTimings timings;
  const Expected<Solid> solid = make_solid(std::make_shared<Mesh>(mesh), {}, {});
  return fracture(*solid, *make_diagram(*solid, p, {}, timings), p, {}, timings).value().set;
}

TEST(MassIntegral, BoxHasItsTextbookInertia) {
  const Vec3d low{1, 2, 3}, high{2, 4, 6};  // sides 1 x 2 x 3
  const MassProperties m = mass_of(box(low, high), {0, 0, 0});
  EXPECT_NEAR(m.volume, 6, 1e-12);
  EXPECT_NEAR(m.area, 2 * (2 + 3 + 6), 1e-12);
  EXPECT_NEAR(length(m.center_of_mass - Vec3d{1.5, 3, 4.5}), 0, 1e-12);
  EXPECT_NEAR(m.inertia[0], 6.0 / 12 * (4 + 9), 1e-9);
  EXPECT_NEAR(m.inertia[1], 6.0 / 12 * (1 + 9), 1e-9);
  EXPECT_NEAR(m.inertia[2], 6.0 / 12 * (1 + 4), 1e-9);
  for (int k = 3; k < 6; ++k) EXPECT_NEAR(m.inertia[k], 0, 1e-9);
}

TEST(MassIntegral, TetrahedronHasItsTextbookProducts) {
  // Corners 0, x, y, z. Second moments are 1/60 and products 1/120 about the origin. The centre is (1/4, 1/4,
  // 1/4) and the volume 1/6.
  const Mesh t = tetrahedron();
  const MassProperties m = mass_of(t, {0.3, 0.1, 0.2});
  const double v = volume_of(t);
  EXPECT_NEAR(m.volume, v, 1e-12);
  Vec3d center;
  for (const Vec3f& p : t.positions) center = center + 0.25 * to_double(p);
  EXPECT_NEAR(length(m.center_of_mass - center), 0, 1e-12);
  // For any tetrahedron, the integral of (x - c)_i (x - c)_j = V/20 · sum over corners of (p - c)_i (p -
  // c)_j.
  double s[3][3] = {};
  for (const Vec3f& f : t.positions) {
    const Vec3d p = to_double(f) - center;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) s[i][j] += v / 20 * p[i] * p[j];
  }
  EXPECT_NEAR(m.inertia[0], s[1][1] + s[2][2], 1e-12);
  EXPECT_NEAR(m.inertia[1], s[0][0] + s[2][2], 1e-12);
  EXPECT_NEAR(m.inertia[2], s[0][0] + s[1][1], 1e-12);
  EXPECT_NEAR(m.inertia[3], -s[0][1], 1e-12);
  EXPECT_NEAR(m.inertia[4], -s[0][2], 1e-12);
  EXPECT_NEAR(m.inertia[5], -s[1][2], 1e-12);
}

TEST(MassIntegral, FarAwayKeepsItsFigures) {
  const Vec3d far{1000, -2000, 4000};
  const Mesh moved = translated(torus(24, 12), far);  // rounding makes a slightly different torus
  EXPECT_NEAR(mass_of(moved, far).volume, volume_of(moved), 1e-12 * volume_of(moved));
  EXPECT_NEAR(length(mass_of(moved, far).center_of_mass - far), 0, 1e-4);
}

TEST(CertainVolume, IsThePreciseSumWhereTheOneInDoublesCancelsAndOnlyThere) {
  Random random(12);
  const Execution execution;
  Pacer pacer(execution);
  const std::vector<std::uint32_t> triangles{0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
  int cancelling = 0;
  for (int n = 0; n < 4000; ++n) {
    // Four points near a line or, every other time, near a plane.
    const double thin = std::ldexp(1.0, -static_cast<int>(random.below(n % 2 ? 22 : 45)));
    std::vector<Vec3d> points;
    Box box;
    for (int k = 0; k < 4; ++k) {
      const double along = random.uniform(), across = (n % 2 ? thin : 1.0) * random.uniform();
      const Vec3d noise{random.uniform(), random.uniform(), random.uniform()};
      points.push_back(along * Vec3d{0.31, 0.73, 0.59} + across * Vec3d{0.67, -0.37, 0.11} + thin * noise);
      box.add(points.back());
    }
    exact::VolumeSum precise(points[0]);
    MassIntegral plain(points[0]);
    double products = 0, reach = 0;
    for (std::size_t k = 0; k < triangles.size(); k += 3) {
      const Vec3d &p = points[triangles[k]], &q = points[triangles[k + 1]], &r = points[triangles[k + 2]];
      precise.add(p, q, r);
      plain.add(p, q, r);
      const Vec3d a = p - points[0], b = q - points[0], c = r - points[0];
      products += exact::max_norm(b - a) * exact::max_norm(c - a);
      reach = std::max(reach, exact::max_norm(a));
    }
    const bool cancels = exact::cancels(plain.volume(), products, reach);
    EXPECT_EQ(certain_volume(plain.volume(), points, box, triangles, pacer),
              cancels ? precise.volume() : plain.volume())
        << n;
    cancelling += cancels;
  }
  EXPECT_GT(cancelling, 500);
  EXPECT_LT(cancelling, 3500);
}

TEST(Closedness, CountsOpenAndPinchedEdges) {
  Fragment f;
  f.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  f.indices = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
  EXPECT_EQ(closedness(f).open_edges, 0u);
  EXPECT_EQ(closedness(f).pinched_edges, 0u);
  f.indices.resize(9);
  EXPECT_EQ(closedness(f).open_edges, 3u);
  f.indices = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3, 0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
  EXPECT_EQ(closedness(f).open_edges, 0u);
  EXPECT_EQ(closedness(f).pinched_edges, 6u);
}

TEST(Closedness, OfAnAnswerIsThatOfTopologyAndPositions) {
  Fragment f;
  f.positions = {
      {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}};  // vertex 4 has the place of vertex 0: a seam
  f.indices = {4, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
  f.topology = {0, 1, 2, 3, 0};
  EXPECT_EQ(open_edges(f), 0u);
  f.topology = {0, 1, 2, 3, 4};
  EXPECT_EQ(open_edges(f), 4u) << "1-4, 4-2 and what is opposite";
  f.topology = {0, 1, 2, 3, 0};
  f.positions[4] = {0, 0, -1};
  EXPECT_GT(open_edges(f), 0u) << "closed in its topology, but vertex 4 is not where vertex 0 is";
}

/// The surface of unit cells: two triangles for each face between inside and outside. Equal positions are one
/// vertex.
Mesh surface_of_cells(const std::vector<std::array<int, 3>>& cells) {
  Mesh mesh;
  std::map<std::array<int, 3>, std::uint32_t> vertex_at;
  const std::set<std::array<int, 3>> inside(cells.begin(), cells.end());
  for (const auto& cell : cells)
    for (int axis = 0; axis < 3; ++axis)
      for (const int side : {0, 1}) {
        auto neighbor = cell;
        neighbor[axis] += side == 0 ? -1 : 1;
        if (inside.contains(neighbor)) continue;
        std::array<std::uint32_t, 4> corner;
        for (int k = 0; k < 4; ++k) {  // around the face, seen against the axis
          auto at = cell;
          at[axis] += side;
          at[(axis + 1) % 3] += k == 1 || k == 2;
          at[(axis + 2) % 3] += k >= 2;
          const auto [it, fresh] =
              vertex_at.try_emplace(at, static_cast<std::uint32_t>(mesh.positions.size()));
          if (fresh)
            mesh.positions.push_back(
                {static_cast<float>(at[0]), static_cast<float>(at[1]), static_cast<float>(at[2])});
          corner[side == 1 ? k : 3 - k] = it->second;
        }
        mesh.triangles.push_back({corner[0], corner[1], corner[2]});
        mesh.triangles.push_back({corner[0], corner[2], corner[3]});
      }
  return mesh;
}

// The ends of a chain of cells touch at the point (1, 1, 1). In the file, two fans of triangles meet at one
// vertex, and one of the fans has a second vertex there. The solid has a vertex for each fan, and so must the
// fragment.
TEST(Fragments, FansThatShareAVertexOfTheFileStayApart) {
  Mesh mesh = surface_of_cells(
      {{0, 0, 0}, {-1, 0, 0}, {-1, 0, 1}, {-1, 0, 2}, {0, 0, 2}, {1, 0, 2}, {1, 1, 2}, {1, 1, 1}});
  const Vec3f pinch{1, 1, 1};
  const auto is_pinch = [&](std::uint32_t v) { return mesh.positions[v] == pinch; };
  const auto second = static_cast<std::uint32_t>(mesh.positions.size());
  const auto of_last_cell = std::find_if(mesh.triangles.rbegin(), mesh.triangles.rend(), [&](const auto& t) {
    return std::any_of(t.begin(), t.end(), is_pinch);
  });
  ASSERT_NE(of_last_cell, mesh.triangles.rend());
  std::replace_if(of_last_cell->begin(), of_last_cell->end(), is_pinch, second);
  mesh.positions.push_back(pinch);
  mesh.attributes.uvs.assign(1, std::vector<Vec2f>(mesh.positions.size(), Vec2f{0, 0}));
  const FragmentSet set = fracture_at(mesh, {{0, 0, 0}});
  ASSERT_EQ(set.fragments.size(), 1u);
  EXPECT_EQ(set.fragments[0].open_edges, 0u);
}

TEST(Fragments, TwoHalvesOfACubeShareOneSquareBond) {
  const FragmentSet set = fracture_at(cube(), {{-0.25, 0, 0}, {0.25, 0, 0}});
  ASSERT_EQ(set.fragments.size(), 2u);
  ASSERT_EQ(set.bonds.size(), 1u);
  EXPECT_NEAR(set.bonds[0].area, 1, 1e-12);
  EXPECT_NEAR(length(set.bonds[0].centroid), 0, 1e-12);
  EXPECT_NEAR(length(set.bonds[0].normal - Vec3d{1, 0, 0}), 0, 1e-12);
  for (const Fragment& f : set.fragments) {
    EXPECT_NEAR(f.mass.volume, 0.5, 1e-12);
    EXPECT_NEAR(f.mass.area, 4, 1e-12);
    EXPECT_NEAR(f.exterior_area, 3, 1e-12);
    EXPECT_NEAR(std::fabs(f.mass.center_of_mass.x), 0.25, 1e-12);
  }
}

TEST(Fragments, EightOctantsOfACubeShareThreeUnitSquares) {
  std::vector<Vec3d> sites;
  for (int k = 0; k < 8; ++k)
    sites.push_back({k & 1 ? 0.25 : -0.25, k & 2 ? 0.25 : -0.25, k & 4 ? 0.25 : -0.25});
  const FragmentSet set = fracture_at(cube(), sites);
  ASSERT_EQ(set.fragments.size(), 8u);
  for (const Fragment& f : set.fragments) EXPECT_NEAR(f.mass.volume, 0.125, 1e-12);
  // The perturbation lets more cells touch along edges. Only bonds with area count, and those add up to three
  // unit squares.
  double area = 0;
  for (const Bond& b : set.bonds) area += b.area;
  EXPECT_NEAR(area, 3, 1e-12);
}

TEST(Fragments, AttributesAreInterpolatedLinearlyAtCuts) {
  // The UVs of the cube are an affine function of position. Every exterior vertex must still satisfy that
  // function.
  Mesh mesh = cube_with_seams();
  ASSERT_FALSE(mesh.attributes.uvs.empty());
  for (std::size_t w = 0; w < mesh.positions.size(); ++w) {
    const Vec3f& p = mesh.positions[w];
    mesh.attributes.uvs[0][w] = {0.25f + 0.5f * p.x + 0.125f * p.y, 0.5f - 0.25f * p.z + 0.5f * p.y};
  }
  const FragmentSet set =
      fracture_at(mesh, {{-0.3, 0.1, 0.05}, {0.2, 0.2, -0.1}, {0.1, -0.3, 0.2}, {0.05, 0.1, 0.3}});
  int cut = 0;
  for (const Fragment& f : set.fragments)
    for (const FragmentPrimitive& p : f.primitives)
      for (std::uint32_t k = p.first_index; k < p.first_index + p.index_count; ++k) {
        const std::uint32_t v = f.indices[k];
        const Vec3d w = to_double(f.positions[v]) + f.pivot;
        EXPECT_NEAR(length(to_double(f.attributes.normals[v])), 1, 1e-6);
        if (p.material == kInteriorMaterial) continue;
        EXPECT_NEAR(f.attributes.uvs[0][v].x, 0.25 + 0.5 * w.x + 0.125 * w.y, 1e-6);
        EXPECT_NEAR(f.attributes.uvs[0][v].y, 0.5 - 0.25 * w.z + 0.5 * w.y, 1e-6);
        cut += std::fabs(std::fabs(w.x) - 0.5) > 1e-6 || std::fabs(std::fabs(w.y) - 0.5) > 1e-6 ||
               std::fabs(std::fabs(w.z) - 0.5) > 1e-6;
      }
  EXPECT_GT(cut, 0);
}

TEST(Fragments, TexturesOfCutsLieAlongTheGrain) {
  const Vec3d grain = (1.0 / 3) * Vec3d{1, 2, 2};
  FractureParameters p;
  p.pattern = PointsPattern{{{-0.3, 0.1, 0.05}, {0.2, 0.2, -0.1}, {0.1, -0.3, 0.2}, {0.05, 0.1, 0.3}}};
  p.anisotropy = {.stretch = 4, .grain = grain};
  StageTimings timings;
  const Expected<Solid> solid = make_solid(std::make_shared<Mesh>(cube_with_seams()), {}, {});
  const FragmentSet set = fracture(*solid, *make_diagram(*solid, p, {}, timings), p, {}, timings).value().set;
  int along = 0;
  for (const Fragment& f : set.fragments)
    for (const FragmentPrimitive& cuts : f.primitives) {
      if (cuts.material != kInteriorMaterial) continue;
      for (std::uint32_t k = cuts.first_index; k < cuts.first_index + cuts.index_count; k += 3) {
        const auto corner = [&](std::uint32_t n) { return to_double(f.positions[f.indices[k + n]]); };
        const auto v_of = [&](std::uint32_t n) { return f.attributes.uvs[0][f.indices[k + n]].y; };
        const Vec3d normal = cross(corner(1) - corner(0), corner(2) - corner(0));
        const Vec3d in_plane = grain - (dot(grain, normal) / dot(normal, normal)) * normal;
        if (!(length(normal) > 1e-6) || length(in_plane) < 0.4) continue;  // across the grain
        ++along;
        // The second coordinate is metres along the grain, projected onto the face.
        for (const std::uint32_t n : {1u, 2u})
          EXPECT_NEAR(v_of(n) - v_of(0), dot(corner(n) - corner(0), (1 / length(in_plane)) * in_plane), 1e-5);
      }
    }
  EXPECT_GT(along, 5);
}

TEST(Fragments, InteriorNormalsPointOutOfTheFragment) {
  const FragmentSet set =
      fracture_at(cube_with_seams(), {{-0.3, 0.1, 0.05}, {0.2, 0.2, -0.1}, {0.1, -0.3, 0.2}});
  for (const Fragment& f : set.fragments)
    for (const FragmentPrimitive& p : f.primitives) {
      if (p.material != kInteriorMaterial) continue;
      for (std::uint32_t k = p.first_index; k < p.first_index + p.index_count; k += 3) {
        const auto at = [&](std::uint32_t n) { return to_double(f.positions[f.indices[n]]); };
        const Vec3d n = cross(at(k + 1) - at(k), at(k + 2) - at(k));
        if (!(length(n) > 1e-5)) continue;  // rounding decides a sliver's direction
        EXPECT_GT(dot(n, to_double(f.attributes.normals[f.indices[k]])), 0.99 * length(n));
      }
    }
}

TEST(Fragments, IdsDependOnTheSitesAndNotOnTheirOrder) {
  const std::vector<Vec3d> sites{{-0.3, 0.1, 0.05}, {0.2, 0.2, -0.1}, {0.1, -0.3, 0.2}};
  const FragmentSet a = fracture_at(cube(), sites), b = fracture_at(cube(), {sites[2], sites[0], sites[1]});
  std::vector<std::uint64_t> ids_a, ids_b;
  for (const Fragment& f : a.fragments) ids_a.push_back(f.id);
  for (const Fragment& f : b.fragments) ids_b.push_back(f.id);
  std::sort(ids_a.begin(), ids_a.end());
  std::sort(ids_b.begin(), ids_b.end());
  EXPECT_EQ(ids_a, ids_b);
  for (const std::uint64_t id : ids_a) EXPECT_LT(id, 1ull << 53);
}

}  // namespace
}  // namespace fracture::test
