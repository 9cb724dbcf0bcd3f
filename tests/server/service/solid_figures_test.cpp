// Figures of a solid that several estimates share. They have the same values as if each estimate computed them, and are computed once.
#include "server/service/solid_figures.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "common/contacts/contacts.hpp"
#include "common/pipeline/part_sets.hpp"
#include "server/service/admission.hpp"
#include "server/service/estimate.hpp"
#include "tests/support/polls.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/solids.hpp"

namespace fracture::test {
namespace {

/// A slab, and n * n cubes above it some of them close together.
Mesh slab_with_cubes(int n) {
  std::vector<Mesh> parts{box({-2, -1, -2}, {2, 0, 2})};
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const Vec3d low{-0.5 + (j % 3 == 0 ? 0.1001 : 0.13) * i, 0.01, -0.5 + 0.13 * j};
      parts.push_back(box(low, low + Vec3d{0.1, 0.1 + 0.01 * i, 0.1}));
    }
  return joined(parts);
}

/// The number of cells that meet a part, each step in the order of the definition (cell_means.hpp).
double cells_at(const Part& part, const Vec3d& whole_sides, double volume, double cell) {
  const Vec3d box = part.box.size();
  const double whole = box.x * box.y * box.z;
  const Vec3d sides = std::cbrt(whole > 0 ? std::fmin(1, part.volume / whole) : 1) * whole_sides;
  return cells_meeting(sides, volume, CellSize(cell));
}

SmallParts small_parts_one_by_one(const LocalImpact& hit, const Solid& solid, double space) {
  SmallParts small;
  std::size_t larger = 0;
  for (const Part& part : solid.parts) {
    Vec3d sides, beyond;
    for (int a = 0; a < 3; ++a) {
      sides[a] = std::fmin(part.box.max[a], hit.point[a] + hit.radius) -
                 std::fmax(part.box.min[a], hit.point[a] - hit.radius);
      beyond[a] = std::fmax(0, std::fmax(part.box.min[a] - hit.point[a], hit.point[a] - part.box.max[a]));
    }
    const Vec3d box = part.box.size();
    if (length(beyond) > hit.radius) continue;
    const double inside = part.volume * (sides.x / box.x) * (sides.y / box.y) * (sides.z / box.z);
    if (inside > 0.25 * space) {
      ++larger;
      continue;
    }
    ++small.count;
    small.volume += inside;
    small.pieces +=
        std::fmin(1.0 + hit.sites, 1 + 0.7 * (cells_at(part, sides, inside, space / hit.sites) - 1));
  }
  small.are_all = small.count > 0 && larger == 0;
  return small;
}

TEST(SolidFigures, SmallPartsAreThoseOfEachHitBitForBit) {
  const Solid solid = solid_of(slab_with_cubes(9));
  const SolidFigures figures(solid);
  const std::vector<LocalImpact> hits{{{0, 0.1, 0}, 0.3, 30},  {{0, 0.1, 0}, 0.3, 29},
                                      {{0, 0.1, 0}, 0.31, 30}, {{0, 0.1, 0.1}, 0.3, 5},
                                      {{9, 9, 9}, 1, 30},      {{0, 0.1, 0}, 99, 200}};
  for (int time = 0; time < 2; ++time)  // computed, and then remembered
    for (const LocalImpact& hit : hits)
      for (const double space : {0.05, 0.0005}) {
        const SmallParts one = small_parts_one_by_one(hit, solid, space),
                         shared = figures.small_parts(hit, space);
        EXPECT_EQ(shared.count, one.count);
        EXPECT_EQ(shared.volume, one.volume);
        EXPECT_EQ(shared.pieces, one.pieces);
        EXPECT_EQ(shared.are_all, one.are_all);
      }
}

TEST(SolidFigures, LoosePartsAreThoseOfEachCellBitForBit) {
  Solid solid = solid_of(slab_with_cubes(9));
  keep_contacts(solid, {}, {});
  const SolidFigures figures(solid);
  std::vector<bool> touches(solid.parts.size(), false);
  for (const Contact& contact : solid.contacts->contacts) touches[contact.a] = touches[contact.b] = true;
  for (int time = 0; time < 2; ++time)
    for (const double cell : {1.0, 0.005, 0.004, 1e-9})
      for (const bool apart : {false, true}) {
        LooseParts one;
        for (std::size_t p = 0; p < solid.parts.size(); ++p) {
          const Part& part = solid.parts[p];
          if ((!apart && touches[p]) || part.volume > 0.25 * cell) continue;
          ++one.count;
          one.pieces += cells_at(part, part.box.size(), part.volume, cell);
        }
        const LooseParts shared = figures.loose_parts(cell, apart);
        EXPECT_EQ(shared.count, one.count);
        EXPECT_EQ(shared.pieces, one.pieces);
      }
}

TEST(SolidFigures, EstimatesThatShareThemAreTheSame) {
  const Solid solid = solid_of(slab_with_cubes(6));
  const SolidFigures figures(solid);
  RequestParameters asked;
  for (int k = 0; k < 12; ++k) asked.fracture.hits.push_back({{0.05 * k, 0.1, 0}, 0.3, 30});
  for (const std::uint32_t sites : {30u, 2000u, 30u})
    for (const LocalRest rest : {LocalRest::kWhole, LocalRest::kFractured}) {
      asked.fracture.sites = sites;
      asked.fracture.rest = rest;
      for (const std::uint64_t limit : {1ull << 20, 1ull << 34})
        EXPECT_EQ(estimate_document(asked, figures, limit), estimate_document(asked, solid, limit));
      const ExpectedWork shared = expected_work(asked.fracture, 0, &solid, 0, {}, &figures),
                         own = expected_work(asked.fracture, 0, &solid);
      EXPECT_EQ(shared.seconds, own.seconds);
      EXPECT_EQ(shared.bytes, own.bytes);
    }
}

// Each evaluation looked at each pair of a part and a hit, and a search for the largest count makes dozens of evaluations.
TEST(SolidFigures, PartsAreLookedAtOnceForEachHit) {
  const Solid solid = solid_of(slab_with_cubes(20));
  FractureParameters parameters;
  parameters.rest = LocalRest::kFractured;
  for (int k = 0; k < 64; ++k) parameters.hits.push_back({{0.01 * k, 0.1, 0}, 0.3, 30});
  Polls polls;  // after every 8192 steps
  const SolidFigures figures(solid, polls.execution);
  expected_working_bytes(parameters, figures);
  const int first = polls.count;
  EXPECT_GE(first, 3) << "25,664 pairs";
  for (int k = 0; k < 10; ++k) expected_working_bytes(parameters, figures);
  EXPECT_LE(polls.count, first + 10) << "each further evaluation takes less than 8192 steps";
}

TEST(SolidFigures, AnEstimateCanBeStopped) {
  const Solid solid = solid_of(slab_with_cubes(20));
  RequestParameters asked;
  for (int k = 0; k < 64; ++k) asked.fracture.hits.push_back({{0.01 * k, 0.1, 0}, 0.3, 30});
  Polls polls;
  polls.stop.request_stop();
  EXPECT_THROW(estimate_document(asked, {solid, polls.execution}, 1u << 30), Interrupted);
}

// The entries share one copy of the parameters. The numbers are those of a copy for each entry.
TEST(SolidFigures, EntriesOfAssignCountAsBefore) {
  const Solid solid = solid_of(cube(4));
  FractureParameters parameters;
  parameters.sites = 40;
  parameters.hits = {{{0, 0.5, 0}, 0.2, 10}};
  parameters.rest = LocalRest::kFractured;
  const auto add = [&](const auto& change) {
    FractureParameters breaks;
    change(breaks);
    parameters.assigned.push_back({.breaks = std::make_shared<const FractureParameters>(std::move(breaks))});
  };
  add([](FractureParameters& p) { p.aggregation.cells = 3; });
  add([](FractureParameters& p) { p.pattern = PointsPattern{{{0, 0, 0}, {0.1, 0, 0}}}; });
  add([](FractureParameters& p) { p.roughness = {0.03, 5, 2}; });
  add([](FractureParameters& p) { p.pattern = GridPattern{}; });
  add([](FractureParameters&) {});
  double sites = 0, rough = 0;
  for (std::uint32_t k = 0; k <= parameters.assigned.size(); ++k) {
    const FractureParameters one =
        parameters_of_entry(parameters, k < parameters.assigned.size() ? k : kNoIndex);
    sites = std::fmax(sites, expected_sites(one, &solid));
    rough = std::fmax(rough, expected_rough_triangles(one, 40));
  }
  EXPECT_EQ(expected_sites(parameters, &solid), sites);
  EXPECT_EQ(sites, 3 * (40 + 10)) << "of the aggregates";
  EXPECT_EQ(expected_rough_triangles(parameters, 40), rough);
  EXPECT_GT(rough, 0);
}

}  // namespace
}  // namespace fracture::test
