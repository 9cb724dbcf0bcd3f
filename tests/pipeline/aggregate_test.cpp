// Fragments of several cells: their sizes and number are as requested, each is in one piece, they are small
// where the pattern makes small cells, and they have few hulls, which lie inside them.
#include "common/pipeline/aggregate.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <set>

#include "common/pipeline/fragment_sizes.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/fractured.hpp"
#include "tests/support/full_tests.hpp"
#include "tests/support/mesh_files.hpp"
#include "tests/support/pattern_requests.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::test {
namespace {

/// The parameters that a request makes from the preset.
FractureParameters material(const char* name, std::uint32_t fragments, std::uint64_t seed = 1) {
  FractureParameters p = of_material(*find_material_preset(name), fragments, seed);
  p.roughness = {};
  p.size.min_of_mean = kLeastOfMean;
  p.size.fragments = fragments;
  p.hulls = Hulls::kConvex;
  return p;
}

std::vector<double> volumes_of(const FragmentSet& set) {
  std::vector<double> all;
  for (const Fragment& f : set.fragments) all.push_back(f.mass.volume);
  std::sort(all.begin(), all.end());
  return all;
}

/// Kolmogorov's distance of volumes (ascending) from Weibull's distribution with the same mean and the shape
/// 1 / spread.
double distance_from_weibull(const std::vector<double>& volumes, double spread) {
  double mean = 0;
  for (const double v : volumes) mean += v / static_cast<double>(volumes.size());
  const double scale = mean / std::tgamma(1 + spread);
  double most = 0;
  for (std::size_t k = 0; k < volumes.size(); ++k) {
    const double below = 1 - std::exp(-std::pow(volumes[k] / scale, 1 / spread));
    const auto n = static_cast<double>(volumes.size());
    most = std::max({most, std::fabs(below - static_cast<double>(k) / n),
                     std::fabs(below - static_cast<double>(k + 1) / n)});
  }
  return most;
}

TEST(FragmentSizes, AreQuantilesOfWeibullsDistribution) {
  Pacer pacer(kUninterrupted);
  for (const double spread : {0.05, 0.3, 0.7, 1.0, 1.6, 2.0}) {
    const std::vector<double> sizes = fragment_sizes(400, spread, pacer);
    ASSERT_TRUE(std::is_sorted(sizes.begin(), sizes.end()));
    double sum = 0;
    for (const double s : sizes) sum += s;
    EXPECT_NEAR(sum, 1, 1e-12);
    // Half a step, plus the difference between their mean and that of the distribution.
    EXPECT_LT(distance_from_weibull(sizes, spread), 0.5 / 400 + 0.005) << spread;
  }
  for (const double s : fragment_sizes(7, 0, pacer)) EXPECT_NEAR(s, 1.0 / 7, 1e-15);
  EXPECT_EQ(fragment_sizes(1, 1, pacer), std::vector<double>{1});
}

std::vector<NamedMesh> things() {
  std::vector<NamedMesh> all{{"box", box({0, 0, 0}, {2, 1, 0.7}, 6)},
                             {"torus", torus(32, 16)},
                             {"sphere", sphere_with(2000)},
                             {"plate", box({0, 0, 0}, {2, 2, 0.2}, 4)}};
  for (const char* name : {"suzanne.obj", "kk_column.glb", "kk_wall.glb"})
    if (const auto file = find_test_mesh(name))
      if (Expected<Mesh> mesh = load_mesh(*file)) all.push_back({name, std::move(*mesh)});
  return all;
}

TEST(Aggregates, HaveTheSizesOfTheDistribution) {
  std::size_t input = 0;
  for (const NamedMesh& thing : things()) {
    ++input;
    std::size_t turn = 0;
    for (const char* name : {"stone", "concrete"})
      for (const std::uint32_t fragments : {300u, 500u}) {
        if (!has_turn(input, turn++, 4)) continue;
        SCOPED_TRACE(thing.name + " of " + name + ", " + std::to_string(fragments));
        const FractureParameters p = material(name, fragments, fragments + 7);
        const Fractured b = fracture_mesh(thing.mesh, p);
        const std::vector<double> volumes = volumes_of(b.set);
        EXPECT_GE(volumes.size(), 0.9 * fragments);
        EXPECT_LE(volumes.size(), 1.1 * fragments);
        const double distance = distance_from_weibull(volumes, p.aggregation.spread);
        RecordProperty(thing.name + "_" + name + "_" + std::to_string(fragments), std::to_string(distance));
        if (std::getenv("FRACTURE_TEST_TELL"))
          std::printf("%s %s %u: %zu fragments, distance %.3f\n", thing.name.c_str(), name, fragments,
                      volumes.size(), distance);
        EXPECT_LE(distance, 0.1);
      }
  }
}

TEST(Aggregates, AreEvenWithoutSpread) {
  FractureParameters p = material("stone", 100);
  p.aggregation.spread = 0;
  const std::vector<double> volumes = volumes_of(fracture_mesh(sphere_with(2000), p).set);
  ASSERT_GE(volumes.size(), 90u);
  // A fragment has six cells, and its last cell may exceed the size by half a cell.
  EXPECT_GT(volumes[volumes.size() / 10], 0.6 * volumes[volumes.size() / 2]);
  EXPECT_LT(volumes[volumes.size() * 9 / 10], 1.5 * volumes[volumes.size() / 2]);
}

TEST(Aggregates, AreAsManyAsAskedAndInOnePiece) {
  std::size_t input = 0;
  for (const NamedMesh& thing : things()) {
    ++input;
    std::size_t turn = 0;
    for (const std::uint32_t fragments : {1u, 2u, 10u, 50u}) {
      if (!has_turn(input, turn++, 4)) continue;
      SCOPED_TRACE(thing.name + ", " + std::to_string(fragments));
      FractureParameters p = material("stone", fragments);
      p.size = {};
      const Fractured b = fracture_mesh(thing.mesh, p);
      const Certificate& c = b.set.certificate;
      EXPECT_GE(c.cells, fragments);
      // Groups grow across caps. So only cells that were in several pieces themselves can make islands.
      FractureParameters alone = p;
      alone.sites = fragments * p.aggregation.cells;
      alone.aggregation = {};
      EXPECT_LE(c.islands, fracture_mesh(thing.mesh, alone).set.certificate.islands);
      std::set<SiteId> sites;
      for (const Fragment& f : b.set.fragments) sites.insert(f.sites.begin(), f.sites.end());
      EXPECT_GE(sites.size(), std::min<std::size_t>(fragments * 5, b.diagram.sites.size() / 2));
    }
  }
}

TEST(Aggregates, AreTheSameForAnyNumberOfThreads) {
  for (const char* name : {"stone", "concrete"}) {
    const FractureParameters p = material(name, 60);
    const Fractured one = fracture_mesh(torus(32, 16), p), three = fracture_mesh(torus(32, 16), p, 3);
    ASSERT_EQ(one.set.fragments.size(), three.set.fragments.size());
    for (std::size_t k = 0; k < one.set.fragments.size(); ++k) {
      const Fragment &a = one.set.fragments[k], &b = three.set.fragments[k];
      EXPECT_EQ(a.id, b.id);
      EXPECT_EQ(a.positions, b.positions);
      EXPECT_EQ(a.indices, b.indices);
      const auto hulls_a = one.hulls.of(k), hulls_b = three.hulls.of(k);
      ASSERT_EQ(hulls_a.size(), hulls_b.size());
      for (std::size_t h = 0; h < hulls_a.size(); ++h) {
        EXPECT_EQ(hulls_a[h].points, hulls_b[h].points);
        EXPECT_EQ(hulls_a[h].triangles, hulls_b[h].triangles);
      }
    }
  }
}

TEST(Aggregates, KeepToTheLargestVolume) {
  FractureParameters p = material("stone", 20);
  p.size = {};
  const Mesh mesh = sphere_with(2000);
  p.max_volume = 0.02 * volume_of(mesh);
  const Fractured b = fracture_mesh(mesh, p);
  EXPECT_LE(volumes_of(b.set).back(), p.max_volume);
  p.hits = {{.point = {1, 0, 0}, .radius = 0.3, .sites = 10}};
  p.rest = LocalRest::kFractured;
  EXPECT_LE(volumes_of(fracture_mesh(mesh, p).set).back(), p.max_volume);
}

TEST(Aggregates, AreSmallNearAnImpactAndLongOnTheWayOut) {
  FractureParameters p = material("stone", 120);
  const Mesh mesh = box({-1, -1, -1}, {1, 1, 1}, 4);
  const Vec3d impact{0, 0, 1};
  p.pattern = ImpactPattern{.impacts = {impact}};
  const Fractured b = fracture_mesh(mesh, p);
  std::vector<double> near, far;
  double along = 0, across = 0;
  for (const Fragment& f : b.set.fragments) {
    const Vec3d from = f.mass.center_of_mass - impact;
    (length(from) < 0.5 ? near : far).push_back(f.mass.volume);
    if (f.sites.size() < 4) continue;
    // Second moments of the sites about their middle: away from the impact, and across that direction.
    Vec3d middle;
    for (const SiteId s : f.sites)
      middle = middle + (1.0 / static_cast<double>(f.sites.size())) * b.diagram.tetrahedralization.points[s];
    const Vec3d out = (1 / length(middle - impact)) * (middle - impact);
    for (const SiteId s : f.sites) {
      const Vec3d to = b.diagram.tetrahedralization.points[s] - middle;
      const double scale = std::cbrt(f.mass.volume * f.mass.volume);
      along += dot(to, out) * dot(to, out) / scale;
      across += 0.5 * (dot(to, to) - dot(to, out) * dot(to, out)) / scale;
    }
  }
  ASSERT_GT(near.size(), 10u);
  ASSERT_GT(far.size(), 10u);
  std::sort(near.begin(), near.end());
  std::sort(far.begin(), far.end());
  EXPECT_LT(3 * near[near.size() / 2], far[far.size() / 2]);
  EXPECT_GT(along, 1.5 * across);
}

TEST(AggregateHulls, AreFewAndLieWithinTheCellsOfTheirFragment) {
  std::size_t input = 0;
  for (const NamedMesh& thing : things()) {
    ++input;
    std::size_t turn = 0;
    for (const double stretch : {1.0, 3.0}) {
      if (!has_turn(input, turn++, 2)) continue;
      SCOPED_TRACE(thing.name + ", stretch " + std::to_string(stretch));
      FractureParameters p = material("stone", 50);
      p.anisotropy.stretch = stretch;
      const Fractured b = fracture_mesh(thing.mesh, p);
      const auto& sites = b.diagram.tetrahedralization.points;
      const CellMap& map = b.diagram.map;
      double filled = 0, all = 0;
      for (std::size_t k = 0; k < b.set.fragments.size(); ++k) {
        const Fragment& f = b.set.fragments[k];
        const auto hulls = b.hulls.of(k);
        EXPECT_GE(hulls.size(), 1u);
        EXPECT_LE(hulls.size(), 4u);
        all += f.mass.volume;
        for (const CollisionHull& hull : hulls) {
          EXPECT_LE(hull.points.size(), kMaxHullPoints);
          Mesh mesh;
          mesh.positions = hull.points;
          mesh.triangles = hull.triangles;
          EXPECT_EQ(open_directed_edges(mesh), 0u);
          filled += volume_of(mesh);
          // Corners of the hull, and points between them: none may be in a cell of another fragment.
          for (std::size_t c = 0; c < hull.points.size(); ++c)
            for (std::size_t e = c; e < hull.points.size(); e += 3) {
              const Vec3d x = 0.5 * (to_double(hull.points[c]) + to_double(hull.points[e])) + f.pivot;
              const Vec3d image = map ? map.of_part(f.part).image(x) : x;
              std::size_t nearest = 0;
              double least = HUGE_VAL;
              for (std::size_t s = 0; s + 4 < sites.size(); ++s) {
                const Vec3d to = sites[s] - image;
                if (dot(to, to) < least) {
                  least = dot(to, to);
                  nearest = s;
                }
              }
              EXPECT_TRUE(std::binary_search(f.sites.begin(), f.sites.end(), SiteId{nearest}));
            }
        }
      }
      if (std::getenv("FRACTURE_TEST_TELL"))
        std::printf("%s: hulls %u, volume %.2f of the fragments'\n", thing.name.c_str(),
                    b.report.hulls->hulls, filled / all);
      EXPECT_GT(filled, 0.6 * all);
    }
  }
}

TEST(AggregateHulls, LeaveARestThatStaysWholeItsShape) {
  FractureParameters p = material("stone", 60);
  p.size = {};
  p.hits = {{.point = {1.4, 0, 0}, .radius = 0.3, .sites = 10}};
  const Fractured b = fracture_mesh(torus(32, 16), p);
  const auto& fragments = b.set.fragments;
  const auto rest =
      std::max_element(fragments.begin(), fragments.end(),
                       [](const Fragment& x, const Fragment& y) { return x.mass.volume < y.mass.volume; });
  ASSERT_GT(rest->mass.volume, 0.9 * b.solid.report.volume);
  EXPECT_GT(b.hulls.of(static_cast<std::size_t>(rest - fragments.begin())).size(), 20u);
}

TEST(AggregatesAfterHits, StayWhatTheyWereWhereNothingWasHit) {
  FractureParameters p = material("stone", 100);
  p.size = {};
  const Mesh mesh = torus(32, 16);
  const Fractured before = fracture_mesh(mesh, p);
  const Vec3d point{1.4, 0, 0};
  p.hits = {{.point = point, .radius = 0.2, .sites = 12}};
  p.rest = LocalRest::kFractured;
  const Fractured after = fracture_mesh(mesh, p);
  std::map<std::uint64_t, const Fragment*> by_id;
  for (const Fragment& f : after.set.fragments) by_id[f.id] = &f;
  std::size_t far = 0;
  for (const Fragment& f : before.set.fragments) {
    double nearest = HUGE_VAL;
    for (const Vec3f& q : f.positions) nearest = std::min(nearest, length(to_double(q) + f.pivot - point));
    if (nearest < 0.7) continue;
    ++far;
    ASSERT_TRUE(by_id.contains(f.id));
    EXPECT_EQ(by_id[f.id]->positions, f.positions);
    EXPECT_EQ(by_id[f.id]->indices, f.indices);
  }
  EXPECT_GT(far, 50u);
  // The fragments that the hit broke off also have several cells.
  std::size_t fragments_of_hit = 0;
  const auto existed = [&](std::uint64_t id) {
    return std::any_of(before.set.fragments.begin(), before.set.fragments.end(),
                       [&](const Fragment& f) { return f.id == id; });
  };
  for (const Fragment& f : after.set.fragments) fragments_of_hit += !existed(f.id) && f.bodies.size() > 1;
  EXPECT_GE(fragments_of_hit, 6u);
}

}  // namespace
}  // namespace fracture::test
