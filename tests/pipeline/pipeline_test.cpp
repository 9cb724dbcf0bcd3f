// The pipeline as a whole: who stops it, what it reports, and that caps cost near-linear time in their
// boundary.
#include <gtest/gtest.h>

#include <chrono>

#include "common/pipeline/fracture.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/site_families.hpp"

namespace fracture::test {
namespace {

Solid solid_of(const Mesh& mesh) { return *make_solid(std::make_shared<Mesh>(mesh), {}, {}); }

TEST(Pipeline, CancelledWorkIsATypedError) {
  const Solid solid = solid_of(sphere_with(2000));
  FractureParameters p;
  StageTimings timings;
  const Expected<Diagram> diagram = make_diagram(solid, p, {}, timings);
  std::stop_source source;
  source.request_stop();
  Execution execution;
  execution.stop = source.get_token();
  const auto set = fracture(solid, *diagram, p, execution, timings);
  ASSERT_FALSE(set);
  EXPECT_EQ(set.error().code, ErrorCode::kCancelled);
}

TEST(Pipeline, APassedDeadlineIsATypedError) {
  const Solid solid = solid_of(sphere_with(2000));
  FractureParameters p;
  StageTimings timings;
  Execution execution;
  execution.deadline = std::chrono::steady_clock::now() - std::chrono::seconds(1);
  const auto diagram = make_diagram(solid, p, {}, timings);
  const auto set = fracture(solid, *diagram, p, execution, timings);
  ASSERT_FALSE(set);
  EXPECT_EQ(set.error().code, ErrorCode::kDeadlineExceeded);
}

TEST(Pipeline, DuplicateSitesAreMergedAndReported) {
  const Solid solid = solid_of(cube());
  FractureParameters p;
  p.points = {{0.1, 0, 0}, {-0.1, 0, 0}, {0.1, 0, 0}, {0.1, 0, 0}};
  StageTimings timings;
  const auto set = fracture(solid, *make_diagram(solid, p, {}, timings), p, {}, timings);
  ASSERT_TRUE(set);
  EXPECT_EQ(set->fragments.size(), 2u);
  EXPECT_EQ(set->report["sites"]["given"], 4);
  EXPECT_EQ(set->report["sites"]["used"], 2);
  EXPECT_EQ(set->report["sites"]["duplicates_merged"], 2);
  EXPECT_EQ(set->certificate.sites_asked, 4u);
}

TEST(Pipeline, BarycentricFragmentsAreClosedAndSaySo) {
  const Solid solid = solid_of(torus(24, 12));
  FractureParameters p;
  p.sites = 60;
  p.dual = Dual::kBarycenter;
  StageTimings timings;
  const auto set = fracture(solid, *make_diagram(solid, p, {}, timings), p, {}, timings);
  ASSERT_TRUE(set);
  EXPECT_GT(set->fragments.size(), 30u);
  EXPECT_EQ(set->certificate.open_edges, 0u);
  EXPECT_EQ(set->report["barycenter"]["partition"], false);
  EXPECT_TRUE(set->bonds.empty());
  for (const Fragment& f : set->fragments) EXPECT_GT(f.mass.volume, 0);
}

TEST(Pipeline, APlaneThroughAMillionTrianglesMakesOneCap) {
  const Mesh mesh = sphere_with(1'000'000);
  const Solid solid = solid_of(mesh);
  FractureParameters p;
  p.points = {{-0.3, 0.013, 0.007}, {0.3, 0.01, -0.02}};
  StageTimings timings;
  const auto set = fracture(solid, *make_diagram(solid, p, {}, timings), p, {}, timings);
  ASSERT_TRUE(set);
  ASSERT_EQ(set->fragments.size(), 2u);
  EXPECT_EQ(set->bonds.size(), 1u);
  EXPECT_EQ(set->certificate.open_edges, 0u);
  EXPECT_LT(set->certificate.relative_error, 1e-9);
}

}  // namespace
}  // namespace fracture::test
