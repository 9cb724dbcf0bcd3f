// Every triangle of a sheet is in the answer exactly once, with its attributes: areas summed per source triangle,
// and points sampled on the sheets. The judge traces triangles by their materials and never calls the pipeline.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <vector>

#include "common/base/random.hpp"
#include "tests/property/judge.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/fractured.hpp"
#include "tests/support/full_tests.hpp"
#include "tests/support/mesh_files.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::test {
namespace {

constexpr std::uint64_t kSeed = 20261130;

/// A triangle of a sheet in the answer.
struct Seen {
  std::array<Vec3d, 3> corners;
  std::array<Vec2f, 3> uvs;
};

double area_of(const std::array<Vec3d, 3>& t) { return 0.5 * length(cross(t[1] - t[0], t[2] - t[0])); }

std::array<Vec3d, 3> source_corners(const Mesh& mesh, std::uint32_t t) {
  std::array<Vec3d, 3> corners;
  for (std::size_t k = 0; k < 3; ++k) corners[k] = to_double(mesh.positions[mesh.triangles[t][k]]);
  return corners;
}

/// The answer's triangles of sheets, by source triangle.
std::map<std::uint32_t, std::vector<Seen>> triangles_of(const FragmentSet& set) {
  std::map<std::uint32_t, std::vector<Seen>> found;
  for (const Fragment& f : set.fragments) {
    if (!f.sheet) continue;
    for (const FragmentPrimitive& p : f.sheet->primitives)
      for (std::uint32_t k = p.first_index; k < p.first_index + p.index_count; k += 3) {
        Seen& seen = found[p.material].emplace_back();
        for (std::uint32_t c = 0; c < 3; ++c) {
          const std::uint32_t v = f.sheet->indices[k + c];
          seen.corners[c] = to_double(f.sheet->positions[v]) + f.pivot;
          seen.uvs[c] = f.sheet->attributes.uvs[0][v];
        }
      }
  }
  return found;
}

/// Barycentric coordinates of p, projected onto the triangle's plane.
std::array<double, 3> weights(const std::array<Vec3d, 3>& t, const Vec3d& p) {
  const Vec3d n = cross(t[1] - t[0], t[2] - t[0]);
  const double all = dot(n, n);
  std::array<double, 3> w;
  for (std::size_t k = 0; k < 3; ++k) w[k] = dot(n, cross(t[(k + 1) % 3] - p, t[(k + 2) % 3] - p)) / all;
  return w;
}

Vec2f uv_at(const std::array<Vec2f, 3>& uvs, const std::array<double, 3>& w) {
  double u = 0, v = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    u += w[k] * uvs[k].x;
    v += w[k] * uvs[k].y;
  }
  return {static_cast<float>(u), static_cast<float>(v)};
}

/// `traced`: a mesh of with_traced_triangles().
void expect_sheets_once(const Fractured& made, const Mesh& traced, int samples) {
  ASSERT_TRUE(made.solid.sheets);
  const double size = length(made.solid.sheets->surface->box.size()), tolerance = 1e-6 * size;
  const auto found = triangles_of(made.set);
  EXPECT_EQ(found.size(), made.solid.sheets->triangles.size()) << "no other triangles, and each of them";
  double all = 0;
  for (const std::uint32_t t : made.solid.sheets->triangles) {
    ASSERT_TRUE(found.contains(t)) << "triangle " << t << " is not in the answer";
    const std::array<Vec3d, 3> source = source_corners(traced, t);
    double sum = 0, edges = 0;
    for (const Seen& seen : found.at(t)) {
      sum += area_of(seen.corners);
      for (std::size_t k = 0; k < 3; ++k) edges += length(seen.corners[(k + 1) % 3] - seen.corners[k]);
    }
    all += area_of(source);
    EXPECT_NEAR(sum, area_of(source), 1e-6 * area_of(source) + tolerance * edges);
  }
  EXPECT_NEAR(made.set.certificate.sheet_area_in, all, 1e-9 * all);
  EXPECT_NEAR(made.set.certificate.sheet_area_out, all, 1e-5 * all);

  Random random(kSeed);
  const bool uvs = !traced.attributes.uvs.empty();
  for (int n = 0; n < samples; ++n) {
    const auto& triangles = made.solid.sheets->triangles;
    const std::uint32_t t = triangles[random.below(triangles.size())];
    const double a = random.uniform(), b = random.uniform();
    std::array<double, 3> w{a, b, 0};
    if (w[0] + w[1] > 1) w = {1 - w[0], 1 - w[1], 0};
    w[2] = 1 - w[0] - w[1];
    const std::array<Vec3d, 3> source = source_corners(traced, t);
    const Vec3d p = w[0] * source[0] + w[1] * source[1] + w[2] * source[2];
    std::size_t inside = 0;
    bool near_border = false;
    for (const Seen& seen : found.at(t)) {
      if (!(area_of(seen.corners) > 0)) continue;
      const std::array<double, 3> own = weights(seen.corners, p);
      const double least = std::min({own[0], own[1], own[2]});
      double longest = 0;
      for (std::size_t k = 0; k < 3; ++k)
        longest = std::fmax(longest, length(seen.corners[(k + 1) % 3] - seen.corners[k]));
      near_border = near_border || std::fabs(least) * area_of(seen.corners) < tolerance * longest;
      if (least <= 0) continue;
      ++inside;
      if (!uvs) continue;
      std::array<Vec2f, 3> of_source;
      for (std::size_t k = 0; k < 3; ++k) of_source[k] = traced.attributes.uvs[0][traced.triangles[t][k]];
      const Vec2f is = uv_at(seen.uvs, own), should = uv_at(of_source, w);
      double range = 0;
      for (const Vec2f& uv : of_source) range = std::fmax(range, std::fmax(std::fabs(uv.x), std::fabs(uv.y)));
      if (near_border) continue;
      EXPECT_NEAR(is.x, should.x, 1e-3 * range + 1e-5);
      EXPECT_NEAR(is.y, should.y, 1e-3 * range + 1e-5);
    }
    if (!near_border) {
      EXPECT_EQ(inside, 1u) << "triangle " << t;
    }
  }
}

