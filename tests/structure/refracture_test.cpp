// A fragment is fractured again: its pieces are a partition of it, and its old cut faces stay cut faces.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/fragment/fragment_mesh.hpp"
#include "common/pipeline/refracture.hpp"
#include "tests/property/judge.hpp"
#include "tests/structure/seed.hpp"
#include "tests/support/closed_inputs.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/fractured.hpp"
#include "tests/support/full_tests.hpp"
#include "tests/support/mesh_files.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/site_families.hpp"

namespace fracture::test {
namespace {

Mesh largest_fragment(const Mesh& mesh, std::uint32_t sites) {
  FractureParameters p;
  p.pattern = PointsPattern{random_sites(box_of(mesh), sites, kSeed)};
  p.pivot = Pivot::kSource;
  const FragmentSet set = fracture_mesh(mesh, p).set;
  const auto largest =
      std::max_element(set.fragments.begin(), set.fragments.end(),
                       [](const Fragment& a, const Fragment& b) { return a.mass.volume < b.mass.volume; });
  return fragment_mesh(set, static_cast<std::size_t>(largest - set.fragments.begin()));
}

double interior_area(const Mesh& mesh) {
  double sum = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (mesh.material[t] != kInteriorMaterial) continue;
    const auto p = [&](int k) { return to_double(mesh.positions[mesh.triangles[t][k]]); };
    sum += 0.5 * length(cross(p(1) - p(0), p(2) - p(0)));
  }
  return sum;
}

void expect_partition_of(const Mesh& fragment) {
  ASSERT_EQ(open_directed_edges(fragment), 0u);
  FractureParameters p;
  p.pattern = PointsPattern{random_sites(box_of(fragment), 12, kSeed + 1)};
  // First with traced triangles, to check the outside (old cut faces are part of it) ...
  const Mesh traced = with_traced_triangles(fragment);
  const Fractured f = fracture_mesh(traced, p);
  EXPECT_EQ(f.solid.report.open_edges, 0u);
  expect_closed(f.set);
  expect_partition(f.set, volume_of(fragment), area_of(fragment));
  expect_outside_untouched(f.set, traced);
  // ... then unchanged, to check the material of the cut faces: the old ones and both sides of the new ones.
  const FragmentSet set = fracture_mesh(fragment, p).set;
  double interior = 0, bonds = 0, exterior = 0;
  for (std::size_t k = 0; k < set.fragments.size(); ++k) {
    interior += interior_area(fragment_mesh(set, k));
    exterior += set.fragments[k].exterior_area;
  }
  for (const Bond& b : set.bonds) bonds += b.area;
  const double area = area_of(fragment), old = interior_area(fragment);
  EXPECT_GT(old, 0);
  EXPECT_NEAR(interior, old + 2 * bonds, 1e-5 * area);
  EXPECT_NEAR(exterior, area - old, 1e-5 * area);
}

TEST(Refracture, PartsAreAPartitionOfTheFragment) {
  std::size_t input = 0;
  for (const NamedMesh& shape : closed_shapes()) {
    if (!has_turn(input++, 0, 3)) continue;
    SCOPED_TRACE(shape.name);
    if (shape.name == "thin_plate") continue;  // areas in float32 are too coarse there
    if (shape.name == "cube_field") continue;  // its parts are smaller than a cell, so they stay uncut
    expect_partition_of(largest_fragment(shape.mesh, 8));
  }
}

TEST(Refracture, OldCutFacesKeepTheirAttributes) {
  const Mesh mesh = largest_fragment(sphere_with_seams(12, 24), 6);
  ASSERT_FALSE(mesh.attributes.normals.empty());
  FractureParameters p;
  p.pattern = PointsPattern{random_sites(box_of(mesh), 5, kSeed)};
  p.pivot = Pivot::kSource;
  const FragmentSet set = fracture_mesh(mesh, p).set;
  // Every corner of an old cut face is found again with exactly the same position, normal and UV.
  std::size_t corners = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (mesh.material[t] != kInteriorMaterial) continue;
    for (const std::uint32_t w : mesh.triangles[t]) {
      bool found = false;
      for (const Fragment& f : set.fragments)
        for (std::size_t v = 0; v < f.positions.size() && !found; ++v)
          found = f.positions[v] == mesh.positions[w] &&
                  f.attributes.normals[v] == mesh.attributes.normals[w] &&
                  f.attributes.uvs[0][v] == mesh.attributes.uvs[0][w];
      EXPECT_TRUE(found) << "triangle " << t;
      ++corners;
    }
  }
  EXPECT_GT(corners, 0u);
}

class RefractureOfMesh : public OnClosedMesh {};

TEST_P(RefractureOfMesh, FragmentsCanBeFracturedAgain) { expect_partition_of(largest_fragment(mesh, 10)); }

INSTANTIATE_TEST_SUITE_P(Dev, RefractureOfMesh, every_closed_mesh(), name_of_mesh);

// Their cuts look like those of the mesh part from which the fragment comes.
TEST(Refracture, PiecesKnowTheirPartOfTheMesh) {
  const Mesh mesh = joined({cube(), box({3, 0, 0}, {4, 1, 1})});
  FractureParameters p;
  p.sites = 12;
  const Fractured whole = fracture_mesh(mesh, p);
  for (const std::uint32_t part : {0u, 1u}) {
    const auto of_part = std::find_if(whole.set.fragments.begin(), whole.set.fragments.end(),
                                      [&](const Fragment& f) { return f.part == part; });
    ASSERT_NE(of_part, whole.set.fragments.end());
    EXPECT_EQ(of_part->source_part, part);
    StageTimings timings;
    const auto pieces =
        refracture(whole.solid, whole.diagram, p, {.fragment = of_part->id, .sites = 5}, {}, timings);
    ASSERT_TRUE(pieces);
    EXPECT_GT(pieces->set.fragments.size(), 1u);
    for (const Fragment& piece : pieces->set.fragments) {
      EXPECT_EQ(piece.part, 0u) << "of the fragment";
      EXPECT_EQ(piece.source_part, part);
    }
  }
}

}  // namespace
}  // namespace fracture::test
