// The parameters of patterns, sizes, walls and cuts do what they say. This is measured on the fragments with methods of this file, on
// four meshes with one seed each, or with FRACTURE_TEST_FULL on twenty meshes and three seeds. Hits: hits_test.cpp.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include "common/base/random.hpp"
#include "common/hollow/hollow.hpp"
#include "tests/support/fractured.hpp"
#include "tests/support/full_tests.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/solids.hpp"

namespace fracture::test {
namespace {

using Corners = std::array<Vec3d, 3>;

/// Twenty closed meshes of one part, none of them a thin plate.
std::vector<NamedMesh> meshes() {
  return {{"cube", cube(4)},
          {"sphere", sphere_with(800)},
          {"torus", torus(32, 16)},
          {"beam", box({-1, -0.2, -0.2}, {1, 0.2, 0.2}, 3)},
          {"tetrahedron", tetrahedron()},
          {"coarse cube", cube(1)},
          {"fine cube", cube(12)},
          {"brick", box({0, 0, 0}, {2, 1, 0.7}, 2)},
          {"pillar", box({3, 0, 3}, {3.5, 2, 3.5}, 3)},
          {"slab", box({-1, 0, -1}, {1, 0.4, 1}, 4)},
          {"icosphere", ico_sphere(3)},
          {"coarse icosphere", ico_sphere(1)},
          {"egg", scaled(ico_sphere(3), {0.7, 1, 0.7})},
          {"lens", scaled(sphere_with(1200), {1, 0.5, 1})},
          {"far sphere", translated(sphere_with(500), {100, 20, -50})},
          {"tiny sphere", scaled(sphere_with(500), {0.01, 0.01, 0.01})},
          {"large torus", scaled(torus(24, 12), {30, 30, 30})},
          {"thick torus", torus(32, 16, 1, 0.6)},
          {"cube with seams", cube_with_seams()},
          {"sphere with seams", sphere_with_seams(12, 24)}};
}

void each(const std::function<void(const Mesh&, std::uint64_t)>& measure) {
  const std::vector<NamedMesh> all = meshes();
  ASSERT_EQ(all.size(), 20u);
  for (std::size_t k = 0; k < all.size(); ++k)
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      if (!full_tests() && (k >= 4 || seed != 1 + k % 3)) continue;
      SCOPED_TRACE(all[k].name + ", seed " + std::to_string(seed));
      measure(all[k].mesh, seed);
    }
}

FractureParameters with(std::uint32_t sites, std::uint64_t seed, const SitePattern& pattern = {}) {
  FractureParameters p;
  p.sites = sites;
  p.seed = seed;
  p.pattern = pattern;
  p.pivot = Pivot::kSource;
  return p;
}

Box box_of(const Mesh& mesh) {
  Box box;
  for (const Vec3f& v : mesh.positions) box.add(to_double(v));
  return box;
}

std::vector<Corners> triangles_of(const Fragment& f) {
  std::vector<Corners> all;
  for (std::size_t k = 0; k + 2 < f.indices.size(); k += 3) {
    Corners corners;
    for (std::size_t c = 0; c < 3; ++c) corners[c] = to_double(f.positions[f.indices[k + c]]) + f.pivot;
    all.push_back(corners);
  }
  return all;
}
Box box_of(const Fragment& f) {
  Box box;
  for (const Vec3f& v : f.positions) box.add(to_double(v) + f.pivot);
  return box;
}

/// Volume, centre, and the direction of the longest axis of inertia.
struct Body {
  double volume = 0;
  Vec3d center, axis;
};

/// From the tetrahedra between each triangle and a vertex. The axis is found by power iteration on the covariance of the volume.
Body body_of(const Fragment& f) {
  Body body;
  const Vec3d origin = to_double(f.positions[0]) + f.pivot;
  Vec3d first;                    // moment
  std::array<Vec3d, 3> second{};  // rows of the second moment
  for (const Corners& t : triangles_of(f)) {
    const Vec3d a = t[0] - origin, b = t[1] - origin, c = t[2] - origin, sum = a + b + c;
    const double volume = dot(a, cross(b, c)) / 6;
    body.volume += volume;
    first = first + (volume / 4) * sum;
    for (int i = 0; i < 3; ++i)
      second[static_cast<std::size_t>(i)] = second[static_cast<std::size_t>(i)] +
                                            (volume / 20) * (sum[i] * sum + a[i] * a + b[i] * b + c[i] * c);
  }
  const Vec3d middle = (1 / body.volume) * first;
  body.center = origin + middle;
  body.axis = {0.57, 0.58, 0.59};
  for (int k = 0; k < 200; ++k) {
    Vec3d next;
    for (int i = 0; i < 3; ++i)
      next[i] = dot((1 / body.volume) * second[static_cast<std::size_t>(i)] - middle[i] * middle, body.axis);
    body.axis = (1 / length(next)) * next;
  }
  return body;
}

std::vector<Body> bodies_of(const FragmentSet& set) {
  std::vector<Body> all;
  for (const Fragment& f : set.fragments) all.push_back(body_of(f));
  return all;
}

/// The volume of the mesh below a height: the signed volume of its clipped triangles, seen from a point at that height. (The face in
/// which the mesh is cut adds nothing, because that point is in its plane.)
double volume_below(const Mesh& mesh, double height) {
  const Vec3d eye{0, height, 0};
  double volume = 0;
  for (const auto& t : mesh.triangles) {
    std::vector<Vec3d> polygon;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3d a = to_double(mesh.positions[t[k]]), b = to_double(mesh.positions[t[(k + 1) % 3]]);
      if (a.y <= height) polygon.push_back(a);
      if ((a.y <= height) != (b.y <= height)) polygon.push_back(a + ((height - a.y) / (b.y - a.y)) * (b - a));
    }
    for (std::size_t k = 2; k < polygon.size(); ++k)
      volume += dot(polygon[0] - eye, cross(polygon[k - 1] - eye, polygon[k] - eye)) / 6;
  }
  return volume;
}

