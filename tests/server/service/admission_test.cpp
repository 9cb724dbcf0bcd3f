// The expected cost of a request, compared with the number of sites that its pattern really makes.
#include "server/service/admission.hpp"

#include <gtest/gtest.h>

#include "common/gltf/cut_detail.hpp"
#include "common/pipeline/fracture.hpp"
#include "common/rough/roughen.hpp"
#include "tests/support/shapes.hpp"

namespace fracture {
namespace {

Solid wall() {
  auto mesh = std::make_shared<Mesh>(test::box({0, 0, 0}, {3, 2, 0.5}));
  return make_solid(std::move(mesh), {}, {}).value();
}

FractureParameters with(SitePattern pattern, std::uint32_t sites = 50) {
  FractureParameters parameters;
  parameters.pattern = std::move(pattern);
  parameters.sites = sites;
  return parameters;
}

TEST(Admission, CountsTheSitesOfPatternsWhoseCellsHaveASize) {
  const Solid solid = wall();
  GridPattern grid;
  grid.cell = Vec3d{0.1, 0.1, 0.1};
  BrickPattern half, third;
  half.cell = third.cell = Vec3d{0.2, 0.05, 0.1};
  third.bond = BrickPattern::Bond::kThird;
  SlicePattern slices;
  slices.normals = {{0, 2, 0}, {1, 0, 0}};
  slices.spacing = 0.01;
  RadialPattern rings;
  rings.spokes = 20;
  rings.rings = 30;
  for (const FractureParameters& parameters :
       {with(UniformPattern{}, 77), with(grid), with(half), with(third), with(slices),
        with(BrickPattern{}, 200), with(RadialPattern{}, 300), with(rings)}) {
    const SitePlan plan = plan_sites(solid, parameters, {}).value();
    const auto made = static_cast<double>(plan.points.size());
    SCOPED_TRACE(kPatternTraits[parameters.pattern.index()].name);
    EXPECT_GE(expected_sites(parameters, &solid), made / 2);
    EXPECT_LE(expected_sites(parameters, &solid), made * 2);
  }
}

// The pattern divides the box until the solid has enough cells.
TEST(Admission, CountsTheFurtherCellsThatANumberOfFragmentsTakes) {
  const Solid solid = wall();
  for (const SitePattern& pattern :
       {SitePattern(UniformPattern{}), SitePattern(ImpactPattern{}), SitePattern(ClusteredPattern{}),
        SitePattern(GridPattern{}), SitePattern(BrickPattern{}), SitePattern(RadialPattern{})}) {
    SCOPED_TRACE(kPatternTraits[pattern.index()].name);
    FractureParameters parameters = with(pattern, 60);
    parameters.size.fragments = 60;
    StageTimings timings;
    const auto made = static_cast<double>(make_diagram(solid, parameters, {}, timings).value().sites.size());
    EXPECT_GE(expected_sites(parameters, &solid), made / 2);
    EXPECT_LE(expected_sites(parameters, &solid), made * 2);
  }
}

TEST(Admission, CountsLaterSitesAndNeverMoreThanThereMayBe) {
  const Solid solid = wall();
  FractureParameters parameters = with(UniformPattern{}, 10);
  EXPECT_EQ(expected_sites(parameters, &solid), 10);
  parameters.rest = LocalRest::kFractured;
  parameters.hits = {{.point = {}, .radius = 0.2, .sites = 20}, {.point = {}, .radius = 0.2, .sites = 10}};
  EXPECT_EQ(expected_sites(parameters, &solid), 40);
  const Selection selection{.refracture = Refracture{.sites = 7}};
  EXPECT_EQ(expected_sites(parameters, &solid, selection), 47);
  parameters.max_volume = solid.report.volume / 1000;
  EXPECT_GE(expected_sites(parameters, &solid), 1000);
  EXPECT_EQ(expected_sites(parameters, nullptr, selection),
            47);  // nothing is known about a mesh that was not read yet
  parameters.max_volume = 1e-300;
  EXPECT_EQ(expected_sites(parameters, &solid), parameters.most_sites);
  parameters.rest = LocalRest::kWhole;  // the pattern breaks nothing
  EXPECT_EQ(expected_sites(parameters, &solid), 31);
}

TEST(Admission, CountsTheCellsOfAggregates) {
  const Solid solid = wall();
  FractureParameters parameters = with(UniformPattern{}, 10);
  parameters.aggregation.cells = 6;
  EXPECT_EQ(expected_sites(parameters, &solid), 60);
  EXPECT_EQ(expected_sites(parameters, nullptr), 60);
  parameters.size.fragments = 10;
  EXPECT_EQ(expected_sites(parameters, &solid), 60);
  parameters.rest = LocalRest::kFractured;
  parameters.hits = {{.point = {}, .radius = 0.2, .sites = 20}};
  EXPECT_EQ(expected_sites(parameters, &solid), 180);
  EXPECT_EQ(expected_sites(parameters, &solid, Selection{.refracture = Refracture{.sites = 7}}), 222);
  parameters.pattern = GridPattern{};  // a grid has no such number
  parameters.hits.clear();
  EXPECT_EQ(expected_sites(parameters, nullptr), 20);
}

TEST(Admission, CountsTheTrianglesOfRoughCutsAboutRight) {
  const Mesh mesh = test::cube();
  const Solid solid = *make_solid(std::make_shared<Mesh>(mesh), {}, {});
  for (const auto& [sites, cells] : {std::pair{20u, 1u}, {200u, 1u}, {20u, 8u}, {60u, 4u}})
    for (const Roughness& roughness : {Roughness{0.05, 4, 1}, Roughness{0.02, 5, 2}}) {
      FractureParameters p = with(UniformPattern{});
      p.sites = sites;
      p.aggregation.cells = cells;
      p.roughness = roughness;
      StageTimings timings;
      const Expected<Diagram> diagram = make_diagram(solid, p, {}, timings);
      const Expected<FracturedSolid> fractured = fracture(solid, *diagram, p, {}, timings);
      ASSERT_TRUE(fractured);
      const double made = static_cast<double>(fractured->report.rough_cuts->triangles),
                   expected = expected_rough_triangles(p, expected_sites(p, &solid));
      EXPECT_GT(expected, made / 3);
      EXPECT_LT(expected, made * 3);
      const ExpectedWork rough = expected_work(p, 1000, nullptr);
      p.roughness = {};
      EXPECT_GT(rough.seconds, expected_work(p, 1000, nullptr).seconds);
      EXPECT_GT(rough.bytes, expected_work(p, 1000, nullptr).bytes);
    }
  FractureParameters finest = with(UniformPattern{});
  finest.roughness = {0.01, 100, 6};
  EXPECT_LE(expected_rough_triangles(finest, 100000), kMostRoughTriangles) << "as many as are made";
  finest.dual = Dual::kBarycenter;
  EXPECT_EQ(expected_rough_triangles(finest, 50), 0) << "hulls of barycentres have no rough cuts";
}

TEST(Admission, AHitOnAKeptAnswerCostsWhatItChanges) {
  FractureParameters p = with(UniformPattern{});
  p.sites = 10'000;
  p.rest = LocalRest::kFractured;
  p.hits = {{{0, 0, 0}, 0.1, 500}, {{1, 0, 0}, 0.1, 30}};
  const auto work_of = [&](std::uint32_t new_hits) {
    return expected_hit_work(p, {.kept = true, .new_hits = NewHits{new_hits}}, nullptr).seconds;
  };
  const double whole = expected_work(p, 0, nullptr).seconds, hit = work_of(1);
  EXPECT_LT(hit, whole / 5);
  EXPECT_GT(work_of(2), hit) << "all new hits count";
  const ExpectedWork part =
      expected_hit_work(p, {.kept = true, .new_hits = NewHits{1, /*only_changed=*/true}}, nullptr);
  EXPECT_LT(part.seconds, hit / 2) << "nothing is copied";
  EXPECT_LT(part.bytes, expected_work(p, 0, nullptr).bytes / 10);
  p.sites = 1;
  EXPECT_LE(work_of(2), expected_work(p, 0, nullptr).seconds);
}

TEST(Admission, WorkGrowsWithBytesSitesAndPasses) {
  FractureParameters parameters = with(UniformPattern{});
  const ExpectedWork base = expected_work(parameters, 1000, nullptr);
  EXPECT_GT(expected_work(parameters, 1'000'000, nullptr).seconds, base.seconds);
  EXPECT_GT(expected_work(parameters, 1'000'000, nullptr).bytes, base.bytes);
  parameters.sites = 5000;
  EXPECT_GT(expected_work(parameters, 1000, nullptr).bytes, base.bytes);
  const double one_pass = expected_work(parameters, 1000, nullptr).seconds;
  EXPECT_GT(one_pass, base.seconds);
  parameters.lloyd = 10;
  EXPECT_GT(expected_work(parameters, 1000, nullptr).seconds, 2 * one_pass);
}

TEST(Admission, CountsTheWallsThatAreMadeWhenTheMeshIsPrepared) {
  RequestParameters asked;
  EXPECT_EQ(expected_further_seconds(asked, 1000), 0);
  asked.hollow.thickness = 0.01;
  EXPECT_GT(expected_further_seconds(asked, 1000), 100 * expected_work(1000).seconds) << "of a small mesh";
  EXPECT_GT(expected_further_seconds(asked, 10'000'000), 2 * expected_further_seconds(asked, 1000));
  EXPECT_EQ(expected_further_seconds(asked, 0), 0) << "it is prepared";
}

TEST(Admission, CountsTheMapsOfACutDetailUntilTheyAreMade) {
  RequestParameters asked;
  asked.interior.detail = CutDetail::kBrick;
  ASSERT_FALSE(has_detail_maps(CutDetail::kBrick));
  EXPECT_GT(expected_further_seconds(asked, 0), 0);
  asked.delta = DeltaAnswer::kOnly;
  EXPECT_EQ(expected_further_seconds(asked, 0), 0) << "such an answer has none";
  asked.delta = DeltaAnswer::kNone;
  detail_maps(CutDetail::kBrick);
  EXPECT_EQ(expected_further_seconds(asked, 0), 0);
}

}  // namespace
}  // namespace fracture
