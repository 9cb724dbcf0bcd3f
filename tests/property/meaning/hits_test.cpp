// A local hit breaks what is within its radius, and nothing else: measured on the surface of the answers, for several meshes,
// materials and seeds.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "common/materials/materials.hpp"
#include "tests/property/changed_surface.hpp"
#include "tests/property/judge.hpp"
#include "tests/support/fractured.hpp"
#include "tests/support/full_tests.hpp"
#include "tests/support/mesh_files.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::test {
namespace {

/// The bound that the documents state, in radii.
constexpr double kStatedReach = 1.25;
constexpr std::uint32_t kSites = 16;
/// The radius in units of the longest side. In the generated meshes, no hit of this size cuts a part in two: the rest stays one piece.
constexpr double kRadius = 0.1;

Box box_of_fragment(const Fragment& f) {
  Box box;
  for (const Vec3f& p : f.positions) box.add(to_double(p) + f.pivot);
  return box;
}

double distance(const Box& box, const Vec3d& p) {
  Vec3d beyond;
  for (int a = 0; a < 3; ++a) beyond[a] = std::max({box.min[a] - p[a], p[a] - box.max[a], 0.0});
  return length(beyond);
}

/// Two walls, three beams next to each other, and a slab. No two of them touch. Each is thicker than the reach of a hit, or wide enough
/// that a hole does not divide it.
Mesh house() {
  std::vector<Mesh> parts{box({0, 0, 0}, {1, 1, 0.2}, 3), box({1.01, 0, 0}, {2, 1, 0.2}, 3)};
  for (int k = 0; k < 3; ++k) parts.push_back(box({k * 0.7, 1.01, 0}, {k * 0.7 + 0.6, 1.5, 1}, 2));
  parts.push_back(box({0, 1.51, 0}, {2, 1.9, 1}, 3));
  return joined(parts);
}

std::vector<NamedMesh> meshes() {
  return {{"cube", cube(4)},
          {"sphere", sphere_with(800)},
          {"torus", torus(32, 16)},
          {"beam", box({-1, -0.2, -0.2}, {1, 0.2, 0.2}, 4)},
          {"plate", thin_plate(0.05, 4)},
          {"house", house()}};
}

FractureParameters with_material(const std::string& name) {
  FractureParameters p;
  p.pivot = Pivot::kSource;
  p.rest = LocalRest::kWhole;
  if (name == "none") return p;
  const MaterialPreset& preset = *find_material_preset(name);
  p.pattern = preset.pattern;
  p.lloyd = preset.lloyd;
  p.anisotropy = {.stretch = preset.stretch, .grain = preset.grain};
  p.roughness = preset.roughness;
  p.aggregation = preset.aggregation;
  p.size.min_of_mean = kLeastOfMean;
  return p;
}

/// A surface point of the mesh, and the same mesh before and after it is hit there.
struct Broken {
  LocalImpact hit;
  Fractured before, after;
};

Broken broken(const Mesh& mesh, const std::string& material, std::uint64_t seed) {
  FractureParameters p = with_material(material);
  p.seed = seed;
  const std::size_t n = mesh.positions.size();
  const Vec3d at = to_double(mesh.positions[(seed * n / 3 + n / 5) % n]);
  Box box;
  for (const Vec3f& v : mesh.positions) box.add(to_double(v));
  FractureParameters one = p;  // one cell: each part is one piece
  one.pattern = PointsPattern{{box.center()}};
  one.anisotropy = {};
  one.aggregation = {};
  one.lloyd = 0;
  one.size = {};
  one.parts = Parts::kApart;
  p.hits = {{at, kRadius * box.longest_side(), kSites}};
  return {p.hits[0], fracture_mesh(mesh, one), fracture_mesh(mesh, p)};
}

/// Fragments that are new, and lie in the stated reach.
std::size_t new_pieces_inside(const Broken& b) {
  return static_cast<std::size_t>(
      std::count_if(b.after.set.fragments.begin(), b.after.set.fragments.end(), [&](const Fragment& f) {
        return std::none_of(b.before.set.fragments.begin(), b.before.set.fragments.end(),
                            [&](const Fragment& was) { return was.id == f.id; }) &&
               std::all_of(f.positions.begin(), f.positions.end(), [&](const Vec3f& p) {
                 return length(to_double(p) + f.pivot - b.hit.point) <= kStatedReach * b.hit.radius;
               });
      }));
}

/// A part that the ball does not touch has the same bits. Returns the number of such parts.
std::size_t expect_untouched_parts_whole(const Broken& b) {
  std::size_t untouched = 0;
  std::map<std::uint64_t, const Fragment*> after;
  for (const Fragment& f : b.after.set.fragments) after[f.id] = &f;
  for (const Fragment& f : b.before.set.fragments) {
    if (distance(box_of_fragment(f), b.hit.point) <= b.hit.radius) continue;
    ++untouched;
    SCOPED_TRACE("part " + std::to_string(f.part));
    const auto at = after.find(f.id);
    if (at == after.end()) {
      ADD_FAILURE() << "it is gone";
      continue;
    }
    EXPECT_EQ(at->second->positions, f.positions);
    EXPECT_EQ(at->second->indices, f.indices);
    EXPECT_EQ(at->second->attributes.normals, f.attributes.normals);
    EXPECT_EQ(at->second->mass.volume, f.mass.volume);
  }
  return untouched;
}

TEST(MeaningOfHits, TheRadiusBoundsWhichSurfaceBreaks) {
  std::size_t turn = 0, untouched = 0;
  for (const NamedMesh& shape : meshes())
    for (const char* material : {"none", "stone", "wood", "glass"})
      for (const std::uint64_t seed : {1u, 2u, 3u}) {
        if (!has_turn(turn++, 0, 7)) continue;
        SCOPED_TRACE(shape.name + ", material " + material + ", seed " + std::to_string(seed));
        const Mesh mesh = with_traced_triangles(shape.mesh);
        const Broken b = broken(mesh, material, seed);
        const ChangedSurface surface =
            changed_surface(b.before.set, b.after.set, mesh, b.hit.point, 12, seed);
        EXPECT_EQ(surface.uncovered, 0u) << "of " << surface.points;
        EXPECT_LE(surface.farthest, kStatedReach * b.hit.radius);
        EXPECT_LE(farthest_new_vertex(b.before.set, b.after.set, b.hit.point, /*outside=*/true),
                  kStatedReach * b.hit.radius);
        EXPECT_GE(new_pieces_inside(b), std::string(material) == "none" ? kSites / 2 : 1u);
        untouched += expect_untouched_parts_whole(b);
      }
  EXPECT_GT(untouched, 0u) << "no part was out of reach, so that was not tested";
}

// Thin parts of real meshes may fall off, but then their surface has no new vertices.
TEST(MeaningOfHits, TheRadiusBoundsWhatIsCutInRealMeshes) {
  std::size_t compared = 0, turn = 0;
  for (const char* name : {"suzanne.obj", "spot.obj", "torus.obj", "hammer.obj", "penguin.obj",
                           "kk_barrel_large.glb", "kk_chest.glb"}) {
    const auto file = find_test_mesh(name);
    if (!file) continue;
    const auto mesh = load_mesh(*file);
    if (!mesh) continue;
    for (const char* material : {"none", "stone", "wood", "glass"})
      for (const std::uint64_t seed : {1u, 2u, 3u}) {
        if (!full_tests() && (turn++ % (short_tests() ? 12 : 4) != 0)) continue;
        SCOPED_TRACE(std::string(name) + ", material " + material + ", seed " + std::to_string(seed));
        const Broken b = broken(*mesh, material, seed);
        EXPECT_LE(farthest_new_vertex(b.before.set, b.after.set, b.hit.point, /*outside=*/true),
                  kStatedReach * b.hit.radius);
        EXPECT_GE(new_pieces_inside(b), 1u);
        expect_untouched_parts_whole(b);
        ++compared;
      }
  }
  if (compared == 0) GTEST_SKIP() << "the meshes are absent";
}

}  // namespace
}  // namespace fracture::test
