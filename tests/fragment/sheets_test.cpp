// Sheets that fragments carry: areas, attributes, shared vertices, and who carries what.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "tests/support/fractured.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::test {
namespace {

constexpr std::uint32_t kCubeMaterial = 1, kPaneMaterial = 3;

/// [x0, x1] × [y0, y1] at this z, in n × n squares, facing +z. Texture coordinates are (x, 2 y).
Mesh pane(double x0, double x1, double y0, double y1, double z, int n = 1) {
  Mesh mesh;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i)
      mesh.positions.push_back({static_cast<float>(x0 + (x1 - x0) * i / n),
                                static_cast<float>(y0 + (y1 - y0) * j / n), static_cast<float>(z)});
  const auto at = [n](int i, int j) { return static_cast<std::uint32_t>(j * (n + 1) + i); };
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return mesh;
}

/// The parts with texture coordinates (x, 2 y) and normals; the last part has another material.
Mesh with_attributes(const std::vector<Mesh>& parts) {
  Mesh mesh = joined(parts);
  const std::size_t own = parts.back().triangles.size();
  mesh.material.assign(mesh.triangles.size(), kCubeMaterial);
  std::fill(mesh.material.end() - static_cast<std::ptrdiff_t>(own), mesh.material.end(), kPaneMaterial);
  mesh.node.assign(mesh.triangles.size(), 0);
  mesh.attributes = {};
  mesh.attributes.uvs.emplace_back();
  mesh.attributes.colors.emplace_back();
  for (const Vec3f& p : mesh.positions) {
    mesh.attributes.uvs[0].push_back({p.x, 2 * p.y});
    mesh.attributes.normals.push_back({0, 0, 1});
    mesh.attributes.colors[0].push_back({0.5f, 0.25f, 1, 1});
  }
  return mesh;
}

FractureParameters at(std::vector<Vec3d> points) {
  FractureParameters p;
  p.pattern = PointsPattern{std::move(points)};
  return p;
}

FractureParameters uniform(std::uint32_t sites) {
  FractureParameters p;
  p.sites = sites;
  p.seed = 7;
  return p;
}

Fractured fractured(const Mesh& mesh, const FractureParameters& p, SheetsMode mode = SheetsMode::kAttach) {
  return fracture_solid(make_solid(std::make_shared<Mesh>(mesh), {.sheets = mode}, {}).value(), p);
}

Vec3d world(const Fragment& f, std::uint32_t vertex) {
  return to_double(f.sheet->positions[vertex]) + f.pivot;
}

double sheet_area(const Fragment& f) {
  double area = 0;
  for (std::size_t k = 0; f.sheet && k < f.sheet->indices.size(); k += 3) {
    const Vec3d a = world(f, f.sheet->indices[k]);
    area += 0.5 * length(cross(world(f, f.sheet->indices[k + 1]) - a, world(f, f.sheet->indices[k + 2]) - a));
  }
  return area;
}

double sheet_area(const FragmentSet& set) {
  double area = 0;
  for (const Fragment& f : set.fragments) area += sheet_area(f);
  return area;
}

/// Expects the attributes that with_attributes() gives, at every vertex of every sheet.
void expect_attributes(const FragmentSet& set) {
  for (const Fragment& f : set.fragments) {
    if (!f.sheet) continue;
    ASSERT_EQ(f.sheet->attributes.uvs.size(), 1u);
    ASSERT_EQ(f.sheet->attributes.uvs[0].size(), f.sheet->positions.size());
    ASSERT_EQ(f.sheet->attributes.normals.size(), f.sheet->positions.size());
    ASSERT_EQ(f.sheet->attributes.colors[0].size(), f.sheet->positions.size());
    for (std::uint32_t v = 0; v < f.sheet->positions.size(); ++v) {
      const Vec3d p = world(f, v);
      EXPECT_NEAR(f.sheet->attributes.uvs[0][v].x, p.x, 1e-6);
      EXPECT_NEAR(f.sheet->attributes.uvs[0][v].y, 2 * p.y, 1e-6);
      EXPECT_EQ(f.sheet->attributes.normals[v], (Vec3f{0, 0, 1}));
      EXPECT_EQ(f.sheet->attributes.colors[0][v], (Vec4f{0.5f, 0.25f, 1, 1}));
    }
    ASSERT_EQ(f.sheet->primitives.size(), 1u);
    EXPECT_EQ(f.sheet->primitives[0].material, kPaneMaterial);
    EXPECT_TRUE(f.sheet->topology.empty());
  }
}