// keep_box: the kept share is that of the region, and its surface is a cut.
TEST(MeaningOfParameters, TheKeptShareIsThatOfTheRegion) {
  each([](const Mesh& mesh, std::uint64_t seed) {
    const Box box = box_of(mesh);
    const double size = box.longest_side(), height = box.min.y + 0.35 * box.size().y;
    FractureParameters p = with(40, seed);
    const Vec3d far{size, size, size};
    p.keep = Region{.shape = Region::Shape::kBox,
                    .box = {box.min - far, {box.max.x + size, height, box.max.z + size}}};
    const Fractured made = fracture_mesh(mesh, p);
    const double whole = made.solid.report.volume, share = volume_below(mesh, height) / whole;
    double kept = 0;
    for (const Fragment& f : made.set.fragments) {
      const Box of = box_of(f);
      const bool inside = of.max.y <= height + 1e-4 * size;
      EXPECT_TRUE(inside || of.min.y >= height - 1e-4 * size) << "a fragment is on both sides";
      if (inside) kept += body_of(f).volume;
    }
    EXPECT_NEAR(kept / whole, share, 1e-3);
    ASSERT_TRUE(made.report.kept);
    EXPECT_NEAR(made.report.kept->share, share, 1e-3);
  });
}

TEST(MeaningOfParameters, SlicesAreAsThickAsTheSpacing) {
  each([](const Mesh& mesh, std::uint64_t seed) {
    const Box box = box_of(mesh);
    const double spacing = box.size().y / 7;
    const Fractured made = fracture_mesh(
        mesh, with(40, seed, SlicePattern{.normals = {{0, 1, 0}}, .spacing = spacing, .jitter = 0}));
    std::set<int> slices;
    for (const Fragment& f : made.set.fragments) {
      const Box of = box_of(f);
      EXPECT_LE(of.size().y, spacing * (1 + 1e-3));
      slices.insert(static_cast<int>(std::floor((of.center().y - box.min.y) / spacing)));
    }
    EXPECT_GE(slices.size(), 6u);
    EXPECT_LE(slices.size(), 8u);
  });
}

