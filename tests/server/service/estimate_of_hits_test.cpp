// The estimate of answers with hits, compared with the answers that are made.
#include "server/service/estimate_of_hits.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "common/base/product.hpp"
#include "common/contacts/contacts.hpp"
#include "server/service/admission.hpp"
#include "server/service/estimate.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/solids.hpp"

namespace fracture::test {
namespace {

struct HitCase {
  const char* name;
  Mesh mesh;
  std::uint32_t sites;  ///< of the pattern; 0: the rest stays whole
  std::vector<LocalImpact> hits;
  double rough = 0;
};

RequestParameters asked_for(const HitCase& c) {
  RequestParameters asked;
  asked.fracture.sites = c.sites > 0 ? c.sites : 5000;
  asked.fracture.rest = c.sites > 0 ? LocalRest::kFractured : LocalRest::kWhole;
  asked.fracture.hits = c.hits;
  asked.fracture.roughness = {c.rough, 5, 2};
  return asked;
}

bool near_within(double expected, double made, double factor) {
  return expected <= factor * made && made <= factor * expected;
}

TEST(EstimateOfHits, CountsWhatHitsMake) {
  const LocalImpact on_top{{0, 0.5, 0}, 0.2, 30};
  const std::vector<HitCase> cases{
      {"cube, whole", cube(4), 0, {{{0, 0.5, 0}, 0.1, 20}}},
      {"cube, few fragments", cube(4), 10, {on_top}},
      {"cube", cube(4), 60, {on_top}},
      {"cube, many fragments", cube(4), 1000, {on_top}},
      {"cube, four hits at one place", cube(4), 30, {on_top, on_top, on_top, on_top}},
      {"cube, far hits", cube(4), 30, {on_top, {{0, -0.5, 0}, 0.2, 30}}},
      {"cube, rough", cube(4), 30, {on_top}, 0.03},
      {"sphere", sphere_with(5000), 300, {{{1, 0, 0}, 0.3, 30}}},
      {"plate", thin_plate(0.04, 8), 60, {{{0, 0, 0.02}, 0.2, 30}}},
  };
  for (const HitCase& c : cases) {
    SCOPED_TRACE(c.name);
    const Solid solid = solid_of(c.mesh);
    RequestParameters asked = asked_for(c);
    asked.physics = Physics::kNone;
    const ExpectedAnswer expected = expected_answer(asked, solid);
    Allowance allowance(0, UINT64_MAX, [](std::uint64_t) { return Allowance::Answer::kGranted; });
    Execution execution;
    execution.allowance = &allowance;
    StageTimings timings;
    const auto diagram = make_diagram(solid, asked.fracture, execution, timings);
    ASSERT_TRUE(diagram) << diagram.error().detail;
    const auto made = fracture(solid, *diagram, asked.fracture, execution, timings);
    ASSERT_TRUE(made) << made.error().detail;
    double triangles = 0;
    for (const Fragment& f : made->set.fragments) triangles += static_cast<double>(f.indices.size() / 3);
    const auto fragments = static_cast<double>(made->set.fragments.size()),
               bytes = static_cast<double>(allowance.most_bytes());
    if (std::getenv("FRACTURE_PRINT_ESTIMATES"))
      std::printf("%s | fragments %.0f/%.0f | triangles %.0f/%.0f | bytes %.0f/%.0f\n", c.name,
                  expected.fragments, fragments, expected.triangles, triangles, expected.working_bytes,
                  bytes);
    EXPECT_TRUE(near_within(expected.fragments, fragments, 2)) << expected.fragments << " of " << fragments;
    EXPECT_TRUE(near_within(expected.triangles, triangles, 2.5)) << expected.triangles << " of " << triangles;
    EXPECT_TRUE(near_within(expected.working_bytes, bytes, 2.5)) << expected.working_bytes << " of " << bytes;
  }
}

/// A slab with n * n cubes above it, which touch nothing.
Mesh slab_with_cubes(int n, double side, double pitch) {
  std::vector<Mesh> parts{box({-2, -1, -2}, {2, 0, 2})};
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const Vec3d low{-0.5 + pitch * i, 0.01, -0.5 + pitch * j};
      parts.push_back(box(low, low + Vec3d{side, side, side}));
    }
  return joined(parts);
}

Mesh planks() {
  std::vector<Mesh> parts;
  for (int k = 0; k < 20; ++k) parts.push_back(box({-1, 0.11 * k, 0}, {1, 0.11 * k + 0.1, 0.02}));
  return joined(parts);
}

Mesh slab_with_rods() {
  std::vector<Mesh> parts{box({-2, -1, -2}, {2, 0, 2})};
  for (int k = 0; k < 20; ++k) parts.push_back(box({-1 + 0.1 * k, 0.01, -1}, {-0.98 + 0.1 * k, 0.03, 1}));
  return joined(parts);
}

// The cells of a hit cut each part by itself. Until algorithm 27, the estimate was a third to a half of the new pieces.
TEST(EstimateOfHits, CountsThePiecesOfSmallParts) {
  struct PartsCase {
    const char* name;
    Mesh mesh;
    LocalImpact hit;
  };
  const std::vector<PartsCase> cases{
      {"cubes", slab_with_cubes(8, 0.1, 0.13), {{0, 0.1, 0}, 0.3, 30}},
      {"cubes, few cells", slab_with_cubes(8, 0.1, 0.13), {{0, 0.1, 0}, 0.3, 5}},
      {"cubes, many cells", slab_with_cubes(8, 0.1, 0.13), {{0, 0.1, 0}, 0.3, 200}},
      {"gravel", slab_with_cubes(30, 0.02, 0.025), {{-0.1, 0.03, -0.1}, 0.2, 30}},
      {"planks", planks(), {{0, 1.1, 0.02}, 0.3, 30}},
      {"rods", slab_with_rods(), {{0, 0.02, 0}, 0.4, 30}},
  };
  for (const PartsCase& c : cases) {
    SCOPED_TRACE(c.name);
    const Solid solid = solid_of(c.mesh);
    RequestParameters asked = asked_for({"", {}, 0, {c.hit}});
    asked.physics = Physics::kNone;
    const ExpectedAnswer expected = expected_answer(asked, solid);
    StageTimings timings;
    const auto diagram = make_diagram(solid, asked.fracture, {}, timings);
    ASSERT_TRUE(diagram) << diagram.error().detail;
    const auto made = fracture(solid, *diagram, asked.fracture, {}, timings);
    ASSERT_TRUE(made) << made.error().detail;
    double triangles = 0;
    for (const Fragment& f : made->set.fragments) triangles += static_cast<double>(f.indices.size() / 3);
    const auto parts = static_cast<double>(solid.parts.size());
    const double fresh = static_cast<double>(made->set.fragments.size()) - parts;
    EXPECT_TRUE(near_within(expected.fragments - parts, fresh, 2))
        << expected.fragments - parts << " of " << fresh;
    EXPECT_TRUE(near_within(expected.triangles, triangles, 2.5)) << expected.triangles << " of " << triangles;
  }
}

// Small parts that touch nothing are separate fragments, whatever number is asked for.
TEST(EstimateOfHits, LooseSmallPartsCountAsFragments) {
  Solid solid = solid_of(slab_with_cubes(8, 0.1, 0.13));
  RequestParameters asked;
  asked.fracture.sites = 50;
  const double before = expected_answer(asked, solid).fragments;
  keep_contacts(solid, {}, {});
  ASSERT_TRUE(solid.contacts->contacts.empty());
  const double loose = expected_answer(asked, solid).fragments;
  EXPECT_GE(loose, before + 64);
  EXPECT_LE(loose, before + 2 * 64) << "a cell is 300 times as large as a cube, so few cubes are cut";
  asked.fracture.size.fragments = 50;
  EXPECT_DOUBLE_EQ(expected_answer(asked, solid).fragments, 65);
}

TEST(EstimateOfHits, CountsNoPatternIfTheRestStaysWhole) {
  const Solid solid = solid_of(cube(4));
  RequestParameters asked = asked_for({"", {}, 0, {{{0, 0.5, 0}, 0.1, 20}}});
  asked.fracture.max_volume = 1e-6;
  asked.fracture.size.fragments = 5000;
  const ExpectedAnswer few = expected_answer(asked, solid);
  EXPECT_DOUBLE_EQ(few.sites, 1 + 20);
  EXPECT_DOUBLE_EQ(few.fragments, 1 + 20);
  EXPECT_DOUBLE_EQ(expected_sites(asked.fracture, &solid), 1 + 20);
  asked.fracture.rest = LocalRest::kFractured;
  EXPECT_GT(expected_answer(asked, solid).fragments, 4000);
}

TEST(EstimateOfHits, HitsAtOnePlaceMakeMoreThanHitsFarFromEachOther) {
  const Solid solid = solid_of(cube(4));
  RequestParameters near_by = asked_for({"", {}, 1, {}}), far = near_by;
  for (int k = 0; k < 20; ++k) {
    near_by.fracture.hits.push_back({{0, 0.5, 0}, 0.02, 50});
    far.fracture.hits.push_back({{-0.5 + 0.05 * k, 0.5, 0}, 0.02, 50});
  }
  const HitNumbers one_place = expected_of_hits(near_by.fracture, solid, 1, 192),
                   apart = expected_of_hits(far.fracture, solid, 1, 192);
  EXPECT_DOUBLE_EQ(apart.fragments, 20 * 50);  // no two balls meet
  EXPECT_GT(one_place.fragments, 20 * apart.fragments);
  // Only the last hit, on the pieces of the others.
  const HitNumbers last = expected_of_hits(near_by.fracture, solid, 1, 192, 19);
  EXPECT_GT(last.fragments, 50);
  EXPECT_LT(last.fragments, one_place.fragments / 5);
  EXPECT_DOUBLE_EQ(last.sites, 50);
}

TEST(EstimateOfHits, IsRefusedWithTheNumberOfSitesThatFits) {
  const Solid solid = solid_of(cube(4));
  RequestParameters asked = asked_for({"", {}, 0, {}});
  for (int k = 0; k < 40; ++k) asked.fracture.hits.push_back({{0, 0.5, 0}, 0.2, 200});
  const double bytes = expected_answer(asked, solid).working_bytes;
  const auto limit = static_cast<std::uint64_t>(bytes / 10);
  const auto refused = cannot_fit(asked, solid, limit);
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->pointer, "local_sites");
  const CostliestParameter fewer = costliest_parameter(asked, solid, static_cast<double>(limit));
  ASSERT_TRUE(fewer.value.is_number_integer());
  EXPECT_GE(fewer.value.get<int>(), 1);
  EXPECT_LT(fewer.value.get<int>(), 200);
  for (LocalImpact& hit : asked.fracture.hits) hit.sites = fewer.value.get<std::uint32_t>();
  EXPECT_LE(expected_answer(asked, solid).working_bytes, static_cast<double>(limit));
}

}  // namespace
}  // namespace fracture::test
