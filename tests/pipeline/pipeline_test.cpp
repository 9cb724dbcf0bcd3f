// The whole pipeline: how it is stopped, what it reports, and that the cost of caps is nearly linear in their
// boundary.
#include <gtest/gtest.h>

#include <chrono>
#include <set>
#include <stop_token>
#include <tuple>

#include "common/pipeline/fracture.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/site_families.hpp"
#include "tests/support/solids.hpp"

namespace fracture::test {
namespace {

TEST(Pipeline, CancelledWorkIsATypedError) {
  const Solid solid = solid_of(sphere_with(2000));
  FractureParameters p;
  StageTimings timings;
  const Expected<Diagram> diagram = make_diagram(solid, p, {}, timings);
  std::stop_source source;
  source.request_stop();
  Execution execution;
  execution.stop = source.get_token();
  const auto made = fracture(solid, *diagram, p, execution, timings);
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().code, ErrorCode::kCancelled);
}

TEST(Pipeline, APassedDeadlineIsATypedError) {
  const Solid solid = solid_of(sphere_with(2000));
  FractureParameters p;
  StageTimings timings;
  Execution execution;
  execution.deadline = std::chrono::steady_clock::now() - std::chrono::seconds(1);
  const auto diagram = make_diagram(solid, p, {}, timings);
  const auto made = fracture(solid, *diagram, p, execution, timings);
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().code, ErrorCode::kDeadlineExceeded);
}

TEST(Pipeline, ManyPassesOfRelaxationHoldNoMoreThanOne) {
  const Solid solid = solid_of(sphere_with(2000));
  std::uint64_t held[2] = {};
  for (const std::uint32_t passes : {1u, 20u}) {
    FractureParameters p;
    p.lloyd = passes;
    Allowance allowance(0, UINT64_MAX, [](std::uint64_t) { return Allowance::Answer::kGranted; });
    Execution execution;
    execution.allowance = &allowance;
    StageTimings timings;
    ASSERT_TRUE(make_diagram(solid, p, execution, timings));
    held[passes > 1] = allowance.bytes();
  }
  EXPECT_GT(held[0], 0u);
  EXPECT_LT(held[1], held[0] + held[0] / 2) << "what a pass makes is gone after it";
}

// The outer rings of a radial pattern have sites outside the mesh, which must not leave the range of sites.
TEST(Pipeline, TheLargestMeshHasSitesForRings) {
  FractureParameters parameters;
  parameters.sites = 50;
  parameters.pattern = RadialPattern{};
  const Solid largest = test::solid_of(test::scaled(test::cube(), {1.99e11, 1.99e11, 1.99e11}));
  StageTimings timings;
  const Expected<Diagram> diagram = make_diagram(largest, parameters, {}, timings);
  EXPECT_TRUE(diagram) << diagram.error().detail;
}

TEST(Pipeline, DuplicateSitesAreMergedAndReported) {
  const Solid solid = solid_of(cube());
  FractureParameters p;
  p.pattern = PointsPattern{{{0.1, 0, 0}, {-0.1, 0, 0}, {0.1, 0, 0}, {0.1, 0, 0}}};
  StageTimings timings;
  const auto made = fracture(solid, *make_diagram(solid, p, {}, timings), p, {}, timings);
  ASSERT_TRUE(made);
  EXPECT_EQ(made->set.fragments.size(), 2u);
  EXPECT_EQ(made->report.sites.given, 4u);
  EXPECT_EQ(made->report.sites.used, 2u);
  EXPECT_EQ(made->report.sites.duplicates_merged, 2u);
  EXPECT_EQ(made->set.certificate.sites_asked, 4u);
}

// The second of the four points is far away, and the third equals the first.
TEST(Pipeline, SitesOfFragmentsAreNumbersOfTheCallersPoints) {
  const Solid solid = solid_of(cube());
  FractureParameters p;
  p.pattern = PointsPattern{{{0.1, 0, 0}, {1000, 0, 0}, {0.1, 0, 0}, {-0.1, 0, 0}}};
  StageTimings timings;
  const auto made = fracture(solid, *make_diagram(solid, p, {}, timings), p, {}, timings);
  ASSERT_TRUE(made);
  EXPECT_EQ(made->report.sites.duplicates_merged, 1u);
  EXPECT_EQ(made->report.sites.far_dropped, 1u);
  ASSERT_EQ(made->set.fragments.size(), 2u);
  for (const Fragment& f : made->set.fragments) {
    ASSERT_EQ(f.sites.size(), 1u);
    EXPECT_EQ(made->point_of_site.at(f.sites[0]), f.pivot.x > 0 ? 0u : 3u);
  }
}