TEST(CarriedSheets, APaneOverACubeIsCutInTwo) {
  for (const double z : {0.0, 0.75, 40.0}) {  // in the cube, near it, and far outside its box
    SCOPED_TRACE(z);
    const Fractured made = fractured(with_attributes({cube(), pane(-0.5, 0.5, -0.5, 0.5, z)}),
                                     at({{-0.25, 0, 0}, {0.25, 0, 0}}));
    ASSERT_EQ(made.set.fragments.size(), 2u);
    for (std::size_t k = 0; k < 2; ++k) {
      const Fragment& f = made.set.fragments[k];
      ASSERT_TRUE(f.sheet);
      EXPECT_NEAR(sheet_area(f), 0.5, 1e-6);
      std::set<double> at_cut;
      for (std::uint32_t v = 0; v < f.sheet->positions.size(); ++v) {
        const Vec3d p = world(f, v);
        EXPECT_LE((k == 0 ? 1 : -1) * p.x, 0) << "on its own side of the cut";
        if (p.x == 0) at_cut.insert(p.y);
        EXPECT_NEAR(p.z, z, z * 1e-7);
      }
      EXPECT_EQ(at_cut, (std::set<double>{-0.5, 0, 0.5}))
          << "two sides and the diagonal of the square cross the cut";
    }
    expect_attributes(made.set);
    EXPECT_EQ(made.set.certificate.sheet_area_in, 1);
    EXPECT_NEAR(made.set.certificate.sheet_area_out, 1, 1e-12);
    EXPECT_NEAR(made.set.certificate.volume_out, 1, 1e-12) << "a sheet has no volume";
    EXPECT_NEAR(made.set.certificate.area_out, 6, 1e-12) << "and is not part of the solid's surface";
  }
}

TEST(CarriedSheets, APaneInACellBoundaryIsInTheAnswerOnce) {
  Mesh mesh = cube();
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (const Vec3f& p : {Vec3f{0, -1, -1}, Vec3f{0, 1, -1}, Vec3f{0, 1, 1}, Vec3f{0, -1, 1}})
    mesh.positions.push_back(p);
  mesh.triangles.push_back({first, first + 1, first + 2});
  mesh.triangles.push_back({first, first + 2, first + 3});
  mesh.material.assign(mesh.triangles.size(), 0);
  mesh.node.assign(mesh.triangles.size(), 0);
  const Fractured made = fractured(mesh, at({{-0.25, 0, 0}, {0.25, 0, 0}}));
  ASSERT_EQ(made.set.fragments.size(), 2u);
  EXPECT_NE(made.set.fragments[0].sheet == nullptr, made.set.fragments[1].sheet == nullptr);
  EXPECT_NEAR(sheet_area(made.set), 4, 1e-6);
  EXPECT_NEAR(made.set.certificate.sheet_area_out, 4, 1e-12);
}

TEST(CarriedSheets, ACellWithoutAFragmentGivesItsSheetsToTheNearest) {
  // The middle site has the space from x = 2.5 to 7.5, in which there is nothing of the cubes at 0 and 10.
  Mesh mesh =
      with_attributes({cube(), translated(cube(), {10, 0, 0}), pane(3, 4, 0, 1, 0), pane(6, 7, 0, 1, 0)});
  const Fractured made = fractured(mesh, at({{0, 0, 0}, {5, 0, 0}, {10, 0, 0}}));
  ASSERT_EQ(made.set.fragments.size(), 2u);
  for (const Fragment& f : made.set.fragments) {
    ASSERT_TRUE(f.sheet);
    EXPECT_NEAR(sheet_area(f), 1, 1e-6);
    EXPECT_LT(std::fabs(world(f, 0).x - f.pivot.x), 5) << "its own pane is the nearer one";
  }
}

TEST(CarriedSheets, ACellWithSeveralFragmentsGivesItsSheetsToTheNearest) {
  const Mesh mesh = with_attributes(
      {cube(), translated(cube(), {4, 0, 0}), pane(0.6, 0.9, 0, 1, 0), pane(3, 3.3, 0, 1, 0)});
  const Fractured made = fractured(mesh, at({{2, 0, 0}}));
  ASSERT_EQ(made.set.fragments.size(), 2u);
  for (const Fragment& f : made.set.fragments) {
    ASSERT_TRUE(f.sheet);
    EXPECT_NEAR(sheet_area(f), 0.3, 1e-6);
    EXPECT_LT(std::fabs(world(f, 0).x - f.pivot.x), 1.1);
  }
}

