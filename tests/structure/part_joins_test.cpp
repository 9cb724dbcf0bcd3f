// Fragments of several parts (parts=together), on boxes whose cells and contacts are known by hand.
#include <gtest/gtest.h>

#include <map>
#include <set>
#include <utility>

#include "common/base/disjoint_sets.hpp"
#include "common/hits/difference.hpp"
#include "tests/property/judge.hpp"
#include "tests/structure/in_contact.hpp"

namespace fracture::test {
namespace {

std::set<std::uint32_t> parts_of(const Fragment& f) {
  if (f.part_cells.empty()) return {f.part};
  std::set<std::uint32_t> parts;
  for (const PartCell& cell : f.part_cells) parts.insert(cell.part);
  return parts;
}

Fractured together(const std::vector<Mesh>& parts, FractureParameters p) {
  p.parts = Parts::kTogether;
  return fracture_solid(solid_in_contact(parts), p);
}

/// Groups of fragments that are connected by bonds.
std::size_t bonded_groups(const FragmentSet& set) {
  DisjointSets sets(set.fragments.size());
  for (const Bond& bond : set.bonds) sets.unite(bond.a, bond.b);
  return sets.set_count();
}

/// Boxes of 1 x 1 x 1 next to each other along x.
std::vector<Mesh> row_of_boxes(int count) {
  std::vector<Mesh> boxes;
  for (int k = 0; k < count; ++k) boxes.push_back(box({1.0 * k, 0, 0}, {k + 1.0, 1, 1}));
  return boxes;
}

/// Planks of 4 x 0.2 x 1 on top of each other. Each one breaks along its own grain.
std::vector<Mesh> stack_of_planks(int count) {
  std::vector<Mesh> planks;
  for (int k = 0; k < count; ++k) planks.push_back(box({0, 0.2 * k, 0}, {4, 0.2 * (k + 1), 1}));
  return planks;
}
FractureParameters wood_like(std::uint32_t fragments) {
  FractureParameters p;
  p.sites = p.size.fragments = fragments;
  p.anisotropy = {.stretch = 3, .grain_of = GrainOf::kPart};
  return p;
}

// Two boxes of 2 x 1 x 1 on top of each other, cut at x = 1: each half is 1 x 2 x 1 and has pieces of both.
TEST(PartJoins, PiecesThatTouchInACellAreOneFragment) {
  const Fractured made = together({box({0, 0, 0}, {2, 1, 1}), box({0, 1, 0}, {2, 2, 1})},
                                  cut_by({{0.5, 1, 0.5}, {1.5, 1, 0.5}}));
  const FragmentSet& set = made.set;
  ASSERT_EQ(set.fragments.size(), 2u);
  for (const Fragment& f : set.fragments) {
    EXPECT_NEAR(f.mass.volume, 2, 1e-12);
    EXPECT_NEAR(f.mass.center_of_mass.y, 1, 1e-12);
    EXPECT_EQ(parts_of(f), (std::set<std::uint32_t>{0, 1}));
    EXPECT_EQ(f.sites.size(), 1u);
    EXPECT_EQ(f.bodies.size(), 2u);  // a hull for each box
    EXPECT_EQ(f.open_edges, 0u);
  }
  ASSERT_EQ(set.bonds.size(), 1u);  // both caps; nothing of the contact is between the halves
  EXPECT_NEAR(set.bonds[0].area, 2, 1e-12);
  EXPECT_EQ(set.certificate.united, 2u);
  EXPECT_NEAR(set.certificate.volume_out, 4, 1e-12);
}

// Without contact in a cell, pieces stay apart: the second box touches the first only beyond x = 1.
TEST(PartJoins, PiecesThatDoNotTouchInTheirCellStayApart) {
  // A U: a bar with two posts. The right post touches the bar; the left one floats above it.
  const Fractured made =
      together({box({0, 0, 0}, {2, 1, 1}), box({1.2, 1, 0}, {1.8, 2, 1}), box({0.2, 1.5, 0}, {0.8, 2, 1})},
               cut_by({{0.5, 1, 0.5}, {1.5, 1, 0.5}}));
  ASSERT_EQ(made.set.fragments.size(), 3u);
  const std::uint32_t floating = fragment_at(made.set, 2, {0.5, 1.75, 0.5});
  EXPECT_EQ(parts_of(made.set.fragments[floating]), (std::set<std::uint32_t>{2}));
}

// The cubes [-2, 2]³ and [-1, 3]³ overlap in [-1, 2]³. The cell [0, 1]³ lies inside both, so no surface is in it.
TEST(PartJoins, PiecesThatOverlapWithoutSurfaceInTheirCellAreOneFragment) {
  std::vector<Vec3d> sites;
  for (const double x : {-0.5, 0.5, 1.5})
    for (const double y : {-0.5, 0.5, 1.5})
      for (const double z : {-0.5, 0.5, 1.5}) sites.push_back({x, y, z});
  const Fractured made =
      together({box({-2, -2, -2}, {2, 2, 2}), box({-1, -1, -1}, {3, 3, 3})}, cut_by(sites));
  ASSERT_EQ(made.set.fragments.size(), 27u);
  for (const Fragment& f : made.set.fragments) EXPECT_EQ(parts_of(f), (std::set<std::uint32_t>{0, 1}));
  EXPECT_EQ(made.set.certificate.open_edges, 0u);
  EXPECT_NEAR(made.set.certificate.volume_out, 128, 1e-9);
}

// A rod of 0.2 x 0.2 passes through the cell [0, 1]³ of a block without touching the block's surface there.
TEST(PartJoins, APieceInsideAnotherBelongsToIt) {
  const Fractured made = together({box({-2, -2, -2}, {3, 3, 3}), box({-2.5, 0.4, 0.4}, {3.5, 0.6, 0.6})},
                                  cut_by({{-0.5, 0.5, 0.5}, {0.5, 0.5, 0.5}, {1.5, 0.5, 0.5}}));
  ASSERT_EQ(made.set.fragments.size(), 3u);
  for (const Fragment& f : made.set.fragments) EXPECT_EQ(parts_of(f), (std::set<std::uint32_t>{0, 1}));
}

TEST(PartJoins, AsManyFragmentsAsAskedForOfManyParts) {
  for (const std::uint32_t wanted : {1u, 3u, 10u}) {
    FractureParameters p;
    p.sites = p.size.fragments = wanted;
    const FragmentSet rows = together(row_of_boxes(20), p).set;
    EXPECT_EQ(rows.fragments.size(), wanted);
    EXPECT_EQ(bonded_groups(rows), 1u);
    const FragmentSet planks = together(stack_of_planks(40), wood_like(wanted)).set;
    EXPECT_EQ(planks.fragments.size(), wanted);
    EXPECT_EQ(bonded_groups(planks), 1u);
  }
}

// Ten boxes that touch, and two that touch nothing: 4 fragments are 1 + 1 + 2.
TEST(PartJoins, PartsThatTouchNothingAreFragmentsOfTheirOwn) {
  std::vector<Mesh> boxes = row_of_boxes(10);
  boxes.push_back(box({20, 0, 0}, {21, 1, 1}));
  boxes.push_back(box({30, 0, 0}, {31, 1, 1}));
  const FragmentSet set = together(boxes, wood_like(4)).set;
  ASSERT_EQ(set.fragments.size(), 4u);
  EXPECT_EQ(set.size.parts, 3u);
  EXPECT_EQ(bonded_groups(set), 3u);
  for (const std::uint32_t lone : {10u, 11u})
    EXPECT_EQ(parts_of(set.fragments[fragment_at(set, lone, {10.0 * lone - 79.5, 0.5, 0.5})]),
              (std::set<std::uint32_t>{lone}));
}

// The post's bottom touches the first box with 0.02 x 0.1, its side the second one with 0.1 x 0.1.
TEST(PartJoins, ASmallPartJoinsItsLargestContact) {
  const FragmentSet set = together({box({0, 0, 0}, {1, 1, 1}), box({1.05, 1, 0}, {2, 2, 1}),
                                    box({0.98, 1, 0.4}, {1.05, 1.1, 0.5})},
                                   wood_like(2))
                              .set;
  ASSERT_EQ(set.fragments.size(), 2u);
  for (const Fragment& f : set.fragments)
    EXPECT_EQ(parts_of(f).contains(2), parts_of(f).contains(1)) << "fragment " << f.id;
}

TEST(PartJoins, ApartEveryFragmentHasOnePart) {
  FractureParameters p = wood_like(10);
  p.parts = Parts::kApart;
  const Fractured made = fracture_solid(solid_in_contact(stack_of_planks(40)), p);
  EXPECT_GE(made.set.fragments.size(), 40u);
  for (const Fragment& f : made.set.fragments) EXPECT_TRUE(f.part_cells.empty());
}

TEST(PartJoins, AreSoundWithEveryKindOfDiagram) {
  for (FractureParameters p : {wood_like(12), FractureParameters{}}) {
    p.sites = p.size.fragments = 12;
    p.hulls = Hulls::kConvex;
    for (const bool rough : {false, true}) {
      if (rough) p.roughness.amplitude = 0.01;
      const Fractured made = together(stack_of_planks(7), p);
      EXPECT_EQ(made.set.fragments.size(), 12u);
      expect_closed(made.set);
      expect_partition(made.set, made.solid.report.volume, made.solid.report.area);
    }
  }
}

// Two cubes of 8 that overlap in 1 x 1.5 x 1.5. The pieces of their fragment, and its clusters, weigh as much as it.
TEST(PartJoins, PiecesOfAFragmentWeighAsMuchAsIt) {
  const Solid solid = solid_in_contact({box({0, 0, 0}, {2, 2, 2}), box({1, 0.5, 0.5}, {3, 2.5, 2.5})});
  FractureParameters p = cut_by({{1.5, 1, 1}});
  p.parts = Parts::kTogether;
  p.levels = {2};
  const Fractured whole = fracture_solid(solid, p);
  ASSERT_EQ(whole.set.fragments.size(), 1u);
  const Fragment& f = whole.set.fragments[0];
  const double common = 1 * 1.5 * 1.5;
  EXPECT_NEAR(f.density_share * f.mass.volume, 16 - common, 1e-9);
  StageTimings timings;
  const Expected<FracturedSolid> made =
      refracture(whole.solid, whole.diagram, p, {.fragment = f.id, .sites = 6, .seed = 1}, {}, timings);
  ASSERT_TRUE(made) << made.error().detail;
  double pieces = 0, clusters = 0;
  for (const Fragment& piece : made->set.fragments) {
    pieces += piece.density_share * piece.mass.volume;
    for (const FragmentPrimitive& primitive : piece.primitives) EXPECT_EQ(primitive.part, kNoIndex);
  }
  for (const Cluster& c : made->hierarchy.levels.at(0).clusters) clusters += c.density_share * c.volume;
  EXPECT_NEAR(pieces, 16 - common, 1e-9);
  EXPECT_NEAR(clusters, 16 - common, 1e-9);
}

// The same cubes, cut at x = 1/2. The first half of the first cube does not overlap anything, but has the density of its part.
TEST(PartJoins, TheUnbrokenFragmentWeighsAsMuchAsItsPieces) {
  const Solid solid = solid_in_contact({box({0, 0, 0}, {2, 2, 2}), box({1, 0.5, 0.5}, {3, 2.5, 2.5})});
  FractureParameters p = cut_by({{0, 1, 1}, {1, 1, 1}});
  p.parts = Parts::kTogether;
  p.intact = true;
  const Fractured whole = fracture_solid(solid, p);
  const Fragment& half = whole.set.fragments[fragment_at(whole.set, 0, {0.25, 1, 1})];
  ASSERT_NEAR(half.mass.volume, 2, 1e-9);
  StageTimings timings;
  const Expected<FracturedSolid> made =
      refracture(whole.solid, whole.diagram, p, {.fragment = half.id, .sites = 6, .seed = 1}, {}, timings);
  ASSERT_TRUE(made) << made.error().detail;
  ASSERT_TRUE(made->intact);
  ASSERT_EQ(made->intact->parts.size(), 1u);
  const Fragment& unbroken = made->intact->parts[0];
  const double share = (16 - 1 * 1.5 * 1.5) / 16;
  EXPECT_NEAR(unbroken.density_share * unbroken.mass.volume, share * 2, 1e-9);
  EXPECT_EQ(unbroken.source_part, half.source_part);
}

// Nested boxes weigh as much as the outermost one, however many there are.
TEST(PartJoins, NestedPartsWeighAsMuchAsTheOutermost) {
  std::vector<Mesh> boxes;
  for (int k = 0; k < 5; ++k)
    boxes.push_back(box({0.1 * k, 0.1 * k, 0.1 * k}, {2 - 0.1 * k, 2 - 0.1 * k, 2 - 0.1 * k}));
  const Fractured made = together(boxes, cut_by({{0.5, 1, 1}, {1.5, 1, 1}}));
  double sum = 0;
  for (const Fragment& f : made.set.fragments) sum += f.density_share * f.mass.volume;
  EXPECT_NEAR(sum, 8, 1e-6);
  EXPECT_NEAR(made.set.certificate.volume_once, 8, 1e-6);
}

// A bar that is cut, with twenty studs on it, each in one piece. A stud across a cut joins one piece of the bar and touches
// the other, so these two fragments share both a cut and a contact. Their bond is the sum.
TEST(PartJoins, ACutAndAContactOfTwoFragmentsAreOneBond) {
  std::vector<Mesh> parts{box({0, 0, 0}, {4, 1, 1})};
  for (int k = 0; k < 20; ++k) parts.push_back(box({0.2 * k, 1, 0}, {0.2 * k + 0.15, 1.1, 1}));
  FractureParameters p = wood_like(6);
  p.contact_strength = 0;
  const Fractured cut = together(parts, p);
  p.contact_strength = 0.5;
  const Fractured made = together(parts, p);
  ASSERT_EQ(made.set.fragments.size(), cut.set.fragments.size());
  std::map<std::pair<std::uint32_t, std::uint32_t>, Bond> cuts;
  for (const Bond& bond : cut.set.bonds) cuts[{bond.a, bond.b}] = bond;
  std::set<std::pair<std::uint32_t, std::uint32_t>> seen;
  std::size_t both = 0;
  double area = 0;
  for (const Bond& bond : made.set.bonds) {
    EXPECT_TRUE(seen.insert({bond.a, bond.b}).second) << bond.a << " and " << bond.b << " have two bonds";
    const auto of_cut = cuts.find({bond.a, bond.b});
    const double by_cut = of_cut == cuts.end() ? 0 : of_cut->second.area;
    const double by_contact = bond.area - by_cut;
    area += by_contact;
    EXPECT_NEAR(bond.area * bond.strength, by_cut + 0.5 * by_contact, 1e-12);
    EXPECT_NEAR(length(bond.normal), 1, 1e-12);
    if (by_cut == 0 || by_contact < 1e-6) continue;
    ++both;
    // Without the share of the cut, the centroid is on the bar's top.
    const Vec3d at = (1 / by_contact) * (bond.area * bond.centroid - by_cut * of_cut->second.centroid);
    EXPECT_NEAR(at.y, 1, 1e-6);
  }
  EXPECT_EQ(seen.size(), made.set.bonds.size());
  EXPECT_GE(both, 1u) << "nothing is tested above";
  EXPECT_GT(area, 0);
  EXPECT_LT(area, 20 * 0.15);  // most of the contacts are within fragments
}

// A hit in the lowest plank of forty: fragments of the upper half keep their ids and bytes.
TEST(PartJoins, AHitSeparatesOnlyThePartsNearIt) {
  FractureParameters p = wood_like(10);
  p.rest = LocalRest::kFractured;
  const Solid solid = solid_in_contact(stack_of_planks(40));
  const FragmentSet before = fracture_solid(solid, p).set;
  p.hits = {{{2, 0.1, 0.5}, 0.05, 6}};
  const FragmentSet after = fracture_solid(solid, p).set;
  std::size_t kept = 0, above = 0;
  for (const Fragment& f : before.fragments) {
    const auto same = std::find_if(after.fragments.begin(), after.fragments.end(),
                                   [&](const Fragment& g) { return g.id == f.id; });
    const bool is_kept = same != after.fragments.end() && same_shape(f, *same);
    kept += is_kept;
    if (*parts_of(f).begin() < 20) continue;
    ++above;
    EXPECT_GT(parts_of(f).size(), 1u);
    EXPECT_TRUE(is_kept) << "fragment " << f.id;
  }
  EXPECT_GE(above, 3u);
  EXPECT_LT(kept, before.fragments.size());
}

}  // namespace
}  // namespace fracture::test