TEST(Pipeline, InTheSourcesFrameNothingIsMovedNorRoundedOtherwise) {
  Mesh mesh = sphere_with(2000);
  for (Vec3f& p : mesh.positions) p = {p.x + 30, p.y - 7, p.z + 0.3f};
  const Solid solid = solid_of(mesh);
  FractureParameters p;
  StageTimings timings;
  const Diagram diagram = *make_diagram(solid, p, {}, timings);
  const FracturedSolid centred = *fracture(solid, diagram, p, {}, timings);
  p.pivot = Pivot::kSource;
  const FracturedSolid placed = *fracture(solid, diagram, p, {}, timings);

  const auto before = [](const Vec3f& a, const Vec3f& b) {
    return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
  };
  std::set<Vec3f, decltype(before)> source(mesh.positions.begin(), mesh.positions.end(), before),
      seen(before);
  ASSERT_EQ(placed.set.fragments.size(), centred.set.fragments.size());
  for (std::size_t k = 0; k < placed.set.fragments.size(); ++k) {
    const Fragment &at = placed.set.fragments[k], &from = centred.set.fragments[k];
    EXPECT_EQ(at.pivot, Vec3d{});
    EXPECT_EQ(at.id, from.id);
    ASSERT_EQ(at.positions.size(), from.positions.size());
    for (std::size_t v = 0; v < at.positions.size(); ++v) {
      if (source.count(at.positions[v]) > 0) {
        seen.insert(at.positions[v]);
        continue;
      }
      const Vec3d moved = to_double(from.positions[v]) + from.pivot;  // a vertex of a cut: exact
      EXPECT_EQ(to_double(at.positions[v]), moved);
    }
  }
  EXPECT_EQ(seen.size(), source.size()) << "an input vertex lost its bits";
  EXPECT_EQ(placed.set.certificate.open_edges, 0u);
}

TEST(Pipeline, BarycentricFragmentsAreClosedAndSaySo) {
  const Solid solid = solid_of(torus(24, 12));
  FractureParameters p;
  p.sites = 60;
  p.dual = Dual::kBarycenter;
  StageTimings timings;
  const auto made = fracture(solid, *make_diagram(solid, p, {}, timings), p, {}, timings);
  ASSERT_TRUE(made);
  EXPECT_GT(made->set.fragments.size(), 30u);
  EXPECT_EQ(made->set.certificate.open_edges, 0u);
  EXPECT_TRUE(made->report.barycenter.has_value()) << "no partition is promised";
  EXPECT_TRUE(made->set.bonds.empty());
  for (const Fragment& f : made->set.fragments) EXPECT_GT(f.mass.volume, 0);
}

TEST(Pipeline, ThePapersVolumeFilterLeavesOutWhatIsLargerAndSaysHowMuch) {
  const Solid solid = solid_of(sphere_with(500));
  FractureParameters p;
  p.sites = 60;
  p.dual = Dual::kBarycenter;
  StageTimings timings;
  const Diagram diagram = *make_diagram(solid, p, {}, timings);
  const FracturedSolid all = *fracture(solid, diagram, p, {}, timings);
  p.drop_above = all.report.size.volumes.median;
  const FracturedSolid some = *fracture(solid, diagram, p, {}, timings);
  EXPECT_EQ(some.report.barycenter->dropped->fragments + some.set.fragments.size(), all.set.fragments.size());
  EXPECT_GT(some.report.barycenter->dropped->fragments, 10u);
  for (const Fragment& f : some.set.fragments) EXPECT_LE(f.mass.volume, p.drop_above);
  EXPECT_NEAR(some.set.certificate.volume_out + some.report.barycenter->dropped->volume,
              all.set.certificate.volume_out, 1e-12);
  p.drop_above = all.report.size.volumes.smallest / 2;
  const auto none = fracture(solid, diagram, p, {}, timings);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, ErrorCode::kNoFragments);
  EXPECT_NE(none.error().detail.find("drop_above"), std::string::npos);
}

TEST(Pipeline, APlaneThroughAMillionTrianglesMakesOneCap) {
  const Mesh mesh = sphere_with(1'000'000);
  const Solid solid = solid_of(mesh);
  FractureParameters p;
  p.pattern = PointsPattern{{{-0.3, 0.013, 0.007}, {0.3, 0.01, -0.02}}};
  StageTimings timings;
  const auto made = fracture(solid, *make_diagram(solid, p, {}, timings), p, {}, timings);
  ASSERT_TRUE(made);
  ASSERT_EQ(made->set.fragments.size(), 2u);
  EXPECT_EQ(made->set.bonds.size(), 1u);
  EXPECT_EQ(made->set.certificate.open_edges, 0u);
  EXPECT_LT(made->set.certificate.relative_error, 1e-9);
}

}  // namespace
}  // namespace fracture::test