// Without a stretch, the mean is about 0.5.
TEST(MeaningOfParameters, PiecesAreLongAlongTheGrain) {
  each([](const Mesh& mesh, std::uint64_t seed) {
    FractureParameters p = with(60, seed);
    p.anisotropy = {.stretch = 5, .grain = Vec3d{0, 1, 0}};
    const std::vector<Body> bodies = bodies_of(fracture_mesh(mesh, p).set);
    double volume = 0, along = 0, count = 0;
    for (const Body& body : bodies) volume += body.volume;
    for (const Body& body : bodies) {
      if (body.volume < 0.3 * volume / static_cast<double>(bodies.size())) continue;  // crumbs at the surface
      along += std::fabs(body.axis.y);
      ++count;
    }
    EXPECT_GT(along / count, 0.85);
  });
}

/// Bricks along the longer horizontal side of a wall.
TEST(MeaningOfParameters, BricksHaveTheSizeOfTheCell) {
  struct Wall {
    Vec3d high, cell;
    bool along_z = false;
  };
  for (const Wall& wall : {Wall{{2, 1, 0.6}, {0.4, 0.2, 0.3}}, Wall{{0.5, 1.2, 2.4}, {0.4, 0.15, 0.25}, true},
                           Wall{{2, 2, 0.2}, {0.5, 0.25, 0.2}}})
    for (const BrickPattern::Bond bond : {BrickPattern::Bond::kStack, BrickPattern::Bond::kHalf}) {
      const Fractured made = fracture_mesh(box({0, 0, 0}, wall.high),
                                           with(40, 1, BrickPattern{.cell = wall.cell, .bond = bond}));
      double whole = 0, volume = 0;
      for (const Fragment& f : made.set.fragments) {
        Vec3d size = box_of(f).size();
        if (wall.along_z) std::swap(size.x, size.z);
        bool is_whole = true;
        for (int a = 0; a < 3; ++a) {
          EXPECT_LE(size[a], wall.cell[a] + 1e-4);
          is_whole = is_whole && size[a] >= wall.cell[a] - 1e-4;
        }
        const double of = body_of(f).volume;
        volume += of;
        if (is_whole) whole += of;
      }
      // The sides of the walls are whole multiples of those of the bricks. Each second course begins and ends with half a brick.
      const double bricks = (wall.along_z ? wall.high.z : wall.high.x) / wall.cell.x;
      const double halves = bond == BrickPattern::Bond::kHalf ? 0.5 / bricks : 0;
      EXPECT_NEAR(whole / volume, 1 - halves, 1e-3);
    }
}

/// The distance at which the ray leaves the solid; infinite if it does not.
double along_ray(const Vec3d& from, const Vec3d& direction, const std::vector<Corners>& triangles) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Corners& t : triangles) {  // Möller and Trumbore 1997
    const Vec3d a = t[1] - t[0], b = t[2] - t[0], p = cross(direction, b), s = from - t[0], q = cross(s, a);
    const double determinant = dot(a, p);
    if (std::fabs(determinant) < 1e-14) continue;
    const double u = dot(s, p) / determinant, v = dot(direction, q) / determinant;
    const double distance = dot(b, q) / determinant;
    if (u < 0 || v < 0 || u + v > 1 || distance < 1e-6) continue;
    nearest = std::min(nearest, distance);
  }
  return nearest;
}

// Walls are at least as thick as requested. Flat walls are hardly thicker.
TEST(MeaningOfParameters, WallsAreAsThickAsTheShell) {
  each([](const Mesh& mesh, std::uint64_t seed) {
    if (!full_tests() && seed != 2) return;  // walls take long: only the sphere
    const double thickness =
        0.1 * std::min({box_of(mesh).size().x, box_of(mesh).size().y, box_of(mesh).size().z});
    const Solid solid = hollowed(solid_of(mesh), {.thickness = thickness}, {});
    ASSERT_EQ(solid.report.parts_hollowed, 1u);
    std::vector<Corners> all, outer;
    for (std::size_t t = 0; t < solid.triangles.size(); ++t) {
      Corners corners;
      for (std::size_t c = 0; c < 3; ++c) corners[c] = to_double(solid.positions[solid.triangles[t][c]]);
      all.push_back(corners);
      if (solid.shell[t] == solid.parts[0].shells[0]) outer.push_back(corners);
    }
    std::vector<double> distances;
    for (std::uint64_t k = 0; k < 100; ++k) {
      const Corners& t = outer[mix64(seed, k) % outer.size()];
      const Vec3d normal = cross(t[1] - t[0], t[2] - t[0]);
      const Vec3d middle = (1.0 / 3) * (t[0] + t[1] + t[2]);
      distances.push_back(along_ray(middle, (-1 / length(normal)) * normal, all));
    }
    std::sort(distances.begin(), distances.end());
    EXPECT_GE(distances.front(), thickness * (1 - 1e-3));
    EXPECT_LE(distances[distances.size() / 2], 1.6 * thickness);
  });
}

