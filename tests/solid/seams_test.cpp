// Subdivided faces next to faces that are not subdivided. Their edges have only the end vertices in common.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "common/solid/solid.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/solids.hpp"

namespace fracture::test {
namespace {

/// The unit cube. Face k (-x +x -y +y -z +z) has divisions[k] x divisions[k] squares.
Mesh cube_of_faces(const std::vector<int>& divisions) {
  std::vector<Mesh> faces;
  for (int k = 0; k < 6; ++k) {
    Mesh face = cube(divisions[static_cast<std::size_t>(k)]);
    std::erase_if(face.triangles, [&](const auto& t) {
      for (const std::uint32_t v : t)
        if (to_double(face.positions[v])[k / 2] != (k % 2 == 0 ? -0.5 : 0.5)) return true;
      return false;
    });
    face.material.assign(face.triangles.size(), static_cast<std::uint32_t>(k));
    face.node.assign(face.triangles.size(), 0);
    faces.push_back(face);
  }
  Mesh mesh = joined(faces);
  std::size_t t = 0;
  for (const Mesh& face : faces)
    for (const std::uint32_t m : face.material) mesh.material[t++] = m;
  return mesh;
}

/// Turns the mesh about a skew axis, so that no point lies exactly on a line.
Mesh turned(Mesh mesh) {
  const CirclePoint a = circle_point(1, 17), b = circle_point(2, 23);
  for (Vec3f& p : mesh.positions) {
    const Vec3d q = to_double(p);
    const double x = a.cos * q.x - a.sin * q.y, y = a.sin * q.x + a.cos * q.y;
    p = {static_cast<float>(x), static_cast<float>(b.cos * y - b.sin * q.z),
         static_cast<float>(b.sin * y + b.cos * q.z)};
  }
  return mesh;
}

/// Expects every source triangle in the solid, and almost zero area in the triangles that fill the seams.
void expect_whole(const Mesh& mesh, double tolerance) {
  const Expected<Solid> solid = try_solid(mesh);
  ASSERT_TRUE(solid) << solid.error().detail;
  ASSERT_NO_THROW(solid->validate());
  EXPECT_EQ(solid->parts.size(), 1u);
  EXPECT_EQ(solid->report.shells, 1u);
  EXPECT_EQ(solid->report.shells_dropped, 0u);
  EXPECT_NEAR(solid->report.volume, 1, 10 * tolerance);
  EXPECT_NEAR(solid->report.area, 6, 100 * tolerance);
  EXPECT_LE(solid->report.filled_area, 10 * tolerance);
  std::vector<char> seen(mesh.triangles.size(), 0);
  std::size_t from_source = 0;
  for (std::size_t t = 0; t < solid->triangles.size(); ++t) {
    if (solid->wedges[t][0] == kNoIndex) continue;
    ++from_source;
  }
  EXPECT_EQ(from_source, mesh.triangles.size());
}

TEST(Seams, ASubdividedFaceOfACubeStays) {
  for (const int n : {2, 3, 8, 40}) {
    SCOPED_TRACE(n);
    const Mesh mesh = cube_of_faces({1, n, 1, 1, 1, 1});
    expect_whole(mesh, 1e-7);
    const Solid solid = solid_of(mesh);
    EXPECT_EQ(solid.report.holes_filled, 4u) << "one for each edge of the face";
    EXPECT_EQ(solid.report.fill_triangles, 4u * static_cast<unsigned>(n - 1));
    EXPECT_EQ(solid.report.filled_area, 0);
  }
}

TEST(Seams, FacesWithDifferentDivisionsOnBothSidesStay) {
  expect_whole(cube_of_faces({1, 2, 3, 4, 5, 6}), 1e-6);
  expect_whole(cube_of_faces({7, 2, 9, 4, 1, 6}), 1e-6);
}

TEST(Seams, TheyNeedNotLieExactlyOnALine) {
  expect_whole(turned(cube_of_faces({1, 8, 1, 1, 1, 1})), 1e-6);
  expect_whole(turned(cube_of_faces({3, 8, 5, 1, 2, 7})), 1e-6);
}

TEST(Seams, FarFromTheOriginToo) {
  expect_whole(translated(cube_of_faces({1, 8, 1, 4, 1, 1}), {1000, -2000, 500}), 1e-3);
  expect_whole(translated(turned(cube_of_faces({1, 8, 1, 4, 1, 1})), {1000, -2000, 500}), 1e-3);
}

/// Moves the four corners of the face of material 1 (+x), but not the vertices between them. `center`: of the cube, m.
Mesh with_moved_corners(Mesh mesh, const Vec3f& by, const Vec3f& center = {0, 0, 0}) {
  std::vector<char> of_face(mesh.positions.size(), 0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (const std::uint32_t v : mesh.triangles[t])
      if (mesh.material[t] == 1) of_face[v] = 1;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    Vec3f& p = mesh.positions[v];
    if (of_face[v] != 0 && std::fabs(p.y - center.y) == 0.5f && std::fabs(p.z - center.z) == 0.5f)
      p = {p.x + by.x, p.y + by.y, p.z + by.z};
  }
  return mesh;
}

// The weld tolerance is 1.7e-6 m, a millionth of the diagonal. No edges of the two sides coincide, however near the ends are.
TEST(Seams, TheirEndsNeedNotBeOneVertex) {
  for (const float distance : {1e-7f, 1e-6f})
    for (const int n : {4, 40}) {
      SCOPED_TRACE(n);
      SCOPED_TRACE(distance);
      const Mesh mesh =
          with_moved_corners(cube_of_faces({1, n, 1, 1, 1, 1}), {distance, -0.5f * distance, 0});
      expect_whole(mesh, 1e-6);
      const Solid solid = solid_of(mesh);
      EXPECT_EQ(solid.report.welded_tolerant, 4u);
      EXPECT_EQ(solid.report.holes_filled, 4u) << "one for each edge of the face";
      EXPECT_EQ(solid.report.sheets, 0u);
    }
  expect_whole(with_moved_corners(cube_of_faces({1, 2, 3, 4, 5, 6}), {1e-7f, -1e-7f, 1e-7f}), 1e-6);
}

TEST(Seams, NothingMovesButTheirEnds) {
  const Mesh mesh = with_moved_corners(cube_of_faces({1, 4, 1, 1, 1, 1}), {1e-6f, 0, 0});
  const Solid solid = solid_of(mesh);
  EXPECT_EQ(solid.positions.size(), 8u + 25u - 4u);
  for (std::size_t t = 0; t < solid.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      if (solid.wedges[t][k] == kNoIndex) continue;
      const Vec3f &is = solid.positions[solid.triangles[t][k]], &was = mesh.positions[solid.wedges[t][k]];
      const bool corner = std::fabs(was.y) == 0.5f && std::fabs(was.z) == 0.5f && was.x > 0;
      EXPECT_LE(length(to_double(is) - to_double(was)), corner ? 1.1e-6 : 0.0);
    }
}

// The moved corners stay in the plane of the face, so the face is a sheet.
TEST(Seams, EndsBeyondTheWeldToleranceStayApart) {
  const Mesh cube = cube_of_faces({1, 4, 1, 1, 1, 1});
  const Mesh mesh = with_moved_corners(cube, {0, -1e-5f, 0});
  const Solid solid = solid_of(mesh);
  EXPECT_EQ(solid.report.welded_tolerant, 0u);
  EXPECT_EQ(solid.report.sheets, 1u);
  EXPECT_NEAR(solid.report.filled_area, 1, 1e-4);
  const Solid wider = solid_of(mesh, {.weld_tolerance = 1e-4});
  EXPECT_EQ(wider.report.welded_tolerant, 4u);
  EXPECT_EQ(wider.report.sheets, 0u);
  EXPECT_EQ(solid_of(with_moved_corners(cube, {0, -1e-7f, 0}), {.weld_tolerance = 0}).report.sheets, 1u);
}

// At 1 km, neighbouring floats are 0.00006 m apart: more than the weld tolerance, but not more than what rounding explains.
TEST(Seams, TheirEndsMayDifferByTheRoundingOfFloats) {
  const Mesh far = translated(cube_of_faces({1, 4, 1, 1, 1, 1}), {1000, -2000, 500});
  const float step = std::nextafter(1000.5f, 2000.0f) - 1000.5f;
  expect_whole(with_moved_corners(far, {step, 0, 0}, {1000, -2000, 500}), 1e-3);
}

TEST(Seams, StrictRepairRefusesThem) {
  const Expected<Solid> solid = try_solid(cube_of_faces({1, 8, 1, 1, 1, 1}), {.repair = Repair::kStrict});
  ASSERT_FALSE(solid);
  EXPECT_EQ(solid.error().code, ErrorCode::kMeshNotClosed);
}

// The lid is not only subdivided but also slightly off. Beyond the weld tolerance it stays a separate sheet.
TEST(Seams, WhatIsFartherThanTheToleranceIsNoSeam) {
  Mesh mesh = cube_of_faces({1, 1, 1, 1, 1, 4});
  for (Vec3f& p : mesh.positions)
    if (p.z == 0.5f && std::fabs(p.x) < 0.5f) p.z += 0.01f;
  const Expected<Solid> solid = try_solid(mesh);
  ASSERT_TRUE(solid) << solid.error().detail;
  ASSERT_NO_THROW(solid->validate());
  EXPECT_GT(solid->report.filled_area, 0.01);
}

// Many open edges along one line, none of which can be closed. The search must end.
TEST(Seams, ACombOfOverlappingEdgesEnds) {
  Mesh mesh;
  const int n = 3000;
  mesh.positions.push_back({0, 0, 0});
  for (int k = 1; k <= n; ++k) {
    mesh.positions.push_back({static_cast<float>(k), 0, 0});
    mesh.positions.push_back({static_cast<float>(k) * 0.5f, 1, static_cast<float>(k)});
  }
  for (std::uint32_t k = 0; k < static_cast<std::uint32_t>(n); ++k)
    mesh.triangles.push_back({0, 2 * k + 1, 2 * k + 2});
  mesh.triangles.push_back({1, 3, 6});
  mesh.material.assign(mesh.triangles.size(), kNoIndex);
  mesh.node.assign(mesh.triangles.size(), 0);
  mesh.node_names = {"comb"};
  const Expected<Solid> solid = try_solid(mesh);
  if (solid)
    EXPECT_NO_THROW(solid->validate());
  else
    EXPECT_EQ(solid.error().code, ErrorCode::kMeshNotClosed);
}

}  // namespace
}  // namespace fracture::test
