// Materials with more than a pattern: torn sheets, vessels, ice that was hit, slabs, prisms.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "common/hollow/hollow.hpp"
#include "tests/pipeline/looks.hpp"
#include "tests/support/full_tests.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::test {
namespace {

/// A closed shape, hollowed out as the material specifies.
Solid vessel(const Mesh& mesh, const char* name) {
  const MaterialPreset& preset = *find_material_preset(name);
  return hollowed(solid_of(mesh), {.fraction = preset.shell_fraction, .least_ball = kLeastBall}, {});
}

/// Mean of outline² / area over the pieces of a plate, weighted by area: 16 for a square, about 20 for a
/// Voronoi cell.
double raggedness(const char* name, std::uint64_t seed) {
  constexpr double kThick = 0.01;
  double sum = 0, all = 0;
  for (const Fragment& f :
       fractured(box({0, 0, 0}, {2, 1.5, kThick}, 4), material(name, 40, seed)).set.fragments) {
    const double outline = (f.mass.area - f.exterior_area) / kThick, area = f.mass.volume / kThick;
    sum += outline * outline;
    all += area;
  }
  return sum / all;
}

TEST(MetalLooks, EdgesOfTornSheetsRunBackAndForth) {
  for (std::uint64_t seed = 1; seed <= sized(1u, 3u); ++seed) {
    SCOPED_TRACE(seed);
    EXPECT_GE(raggedness("metal", seed), 1.5 * raggedness("cast_iron", seed));
  }
}

TEST(MetalLooks, LargePlatesHoldMostOfALump) {
  for (std::uint64_t seed = 1; seed <= sized(1u, 3u); ++seed) {
    const FragmentSet set = fractured(ico_sphere(4), material("metal", 40, seed)).set;
    EXPECT_GE(share_of_largest(set, 0.25), 0.5) << seed;
  }
}

TEST(Vessels, OfGlassPotteryAndSheetMetalAreWallsAndLumpsOfOthersAreNot) {
  for (const MaterialPreset& preset : material_presets()) {
    SCOPED_TRACE(preset.name);
    const std::string name = preset.name;
    const bool walls = name == "glass" || name == "ceramic" || name == "terracotta" || name == "metal";
    EXPECT_EQ(preset.shell_fraction > 0, walls);
    if (!walls) continue;
    const Solid ball = vessel(ico_sphere(4), preset.name);
    EXPECT_EQ(ball.report.parts_hollowed, 1u);
    // The sphere has a surface of four pi square metres. The wall is at least this share of two metres thick,
    // and exceeds it only as far as the triangles of the inner side require.
    const double mean = ball.parts.at(0).volume / (4 * M_PI), asked = 2 * preset.shell_fraction;
    EXPECT_GT(mean, 0.9 * asked - asked * asked);
    EXPECT_LT(mean, asked + 0.08);
    EXPECT_EQ(vessel(box({0, 0, 0}, {3, 2, 0.1}, 3), preset.name).report.parts_hollowed, 0u) << "a pane";
  }
}

/// A table top, and four legs whose thickness is at least a fifth of their length.
Mesh glass_table() {
  std::vector<Mesh> parts{box({0, 1, 0}, {3, 1.05, 2}, 4)};
  for (const double x : {0.1, 2.7})
    for (const double z : {0.1, 1.7}) parts.push_back(box({x, 0, z}, {x + 0.2, 0.99, z + 0.2}, 4));
  return joined(parts);
}

TEST(GlassLooks, AHitOnALegBreaksTheLegAlone) {
  const Solid table = solid_of(glass_table());
  FractureParameters p = material("glass", 80);
  p.roughness = {};
  const auto pieces_of_the_leg = [&](const FragmentSet& set) {
    std::size_t count = 0;
    for (const Fragment& f : set.fragments) {
      Box bounds;
      for (std::uint32_t v = 0; v < f.positions.size(); ++v) bounds.add(world(f, v));
      count += bounds.max.y < 1 && bounds.max.x < 0.4 && bounds.max.z < 0.4;
    }
    return count;
  };
  const FragmentSet before = fractured(table, p).set;
  p.rest = LocalRest::kFractured;
  p.hits = {{.point = {0.2, 0.5, 0.3}, .radius = 0.12, .sites = 20}};
  const FragmentSet after = fractured(table, p).set;
  EXPECT_GE(pieces_of_the_leg(after), pieces_of_the_leg(before) + 5);
  EXPECT_EQ(after.fragments.size() - pieces_of_the_leg(after),
            before.fragments.size() - pieces_of_the_leg(before));
}

TEST(GlassLooks, BarycentricCellsOfSeveralPartsAreThoseOfOne) {
  FractureParameters p = material("glass", 40);
  p.roughness = {};
  p.dual = Dual::kBarycenter;
  EXPECT_GT(fractured(glass_table(), p).set.fragments.size(), 5u);
}

TEST(GlassLooks, LegsOfATableBreakAcrossAndItsTopAsAPane) {
  const Solid table = solid_of(glass_table());
  for (std::uint64_t seed = 1; seed <= sized(1u, 3u); ++seed) {
    SCOPED_TRACE(seed);
    FractureParameters p = material("glass", 80, seed);
    std::get<RadialPattern>(p.pattern).impacts = {{1, 1.05, 0.8}};
    double legs = 0, across = 0, top = 0, upright = 0;
    for_each_cut(fractured(table, p).set, [&](const Vec3d& a, const Vec3d& b, const Vec3d& c) {
      const Vec3d n = cross(b - a, c - a);
      const bool steep = std::fabs(n.y) > std::cos(45 * M_PI / 180) * length(n);
      const bool of_top = a.y + b.y + c.y > 3;
      (of_top ? top : legs) += length(n);
      if (of_top ? !steep : steep) (of_top ? upright : across) += length(n);
    });
    EXPECT_GE(across, 0.8 * legs);
    EXPECT_GE(upright, 0.8 * top);
    EXPECT_GT(legs, 0);
  }
}

TEST(GlassLooks, ShardsOfAVesselRunAwayFromTheHit) {
  const Vec3d hit{0, 0, 1};
  for (std::uint64_t seed = 1; seed <= sized(1u, 3u); ++seed) {
    FractureParameters p = material("glass", 60, seed);
    std::get<RadialPattern>(p.pattern).impacts = {hit};
    const FragmentSet set = fractured(vessel(ico_sphere(4), "glass"), p).set;
    // Cracks that run away from the hit lie in planes through it. These are most of the cuts; the others are
    // rings around the hit.
    double all = 0, through = 0;
    for_each_cut(set, [&](const Vec3d& a, const Vec3d& b, const Vec3d& c) {
      const Vec3d n = cross(b - a, c - a), from_hit = (1.0 / 3) * (a + b + c) - hit;
      all += length(n);
      if (std::fabs(dot(n, from_hit)) < std::sin(30 * M_PI / 180) * length(n) * length(from_hit))
        through += length(n);
    });
    EXPECT_GE(through, 0.5 * all) << seed;
  }
}

/// The median volume of the fragments nearer to the point than `near`, and of the others.
std::pair<double, double> near_and_far(const FragmentSet& set, const Vec3d& point, double near) {
  std::vector<double> inside, outside;
  for (const Fragment& f : set.fragments)
    (length(f.mass.center_of_mass - point) < near ? inside : outside).push_back(f.mass.volume);
  if (inside.size() < 5 || outside.size() < 5)
    throw std::runtime_error("too few fragments near the hit, or far");
  return {median(inside), median(outside)};
}

TEST(IceLooks, AroundACrushedZoneLieLargeBlocks) {
  const Vec3d hit{0, 0, 0.5};
  for (std::uint64_t seed = 1; seed <= sized(1u, 3u); ++seed) {
    FractureParameters p = material("ice", 60, seed);
    std::get<ImpactPattern>(p.pattern).impacts = {hit};
    const FragmentSet set = fractured(cube(4), p).set;
    const auto [near, far] = near_and_far(set, hit, 0.25);
    EXPECT_LE(10 * near, far) << seed;
    EXPECT_GE(share_of_largest(set, 0.25), 0.6) << seed;
  }
}

TEST(CeramicLooks, ShardsAreSmallerWhereItWasHit) {
  const Vec3d hit{0, 0, 1};
  for (const char* name : {"ceramic", "terracotta"})
    for (std::uint64_t seed = 1; seed <= sized(1u, 3u); ++seed) {
      SCOPED_TRACE(name);
      FractureParameters p = material(name, 60, seed);
      std::get<ImpactPattern>(p.pattern).impacts = {hit};
      const auto [near, far] = near_and_far(fractured(vessel(ico_sphere(4), name), p).set, hit, 0.4);
      EXPECT_LE(3 * near, far) << seed;
    }
}

TEST(PlasterLooks, CrumblingLumpsLieBetweenLargePieces) {
  for (std::uint64_t seed = 1; seed <= sized(1u, 3u); ++seed)
    for (const Mesh& mesh : {cube(4), sphere_with(2000)}) {
      const FragmentSet set = fractured(mesh, material("plaster", 100, seed)).set;
      EXPECT_GE(share_of_largest(set, 0.1), 0.4) << seed;
      EXPECT_LE(1 - share_of_largest(set, 0.5), 0.1) << seed;
    }
}

/// The median extent along y and across it.
std::pair<double, double> along_and_across(const FragmentSet& set) {
  std::vector<double> along, across;
  for (const Fragment& f : set.fragments) {
    const Vec3d s = extent_of(f);
    along.push_back(s.y);
    across.push_back(s.x);
    across.push_back(s.z);
  }
  return {median(along), median(across)};
}

TEST(SandstoneLooks, SlabsLieAlongTheBedding) {
  for (std::uint64_t seed = 1; seed <= sized(1u, 3u); ++seed) {
    FractureParameters p = material("sandstone", 100, seed);
    p.anisotropy.grain = find_material_preset("sandstone")->grain;
    const auto [along, across] = along_and_across(fractured(cube(4), p).set);
    EXPECT_LE(along, 0.7 * across) << seed;
  }
}

TEST(CrystalLooks, PrismsStandUpright) {
  for (std::uint64_t seed = 1; seed <= sized(1u, 3u); ++seed) {
    FractureParameters p = material("crystal", 100, seed);
    p.anisotropy.grain = find_material_preset("crystal")->grain;
    const auto [along, across] = along_and_across(fractured(cube(4), p).set);
    EXPECT_GE(along, 1.7 * across) << seed;
  }
}

}  // namespace
}  // namespace fracture::test
