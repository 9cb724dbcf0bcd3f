// The safety net for rough cuts: how cells are treated whose fragments are judged unsound. These tests
// replace the judge, because no input is known for which the real one reports this.
#include "common/pipeline/rough_cells.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "common/clip/caps.hpp"
#include "common/clip/restricted_diagram.hpp"
#include "tests/property/judge.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/fractured.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::test {
namespace {

struct Net : testing::Test {
  Net() : mesh(torus(40, 20)) {
    Execution execution;
    StageTimings timings;
    p.sites = 40;
    p.roughness = {0.05, 5, 2};
    solid = *make_solid(std::make_shared<Mesh>(mesh), {}, execution);
    diagram = *make_diagram(solid, p, execution, timings);
  }

  CutCells cut(const std::function<Verdict(const FragmentSet&)>& judged) {
    const Execution execution;
    const VoronoiDiagram voronoi(diagram.tetrahedralization, solid.box, diagram.map);
    const Ownership ownership = Ownership::from_groups(diagram.tetrahedralization.site_count(), {});
    RestrictedDiagram restricted = restrict_to_solid(SeenSolid(solid), voronoi, execution);
    CutCells out;
    make_rough_fragments(restricted, p, p.size, ownership, {}, {}, judged, execution, out);
    return out;
  }
  Verdict real(const FragmentSet& set) const { return judge(set, solid, Promise::kPartition); }
  void expect_partitioned(const FragmentSet& set) const {
    EXPECT_TRUE(real(set).sound()) << real(set).violations[0];
    expect_closed(set);
    expect_partition(set, volume_of(mesh), area_of(mesh));
  }

  Mesh mesh;
  FractureParameters p;
  Solid solid;
  Diagram diagram;
};

Verdict unsound_fragments(std::vector<std::uint32_t> fragments) {
  return {{"said so"}, std::move(fragments)};
}

std::set<std::uint32_t> neighbors_of(const FragmentSet& set, std::uint32_t fragment) {
  std::set<std::uint32_t> all{fragment};
  for (const Bond& b : set.bonds) {
    if (b.a == fragment) all.insert(b.b);
    if (b.b == fragment) all.insert(b.a);
  }
  return all;
}

std::size_t triangles(const FragmentSet& set, std::uint32_t k) { return set.fragments[k].indices.size() / 3; }

TEST_F(Net, IsNotUsedWhereTheAnswerIsSound) {
  int asked = 0;
  const CutCells sound = cut([&](const FragmentSet& set) {
    ++asked;
    return real(set);
  });
  EXPECT_EQ(asked, 1);
  EXPECT_EQ(sound.restrained_cells, 0u);
  EXPECT_FALSE(sound.all_flat);
  expect_partitioned(sound.set);
}

TEST_F(Net, FirstTakesRoughnessFromTheCellsConcernedAlone) {
  const CutCells rough = cut([&](const FragmentSet& set) { return real(set); });
  int asked = 0;
  const CutCells less =
      cut([&](const FragmentSet& set) { return asked++ == 0 ? unsound_fragments({11}) : real(set); });
  EXPECT_EQ(asked, 2);
  EXPECT_EQ(less.restrained_cells, 1u);
  expect_partitioned(less.set);
  ASSERT_EQ(less.set.fragments.size(), rough.set.fragments.size());
  // The shape of the fragment changes, and neighbours change at the cuts that they share with it. All others
  // stay the same to the bit.
  EXPECT_NE(less.set.fragments[11].positions, rough.set.fragments[11].positions);
  EXPECT_EQ(triangles(less.set, 11), triangles(rough.set, 11)) << "less rough, but as fine";
  const std::set<std::uint32_t> near = neighbors_of(rough.set, 11);
  std::size_t untouched = 0;
  for (std::uint32_t k = 0; k < rough.set.fragments.size(); ++k)
    if (!near.contains(k)) {
      EXPECT_EQ(less.set.fragments[k].positions, rough.set.fragments[k].positions) << k;
      ++untouched;
    }
  EXPECT_GT(untouched, 10u);
}

TEST_F(Net, ThenLeavesTheCutsOfTheseCellsFlat) {
  int asked = 0;
  const CutCells flat =
      cut([&](const FragmentSet& set) { return asked++ < 2 ? unsound_fragments({11}) : real(set); });
  EXPECT_EQ(asked, 3);
  EXPECT_EQ(flat.restrained_cells, 1u);
  EXPECT_FALSE(flat.all_flat);
  expect_partitioned(flat.set);

  p.roughness.amplitude = 0;
  const CutCells reference = cut([&](const FragmentSet& set) { return real(set); });
  EXPECT_EQ(flat.set.fragments[11].positions.size(), reference.set.fragments[11].positions.size());
  EXPECT_EQ(triangles(flat.set, 11), triangles(reference.set, 11)) << "as it is without roughness";
}

TEST_F(Net, AtLastMakesAllCutsFlat) {
  int asked = 0;
  const CutCells flat = cut([&](const FragmentSet&) {
    ++asked;
    EXPECT_LE(asked, kMostRestraints + 1) << "flat cuts are judged by nobody here";
    return unsound_fragments({2, 11});
  });
  EXPECT_EQ(asked, kMostRestraints + 1);
  EXPECT_TRUE(flat.all_flat);
  expect_partitioned(flat.set);
  p.roughness.amplitude = 0;
  const CutCells reference = cut([&](const FragmentSet& set) { return real(set); });
  for (std::size_t k = 0; k < reference.set.fragments.size(); ++k)
    EXPECT_EQ(flat.set.fragments[k].positions, reference.set.fragments[k].positions);
}

TEST_F(Net, MakesAllCutsFlatAtOnceWhereNobodyIsConcernedMoreThanOthers) {
  int asked = 0;
  const CutCells flat = cut([&](const FragmentSet&) {
    ++asked;
    return unsound_fragments({});
  });
  EXPECT_EQ(asked, 1);
  EXPECT_TRUE(flat.all_flat);
  expect_partitioned(flat.set);
}

// Several groups of cells are restrained at a time, so cuts are shared among them and with rough cells.
TEST_F(Net, HoldsWhateverCellsAreRestrained) {
  for (std::uint32_t step = 2; step < 6; ++step) {
    SCOPED_TRACE(step);
    int asked = 0;
    const CutCells mixed = cut([&](const FragmentSet& set) {
      std::vector<std::uint32_t> some;
      for (std::uint32_t k = static_cast<std::uint32_t>(asked); k < set.fragments.size(); k += step)
        some.push_back(k);
      return asked++ < 3 ? unsound_fragments(some) : real(set);
    });
    EXPECT_GT(mixed.restrained_cells, 10u);
    expect_partitioned(mixed.set);
  }
}

}  // namespace
}  // namespace fracture::test