FractureParameters uniform(std::uint32_t sites, std::uint64_t seed) {
  FractureParameters p;
  p.sites = sites;
  p.seed = seed;
  return p;
}

/// Separate triangles of all sizes and directions, in and around the unit cube.
Mesh scattered_sheets(int count, std::uint64_t seed) {
  Random random(seed);
  Mesh mesh;
  const auto point = [&](double reach) {
    const double x = random.uniform(), y = random.uniform(), z = random.uniform();
    return Vec3d{reach * (2 * x - 1), reach * (2 * y - 1), reach * (2 * z - 1)};
  };
  for (int k = 0; k < count; ++k) {
    const double reach = k % 3 == 0 ? 0.05 : k % 3 == 1 ? 0.4 : 2;
    const Vec3d middle = point(0.8);
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (int c = 0; c < 3; ++c) {
      const Vec3d p = middle + point(reach);
      mesh.positions.push_back({static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)});
    }
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

TEST(SheetsOnce, ScatteredOverACube) {
  for (std::uint64_t seed = 1; seed <= sized(3u, 12u); ++seed) {
    SCOPED_TRACE(seed);
    Mesh mesh = joined({cube(3), scattered_sheets(60, seed)});
    mesh.attributes = {};
    mesh.attributes.uvs.emplace_back();
    for (const Vec3f& p : mesh.positions) mesh.attributes.uvs[0].push_back({p.x + p.z, p.y - p.z});
    const Mesh traced = with_traced_triangles(mesh);
    FractureParameters p = uniform(static_cast<std::uint32_t>(5 + 20 * seed), seed);
    if (seed % 3 == 0) p.anisotropy.stretch = 3;
    if (seed % 3 == 1) p.aggregation.cells = 3;
    const Fractured made = fracture_mesh(traced, p);
    expect_sheets_once(made, traced, sized(1000, 10'000));
    expect_closed(made.set);
    EXPECT_NEAR(made.set.certificate.volume_out, 1, 1e-9) << "sheets in the solid do not change it";
  }
}

TEST(SheetsOnce, OfRealMeshes) {
  int seen = 0;
  for (const MeshFile& file : test_meshes()) {
    const Expected<Mesh> mesh = load_mesh(file);
    if (!mesh || mesh->triangles.size() > sized(20'000u, 200'000u)) continue;
    const Mesh traced = with_traced_triangles(*mesh);
    Expected<Solid> solid = make_solid(std::make_shared<Mesh>(traced), {}, {});
    if (!solid || !solid->sheets) continue;
    SCOPED_TRACE(file.name);
    ++seen;
    const Fractured made = fracture_solid(std::move(*solid), uniform(20, kSeed));
    expect_sheets_once(made, traced, sized(500, 10'000));
    if (HasFailure() || (short_tests() && seen >= 12)) return;
  }
  if (seen == 0) GTEST_SKIP() << "no test mesh has sheets";
}

}  // namespace
}  // namespace fracture::test