/// Directed edges of all sheets, by the world positions of their ends in the file.
using Point = std::array<float, 3>;
std::multiset<std::array<Point, 2>> edges_of(const FragmentSet& set) {
  std::multiset<std::array<Point, 2>> edges;
  for (const Fragment& f : set.fragments) {
    if (!f.sheet) continue;
    const auto place = [&](std::uint32_t v) -> Point {
      const Vec3f& p = f.sheet->positions[v];
      return {p.x + static_cast<float>(f.pivot.x), p.y + static_cast<float>(f.pivot.y),
              p.z + static_cast<float>(f.pivot.z)};
    };
    for (std::size_t k = 0; k < f.sheet->indices.size(); k += 3)
      for (std::size_t c = 0; c < 3; ++c)
        edges.insert({place(f.sheet->indices[k + c]), place(f.sheet->indices[k + (c + 1) % 3])});
  }
  return edges;
}

TEST(CarriedSheets, NeighboursShareTheVerticesOfTheCutBitForBit) {
  const Mesh mesh = with_attributes({cube(2), pane(-0.5, 0.5, -0.5, 0.5, 0.25, 5)});
  for (const std::uint32_t cells : {1u, 4u}) {  // flat chunks, and chunks of several cells
    FractureParameters p = uniform(24);
    p.aggregation.cells = cells;
    const Fractured made = fractured(mesh, p);
    const auto edges = edges_of(made.set);
    std::size_t inside = 0;
    for (const auto& [a, b] : edges) {
      const auto on = [](const Point& x, const Point& y, std::size_t axis, float value) {
        return x[axis] == value && y[axis] == value;
      };
      const bool border = on(a, b, 0, -0.5f) || on(a, b, 0, 0.5f) || on(a, b, 1, -0.5f) || on(a, b, 1, 0.5f);
      if (border) continue;
      ++inside;
      EXPECT_EQ(edges.count({a, b}), edges.count({b, a}));
    }
    EXPECT_GT(inside, 50u);
    expect_attributes(made.set);
    EXPECT_NEAR(sheet_area(made.set), 1, 1e-5);
    EXPECT_NEAR(made.set.certificate.sheet_area_out, 1, 1e-6);
  }
}

TEST(CarriedSheets, ATriangleInOneFragmentStaysWhole) {
  FractureParameters p = uniform(40);
  p.size.fragments = 1;  // all cells are one fragment
  const Mesh mesh = with_attributes({cube(), pane(-0.5, 0.5, -0.5, 0.5, 0.25, 3)});
  const Fractured made = fractured(mesh, p);
  ASSERT_EQ(made.set.fragments.size(), 1u);
  ASSERT_TRUE(made.set.fragments[0].sheet);
  EXPECT_EQ(made.set.fragments[0].sheet->indices.size(), 3u * 18);
  EXPECT_EQ(made.set.fragments[0].sheet->positions.size(), 16u);
}

TEST(CarriedSheets, LeaveTheFragmentsAsTheyAreWithoutThem) {
  const Mesh mesh = with_attributes({cube(3), pane(-0.5, 0.5, -0.5, 0.5, 0.7, 2)});
  const Fractured with = fractured(mesh, uniform(20)),
                  without = fractured(mesh, uniform(20), SheetsMode::kDrop);
  ASSERT_EQ(with.set.fragments.size(), without.set.fragments.size());
  EXPECT_EQ(without.set.certificate.sheet_area_in, 0);
  for (std::size_t k = 0; k < with.set.fragments.size(); ++k) {
    const Fragment &a = with.set.fragments[k], &b = without.set.fragments[k];
    EXPECT_EQ(a.id, b.id);
    EXPECT_EQ(a.positions, b.positions);
    EXPECT_EQ(a.indices, b.indices);
    EXPECT_EQ(a.topology, b.topology);
    EXPECT_EQ(a.mass.volume, b.mass.volume);
    EXPECT_FALSE(b.sheet);
  }
}

