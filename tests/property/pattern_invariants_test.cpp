// I1, I2 and I3 for every pattern, every material and every limit, region and hit. They run on closed shapes
// and meshes, including oblique and stretched ones. FRACTURE_TEST_FULL=1 adds all meshes and more sites. In
// short tests each request runs on some of the inputs.
#include <gtest/gtest.h>

#include <cstdlib>
#include <set>

#include "tests/property/judge.hpp"
#include "tests/support/closed_inputs.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/mesh_files.hpp"
#include "tests/support/pattern_requests.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/structure_requests.hpp"

namespace fracture::test {
namespace {

constexpr std::uint64_t kSeed = 20261121;

/// `input` and `rounds` are those of has_turn().
void expect_all_invariants(const Mesh& mesh, std::uint32_t sites, bool embedded, std::size_t input,
                           std::size_t rounds) {
  const Mesh traced = with_traced_triangles(mesh);
  const double volume = volume_of(mesh), area = area_of(mesh);
  const Expected<Solid> solid = make_solid(std::make_shared<Mesh>(traced), {}, {});
  ASSERT_TRUE(solid) << solid.error().detail;
  std::vector<NamedParameters> requests = pattern_requests(solid->box, sites, kSeed);
  for (NamedParameters& request : structure_requests(*solid, sites, kSeed))
    requests.push_back(std::move(request));
  for (std::size_t k = 0; k < requests.size(); ++k) {
    if (!has_turn(input, k, rounds)) continue;
    NamedParameters& request = requests[k];
    SCOPED_TRACE(request.name);
    request.parameters.roughness = {};  // see rough_invariants_test.cpp
    StageTimings timings;
    const Expected<Diagram> diagram = make_diagram(*solid, request.parameters, {}, timings);
    ASSERT_TRUE(diagram) << diagram.error().detail;
    const Expected<FracturedSolid> made = fracture(*solid, *diagram, request.parameters, {}, timings);
    ASSERT_TRUE(made) << made.error().detail;
    const FragmentSet& set = made->set;
    expect_closed(set);
    expect_partition(set, volume, area);
    expect_outside_untouched(set, traced);
    const Certificate& c = set.certificate;
    EXPECT_EQ(c.open_edges, 0u);
    EXPECT_EQ(c.dropped, 0u);
    EXPECT_EQ(c.fragments, c.cells + c.islands - c.united - c.dropped);
    EXPECT_GT(c.fragments, 1u);
    if (embedded && !diagram->map) {  // in an image, rounding may fold thin places
      EXPECT_EQ(c.crossing_caps, 0u);
    }
  }
}

class PatternsOnShapes : public OnClosedShape {};

TEST_P(PatternsOnShapes, KeepAllInvariants) {
  expect_all_invariants(shape().mesh, full_tests() ? 200 : 40, true, GetParam(), 3);
}

INSTANTIATE_TEST_SUITE_P(Seed20261121, PatternsOnShapes, every_closed_shape(), name_of_shape);

class PatternsOnMeshes : public OnClosedMeshAtLength {};

TEST_P(PatternsOnMeshes, KeepAllInvariants) {
  expect_all_invariants(mesh, full_tests() ? 120 : 40, embedded(), number(), 3);
}

INSTANTIATE_TEST_SUITE_P(Dev, PatternsOnMeshes, every_closed_mesh(), name_of_mesh);

TEST(PatternsFarFromOrigin, StretchedCellsKeepAllInvariantsAtAThousandSizes) {
  std::size_t input = 0;
  for (const double distance : {4.0, 1000.0}) {
    SCOPED_TRACE(distance);
    const Mesh mesh = torus(24, 12);
    expect_all_invariants(translated(mesh, distance * box_of(mesh).longest_side() * Vec3d{1, -1, 0.5}), 30,
                          false, input++, 2);
  }
}

}  // namespace
}  // namespace fracture::test