// Two cells on both sides of a plane: the distances of the cut's vertices from it.
TEST(MeaningOfParameters, RoughCutsMoveUpToTheAmplitude) {
  each([](const Mesh& mesh, std::uint64_t seed) {
    const Box box = box_of(mesh);
    const Vec3d aside{box.size().x / 4, 0, 0};
    FractureParameters p = with(2, seed, PointsPattern{{box.center() - aside, box.center() + aside}});
    p.roughness = {.amplitude = 0.04, .frequency = 5, .octaves = 2};
    const Fractured made = fracture_mesh(mesh, p);
    const double most = 0.04 * std::cbrt(made.solid.report.volume);
    double farthest = 0;
    for (const Fragment& f : made.set.fragments)
      for (const IndexRange& range : f.caps)
        for (std::uint32_t k = range.first; k < range.first + range.count; ++k)
          farthest = std::max(farthest, std::fabs(static_cast<double>(f.positions[f.indices[k]].x) +
                                                  f.pivot.x - box.center().x));
    EXPECT_LE(farthest, most * (1 + 1e-3));
    EXPECT_GE(farthest, 0.15 * most);
  });
}

TEST(MeaningOfParameters, VolumesAreWithinTheirLimits) {
  each([](const Mesh& mesh, std::uint64_t seed) {
    const double volume = solid_of(mesh).report.volume, mean = volume / 40;
    const auto volumes = [&](const std::function<void(FractureParameters&)>& limit) {
      FractureParameters p = with(40, seed);
      limit(p);
      std::vector<double> all;
      for (const Body& body : bodies_of(fracture_mesh(mesh, p).set)) all.push_back(body.volume);
      std::sort(all.begin(), all.end());
      return all;
    };
    const double rounding = 1e-4 * mean;
    EXPECT_GE(volumes([&](auto& p) { p.size.min_volume = 0.5 * mean; }).front(), 0.5 * mean - rounding);
    EXPECT_GE(volumes([&](auto& p) { p.size.min_fraction = 0.01; }).front(), 0.01 * volume - rounding);
    const std::vector<double> of_mean = volumes([&](auto& p) { p.size.min_of_mean = 0.6; });
    EXPECT_GE(of_mean.front(), 0.6 * volume / static_cast<double>(of_mean.size()) - rounding);
    EXPECT_LE(volumes([&](auto& p) { p.max_volume = 0.7 * mean; }).back(), 0.7 * mean + rounding);
    EXPECT_EQ(volumes([&](auto& p) { p.size.max_fragments = 7; }).size(), 7u);
  });
}

TEST(MeaningOfParameters, SmallPiecesAreNearTheImpact) {
  each([](const Mesh& mesh, std::uint64_t seed) {
    const Vec3d impact = to_double(mesh.positions[seed * mesh.positions.size() / 4]);
    std::vector<Body> bodies =
        bodies_of(fracture_mesh(mesh, with(60, seed, ImpactPattern{.impacts = {impact}})).set);
    std::sort(bodies.begin(), bodies.end(), [](const Body& a, const Body& b) { return a.volume < b.volume; });
    const std::size_t half = bodies.size() / 2;
    double near = 0, far = 0;
    for (std::size_t k = 0; k < half; ++k) near += length(bodies[k].center - impact);
    for (std::size_t k = bodies.size() - half; k < bodies.size(); ++k)
      far += length(bodies[k].center - impact);
    EXPECT_LT(near, 0.6 * far);
  });
}

}  // namespace
}  // namespace fracture::test