TEST(CarriedSheets, DoNotDependOnTheNumberOfThreads) {
  const Mesh mesh = with_attributes({cube(3), pane(-2, 2, -2, 2, 0.1, 40)});
  const Fractured one = fracture_mesh(mesh, uniform(60), 1), four = fracture_mesh(mesh, uniform(60), 4);
  ASSERT_EQ(one.set.fragments.size(), four.set.fragments.size());
  for (std::size_t k = 0; k < one.set.fragments.size(); ++k) {
    const Fragment &a = one.set.fragments[k], &b = four.set.fragments[k];
    ASSERT_EQ(a.sheet == nullptr, b.sheet == nullptr);
    if (!a.sheet) continue;
    EXPECT_EQ(a.sheet->positions, b.sheet->positions);
    EXPECT_EQ(a.sheet->indices, b.sheet->indices);
    EXPECT_EQ(a.sheet->attributes.uvs, b.sheet->attributes.uvs);
  }
  EXPECT_EQ(one.set.certificate.sheet_area_out, four.set.certificate.sheet_area_out);
}

TEST(CarriedSheets, StretchedAndRoughCutsKeepTheArea) {
  const Mesh mesh =
      with_attributes({cube(3), translated(cube(), {3, 0, 0}), pane(-0.5, 3.5, -0.5, 0.5, 0.6, 4)});
  FractureParameters stretched = uniform(30), rough = uniform(12);
  stretched.anisotropy.stretch = 4;
  rough.roughness.amplitude = 0.02;
  for (const FractureParameters& p : {stretched, rough}) {
    const Fractured made = fractured(mesh, p);
    EXPECT_NEAR(sheet_area(made.set), 4, 1e-4);
    EXPECT_NEAR(made.set.certificate.sheet_area_out, 4, 1e-5);
    expect_attributes(made.set);
  }
}

TEST(CarriedSheets, GoAlongWhenTheirFragmentIsBrokenAgain) {
  const Mesh mesh = with_attributes({cube(), pane(-0.5, 0.5, -0.5, 0.5, 0.75, 4)});
  const FractureParameters p = at({{-0.25, 0, 0}, {0.25, 0, 0}});
  const Fractured whole = fractured(mesh, p);
  const FracturedSolid again =
      fracture_mesh_again(mesh, p, {.fragment = whole.set.fragments[1].id, .sites = 6, .seed = 3});
  EXPECT_GT(again.set.fragments.size(), 3u);
  EXPECT_NEAR(again.set.certificate.sheet_area_in, 0.5, 1e-6);
  EXPECT_NEAR(again.set.certificate.sheet_area_out, 0.5, 1e-6);
  EXPECT_NEAR(sheet_area(again.set), 0.5, 1e-6);
  expect_attributes(again.set);
}

TEST(CarriedSheets, AreNotOfTheFragmentsIfTheyStayWhole) {
  const Fractured made =
      fractured(with_attributes({cube(), pane(-0.5, 0.5, -0.5, 0.5, 0.75)}), uniform(5), SheetsMode::kWhole);
  for (const Fragment& f : made.set.fragments) EXPECT_FALSE(f.sheet);
  ASSERT_TRUE(made.set.whole_sheets);
  EXPECT_EQ(made.set.whole_sheets->triangles, (std::vector<std::uint32_t>{12, 13}));
  EXPECT_EQ(made.set.certificate.sheet_area_in, 1);
  EXPECT_EQ(made.set.certificate.sheet_area_out, 1);
}

TEST(CarriedSheets, APaneInAFrameBreaksWithTheFrame) {
  // A frame of four bars, and a pane between them that touches nothing.
  const Mesh frame = joined({box({-1, -1, -0.1}, {1, -0.8, 0.1}), box({-1, 0.8, -0.1}, {1, 1, 0.1}),
                             box({-1, -0.8, -0.1}, {-0.8, 0.8, 0.1}), box({0.8, -0.8, -0.1}, {1, 0.8, 0.1})});
  const Fractured made =
      fractured(with_attributes({frame, pane(-0.79, 0.79, -0.79, 0.79, 0, 3)}), uniform(16));
  EXPECT_NEAR(sheet_area(made.set), 1.58 * 1.58, 1e-5);
  std::size_t carriers = 0;
  for (const Fragment& f : made.set.fragments) carriers += f.sheet != nullptr;
  EXPECT_GT(carriers, 3u) << "several pieces of the frame have a piece of the pane";
}

}  // namespace
}  // namespace fracture::test
