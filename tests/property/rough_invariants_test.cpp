// I1, I2 and I3 for rough cuts, and that no fragment passes through itself. They run on closed shapes and
// meshes, with the patterns whose cells meet in special ways. FRACTURE_TEST_FULL=1 adds all meshes, patterns
// and more sites.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <set>

#include "tests/property/judge.hpp"
#include "tests/support/closed_inputs.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/fractured.hpp"
#include "tests/support/mesh_files.hpp"
#include "tests/support/pattern_requests.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::test {
namespace {

constexpr std::uint64_t kSeed = 20261121;

/// `embedded`: the surface does not cross itself.
void expect_all_invariants(const Mesh& mesh, const FractureParameters& parameters, bool embedded) {
  const Mesh traced = with_traced_triangles(mesh);
  const Fractured f = fracture_mesh(traced, parameters);
  expect_closed(f.set);
  expect_partition(f.set, volume_of(mesh), area_of(mesh));
  expect_outside_untouched(f.set, traced);
  const Certificate& c = f.set.certificate;
  EXPECT_EQ(c.open_edges, 0u);
  EXPECT_EQ(c.dropped, 0u);
  EXPECT_EQ(c.fragments, c.cells + c.islands - c.united - c.dropped);
  EXPECT_GT(f.report.rough_cuts.value().triangles, 0u);
  if (!embedded || f.diagram.map) return;  // in an image, rounding may fold thin and flat places
  EXPECT_EQ(f.report.rough_cuts->crossing_triangles, 0u);
  expect_no_self_crossing(f.set,
                          16 * std::max({f.set.lattice_step.x, f.set.lattice_step.y, f.set.lattice_step.z}));
}

FractureParameters rough(FractureParameters p) {
  p.roughness = full_tests() ? Roughness{0.06, 5, 2} : Roughness{0.05, 4, 1};
  return p;
}

/// Returns all patterns. In the short run it returns uniform sites and one pattern whose cells meet in
/// special ways (lattices, groups, thin cells, an image): the one whose turn it is.
std::vector<NamedParameters> requests(const Box& box, std::size_t turn) {
  const std::array<std::string, 4> special{"brick", "slice_two", "radial", "wood"};
  std::vector<NamedParameters> all = pattern_requests(box, full_tests() ? 60 : 20, kSeed);
  if (!full_tests())
    std::erase_if(all, [&](const NamedParameters& r) {
      return r.name != "uniform" && r.name != special[turn % special.size()];
    });
  return all;
}

class RoughShape : public OnClosedShape {};

TEST_P(RoughShape, KeepsAllInvariants) {
  for (const NamedParameters& request : requests(box_of(shape().mesh), GetParam())) {
    SCOPED_TRACE(request.name);
    expect_all_invariants(shape().mesh, rough(request.parameters), true);
  }
}

INSTANTIATE_TEST_SUITE_P(Seed20261121, RoughShape, every_closed_shape(), name_of_shape);

class RoughMesh : public OnClosedMeshAtLength {};

TEST_P(RoughMesh, KeepsAllInvariants) {
  FractureParameters p;
  p.sites = 40;
  p.seed = kSeed;
  p = rough(p);
  expect_all_invariants(mesh, p, embedded());
  p.roughness.amplitude = 0.25;  // more than is allowed
  expect_all_invariants(mesh, p, embedded());
}

INSTANTIATE_TEST_SUITE_P(Dev, RoughMesh, every_closed_mesh(), name_of_mesh);

TEST(RoughGroups, KeepLimitsOfSizeAndLocalHitsKeepAllInvariants) {
  const Mesh mesh = torus(32, 16);
  FractureParameters p;
  p.sites = 40;
  p.seed = kSeed;
  FractureParameters kept = p, limited = p, hit = p;
  kept.keep = Region{.center = {1, 0, 0}, .radius = 0.5};
  limited.size = {.min_fraction = 0.02};
  hit.hits = {{.point = {0, 1, 0.4}, .radius = 0.4}};
  for (const FractureParameters& request : {kept, limited, hit})
    expect_all_invariants(mesh, rough(request), true);
}

// Cells of a nearly even lattice have corners that nearly lie on one line. That makes triangles without
// height, which displacement opens, sometimes to the wrong side.
TEST(RoughSlivers, KeepAllInvariants) {
  const Mesh mesh = nested_spheres(4, 400);
  for (const NamedParameters& request : pattern_requests(box_of(mesh), 60, kSeed)) {
    if (request.name != "grid_jitter") continue;
    FractureParameters p = request.parameters;
    p.roughness = {0.06, 5, 2};
    expect_all_invariants(mesh, p, true);
  }
}

TEST(RoughFarFromOrigin, KeepsAllInvariantsAtAThousandSizes) {
  const Mesh mesh = torus(24, 12);
  FractureParameters p;
  p.sites = 20;
  p.seed = kSeed;
  expect_all_invariants(translated(mesh, 1000 * box_of(mesh).longest_side() * Vec3d{1, -1, 0.5}), rough(p),
                        true);
}

TEST(RoughAgain, AFragmentWithRoughCutsIsFracturedAgain) {
  FractureParameters p;
  p.sites = 8;
  p.seed = kSeed;
  p = rough(p);
  const Mesh mesh = sphere_with(400);
  const Fractured first = fracture_mesh(mesh, p);
  const FracturedSolid parts =
      fracture_mesh_again(mesh, p, {.fragment = first.set.fragments[0].id, .sites = 6});
  expect_closed(parts.set);
  EXPECT_NEAR(parts.set.certificate.volume_out, first.set.fragments[0].mass.volume,
              1e-5 * first.set.fragments[0].mass.volume);
  EXPECT_GT(parts.report.rough_cuts.value().triangles, 0u);
}

}  // namespace
}  // namespace fracture::test
