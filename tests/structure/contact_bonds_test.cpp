// Bonds across parts, computed by hand: boxes whose contacts are rectangles.
#include "common/structure/contact_bonds.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <memory>

#include "common/contacts/contact_report.hpp"
#include "common/gltf/fracture_extras.hpp"
#include "common/structure/bond_graph.hpp"
#include "common/structure/support.hpp"
#include "tests/structure/in_contact.hpp"
#include "tests/support/same_bonds.hpp"

namespace fracture::test {
namespace {

void expect_bond(const std::optional<Bond>& bond, double area, const Vec3d& centroid, const Vec3d& normal) {
  ASSERT_TRUE(bond);
  EXPECT_NEAR(bond->area, area, 1e-12);
  EXPECT_NEAR(length(bond->centroid - centroid), 0, 1e-12);
  EXPECT_NEAR(length(bond->normal - normal), 0, 1e-12);
}

// Two boxes of 2 x 1 x 1, one on top of the other. The plane x = 1 cuts both.
const std::vector<Mesh> kStacked{box({0, 0, 0}, {2, 1, 1}), box({0, 1, 0}, {2, 2, 1})};
const std::vector<Vec3d> kLeftAndRight{{0.5, 1, 0.5}, {1.5, 1, 0.5}};

TEST(ContactBonds, OfTwoBoxesStacked) {
  const Fractured made = fracture_solid(solid_in_contact(kStacked), cut_by(kLeftAndRight));
  const FragmentSet& set = made.set;
  ASSERT_EQ(set.fragments.size(), 4u);
  EXPECT_EQ(set.bonds.size(), 4u);
  EXPECT_EQ(bonds_across(set).size(), 2u);
  for (const double x : {0.5, 1.5})
    expect_bond(bond_of(set, fragment_at(set, 0, {x, 0.5, 0.5}), fragment_at(set, 1, {x, 1.5, 0.5})), 1,
                {x, 1, 0.5}, {0, 1, 0});
  for (const std::uint32_t part : {0u, 1u})  // bonds over shared caps, as without contacts
    expect_bond(bond_of(set, fragment_at(set, part, {0.5, part + 0.5, 0.5}),
                        fragment_at(set, part, {1.5, part + 0.5, 0.5})),
                1, {1, part + 0.5, 0.5}, {1, 0, 0});
  for (const Bond& bond : set.bonds) EXPECT_EQ(bond.strength, 1);
}

// A sliver whose corners are on a line after rounding has no area, but its regions in two cells have a little. Its share of the
// contact's area, a billionth here, cannot become infinite.
TEST(ContactBonds, OfASliverWithoutAreaAreFinite) {
  Solid solid = solid_in_contact(kStacked);
  ContactGraph graph = *solid.contacts;
  ASSERT_EQ(graph.contacts.size(), 1u);
  ASSERT_EQ(graph.first_piece.size(), 2u);
  const Vec3d along{0.375, 0, 0.0625}, from{0.5, 1, 0.25};  // dyadic: the cross product is exactly 0
  const Vec3d last = from + 2.0 * along;
  graph.pieces.push_back({{from, from + along, last, last}, {0, 1, 0}, 0, 1e-9});
  graph.first_piece.back() = static_cast<std::uint32_t>(graph.pieces.size());
  solid.contacts = std::make_shared<const ContactGraph>(std::move(graph));
  const Fractured made = fracture_solid(std::move(solid), cut_by(kLeftAndRight));
  const std::vector<Bond> across = bonds_across(made.set);
  ASSERT_EQ(across.size(), 2u);
  for (const Bond& bond : across) EXPECT_NEAR(bond.area, 1, 1e-8);
}

// Bricks in a bond: the upper brick lies on half of each of two lower bricks. The cut at x = 0.75 leaves a
// quarter of the width on one side.
TEST(ContactBonds, OfAPartOnTwoOthersAreWhatEachFragmentCarries) {
  const Fractured made = fracture_solid(
      solid_in_contact({box({0, 0, 0}, {1, 1, 1}), box({1, 0, 0}, {2, 1, 1}), box({0.5, 1, 0}, {1.5, 2, 1})}),
      cut_by({{0.5, 1, 0.5}, {1, 1, 0.5}}));  // the plane x = 0.75
  const FragmentSet& set = made.set;
  ASSERT_EQ(set.fragments.size(), 5u);
  EXPECT_EQ(bonds_across(set).size(), 4u);
  const std::uint32_t left = fragment_at(set, 2, {0.6, 1.5, 0.5}),
                      right = fragment_at(set, 2, {1.1, 1.5, 0.5});
  const std::uint32_t first = fragment_at(set, 0, {0.4, 0.5, 0.5}),
                      second = fragment_at(set, 0, {0.9, 0.5, 0.5}),
                      third = fragment_at(set, 1, {1.5, 0.5, 0.5});
  expect_bond(bond_of(set, first, left), 0.25, {0.625, 1, 0.5}, {0, 1, 0});
  expect_bond(bond_of(set, second, right), 0.25, {0.875, 1, 0.5}, {0, 1, 0});
  expect_bond(bond_of(set, third, right), 0.5, {1.25, 1, 0.5}, {0, 1, 0});
  expect_bond(bond_of(set, second, third), 1, {1, 0.5, 0.5}, {1, 0, 0});
}

// A leg of 1/4 x 1/4 reaches 1/8 into a table top that is 1/4 thick. The contact is the square of the top's
// lower face inside the leg.
const std::vector<Mesh> kTable{box({-1, 0, -1}, {1, 0.25, 1}),
                               box({-0.125, -1, -0.125}, {0.125, 0.125, 0.125})};

TEST(ContactBonds, OfALegInATableTop) {
  const Fractured made = fracture_solid(solid_in_contact(kTable), cut_by({{-0.5, 0, 0}, {0.5, 0, 0}}));
  const FragmentSet& set = made.set;
  ASSERT_EQ(set.fragments.size(), 4u);
  EXPECT_EQ(bonds_across(set).size(), 2u);
  for (const double side : {-1.0, 1.0})
    expect_bond(
        bond_of(set, fragment_at(set, 0, {side / 2, 0.125, 0}), fragment_at(set, 1, {side / 16, -0.4, 0})),
        0.25 * 0.125, {side / 16, 0, 0}, {0, -1, 0});
}

// The cut at y = 1/16 divides both parts within the depth of the leg. The upper half of the top has no outer
// surface inside the leg.
TEST(ContactBonds, AreOfOuterSurfaceAlone) {
  const Fractured made = fracture_solid(solid_in_contact(kTable), cut_by({{0, 0, 0}, {0, 0.125, 0}}));
  const FragmentSet& set = made.set;
  ASSERT_EQ(set.fragments.size(), 4u);
  ASSERT_EQ(bonds_across(set).size(), 1u);
  expect_bond(bond_of(set, fragment_at(set, 0, {0, 0, 0}), fragment_at(set, 1, {0, -0.5, 0})), 0.0625,
              {0, 0, 0}, {0, -1, 0});
}

// A cube of side 1 in the middle of one of side 4. The surface of the inner cube is the contact; each half
// has half of it.
TEST(ContactBonds, OfAPartInsideAnother) {
  const Fractured made = fracture_solid(solid_in_contact({box({-2, -2, -2}, {2, 2, 2}), cube()}),
                                        cut_by({{-1, 0, 0}, {1, 0, 0}}));
  const FragmentSet& set = made.set;
  ASSERT_EQ(bonds_across(set).size(), 2u);
  for (const double side : {-1.0, 1.0}) {
    const auto bond = bond_of(set, fragment_at(set, 0, {side, 0, 0}), fragment_at(set, 1, {side / 4, 0, 0}));
    ASSERT_TRUE(bond);
    EXPECT_NEAR(bond->area, 3, 1e-12);  // 1 + 4 / 2
    // A face of area 1 at distance 1/2, and four of area 1/2 at 1/4. The normals of the four cancel, so the
    // face's outward normal remains.
    EXPECT_NEAR(length(bond->centroid - Vec3d{side * (0.5 + 4 * 0.5 * 0.25) / 3, 0, 0}), 0, 1e-12);
    EXPECT_NEAR(length(bond->normal - Vec3d{-side, 0, 0}), 0, 1e-12);
  }
}

TEST(ContactBonds, AddUpWithThoseBySharedCaps) {
  const std::vector<Bond> caps{{0, 1, 3, {1, 0, 0}, {1, 0, 0}}, {1, 2, 1, {0, 0, 0}, {1, 0, 0}}};
  const std::vector<Bond> contacts{{0, 1, 1, {5, 4, 0}, {0, 1, 0}, 0.5},
                                   {0, 2, 2, {7, 0, 0}, {0, 0, 1}, 0.5},
                                   {1, 2, 1, {2, 0, 0}, {-1, 0, 0}, 2},
                                   {3, 4, 1, {0, 0, 0}, {0, 0, 1}}};
  const std::vector<Bond> all = with_contact_bonds(caps, contacts, {});
  ASSERT_EQ(all.size(), 4u);
  EXPECT_EQ(all[0].area, 4);
  EXPECT_EQ(all[0].centroid, (Vec3d{2, 1, 0}));
  EXPECT_NEAR(length(all[0].normal - (1 / std::sqrt(10.0)) * Vec3d{3, 1, 0}), 0, 1e-15);
  EXPECT_EQ(all[0].strength, (3 + 0.5) / 4);
  EXPECT_TRUE(same_bits(all[1], contacts[1]));
  EXPECT_EQ(all[2].area, 2);
  EXPECT_EQ(all[2].normal, (Vec3d{1, 0, 0}));  // they cancel, and the areas are equal: that of the caps
  EXPECT_EQ(all[2].strength, 1.5);
  EXPECT_TRUE(same_bits(all[3], contacts[3]));
}

TEST(ContactBonds, NeedAGapWithinTheLimit) {
  const std::vector<Mesh> apart{box({0, 0, 0}, {1, 1, 1}), box({1.01, 0, 0}, {2.01, 1, 1})};
  const auto bonds = [&](std::optional<double> gap) {
    return bonds_across(fracture_solid(solid_in_contact(apart, gap), cut_by({{1, 0.5, 0.5}})).set);
  };
  EXPECT_TRUE(bonds(0.009).empty());
  ASSERT_EQ(bonds(0.011).size(), 1u);
  EXPECT_NEAR(bonds(0.011)[0].area, 1, 1e-12);
  EXPECT_TRUE(bonds({}).empty()) << "a thousandth of 2.01 m";
  const std::vector<Mesh> near{box({0, 0, 0}, {1, 1, 1}), box({1.001, 0, 0}, {2, 1, 1})};
  EXPECT_EQ(bonds_across(fracture_solid(solid_in_contact(near), cut_by({{1, 0.5, 0.5}})).set).size(), 1u);
}

const std::vector<Mesh> kRow{box({0, 0, 0}, {1, 1, 1}), box({1, 0, 0}, {2, 1, 1}), box({2, 0, 0}, {3, 1, 1})};

// Three planks in a row. A wall holds the first one.
TEST(ContactBonds, HoldWhatIsNotAnchored) {
  FractureParameters p = cut_by({{1.5, 0.5, 0.5}});
  p.anchors.planes = {{{1, 0, 0}, 0}};
  const Fractured made = fracture_solid(solid_in_contact(kRow), p);
  const FragmentSet& set = made.set;
  ASSERT_EQ(set.fragments.size(), 3u);
  ASSERT_EQ(set.bonds.size(), 2u);
  EXPECT_EQ(made.anchored.count, 1u);
  const std::uint32_t first = fragment_at(set, 0, {}), second = fragment_at(set, 1, {}),
                      third = fragment_at(set, 2, {});
  EXPECT_FALSE(bond_of(set, first, third));
  expect_bond(bond_of(set, first, second), 1, {1, 0.5, 0.5}, {1, 0, 0});
  expect_bond(bond_of(set, second, third), 1, {2, 0.5, 0.5}, {1, 0, 0});

  const SupportOptions ten{.gravity = {0, -10, 0}, .density = 100, .strength = 1e9, .broken = {}};
  const Support stands = analyze_support(set, made.anchored, ten, {});
  EXPECT_TRUE(stands.falling.empty());
  const auto load = [&](std::uint32_t a, std::uint32_t b) {
    for (std::size_t k = 0; k < set.bonds.size(); ++k)
      if (set.bonds[k].a == std::min(a, b) && set.bonds[k].b == std::max(a, b)) return stands.loads[k].shear;
    return 0.0;
  };
  EXPECT_NEAR(load(first, second), 2 * 100 * 10, 1e-3);  // two planks hang on it
  EXPECT_NEAR(load(second, third), 100 * 10, 1e-3);

  SupportOptions broken = ten;
  broken.broken = {set.fragments[second].id};
  EXPECT_EQ(analyze_support(set, made.anchored, broken, {}).falling, std::vector<std::uint32_t>{third});

  p.contact_strength = 0;
  const Fractured loose = fracture_solid(solid_in_contact(kRow), p);
  EXPECT_TRUE(loose.set.bonds.empty());
  EXPECT_EQ(analyze_support(loose.set, loose.anchored, ten, {}).falling.size(), 2u);
}

TEST(ContactBonds, HaveAStrengthOfTheirOwn) {
  FractureParameters p = cut_by(kLeftAndRight);
  p.contact_strength = 0.25;
  p.levels = {1};
  const Fractured made = fracture_solid(solid_in_contact(kStacked), p);
  const FragmentSet& set = made.set;
  for (const Bond& bond : set.bonds) EXPECT_EQ(bond.strength, is_across(set, bond) ? 0.25 : 1);
  GltfOptions options;
  options.bond_strength = 1e5;
  const nlohmann::json bonds = fracture_extras(made, options)["bonds"];
  for (std::size_t k = 0; k < set.bonds.size(); ++k)
    EXPECT_NEAR(bonds["strength"][k].get<double>(), is_across(set, set.bonds[k]) ? 0.25e5 : 1e5, 1);

  // The loads are the same, but they differ relative to the strength.
  FragmentSet whole = set;
  for (Bond& bond : whole.bonds) bond.strength = 1;
  AnchoredFragments held{std::vector<char>(4, 0), 1};
  held.held[fragment_at(set, 0, {0.5, 0.5, 0.5})] = 1;
  SupportOptions asked;
  asked.strength = 1e9;
  const Support strong = analyze_support(whole, held, asked, {});
  for (std::size_t k = 0; k < set.bonds.size(); ++k) {
    if (!is_across(set, set.bonds[k]) || strong.loads[k].stress == 0) continue;
    asked.strength = 2 * strong.loads[k].stress;
    const auto weak = [&](const FragmentSet& of) {
      const std::vector<std::uint32_t> all = analyze_support(of, held, asked, {}).weak;
      return std::count(all.begin(), all.end(), k) > 0;
    };
    EXPECT_FALSE(weak(whole));
    EXPECT_TRUE(weak(set));
  }
}

// 4 m² of caps with strength 1 and 1 m² of a contact with strength 1/2: (4 + 0.5) / 5 = 0.9.
TEST(ContactBonds, OfClustersHaveTheMeanStrength) {
  const std::vector<Bond> bonds{{0, 2, 4, {}, {1, 0, 0}}, {1, 2, 1, {}, {1, 0, 0}, 0.5}};
  const std::vector<Bond> sums = bonds_between(bonds, {0, 0, 1});
  ASSERT_EQ(sums.size(), 1u);
  EXPECT_EQ(sums[0].area, 5);
  EXPECT_NEAR(sums[0].strength, 0.9, 1e-15);
}

TEST(ContactBonds, MakeOneGroupOfPartsInContact) {
  FractureParameters p = cut_by(kLeftAndRight);
  p.levels = {2};
  const Fractured made = fracture_solid(solid_in_contact(kStacked), p);
  ASSERT_EQ(made.hierarchy.levels.size(), 1u);
  ASSERT_EQ(made.hierarchy.levels[0].clusters.size(), 2u);
  EXPECT_EQ(made.hierarchy.levels[0].bonds.size(), 1u);
}

TEST(ContactBonds, LeaveBondsWithinAPartAsTheyAre) {
  FractureParameters p;
  p.parts = Parts::kApart;
  p.sites = 40;
  const std::vector<Mesh> parts{ico_sphere(3), translated(ico_sphere(2), {0.9, 0.1, 0}),
                                box({-2, -1.25, -2}, {2, -0.99, 2})};
  const FragmentSet with = fracture_solid(solid_in_contact(parts), p).set,
                    without = fracture_mesh(joined(parts), p).set;
  EXPECT_FALSE(bonds_across(with).empty());
  EXPECT_TRUE(bonds_across(without).empty());
  std::vector<Bond> within;
  for (const Bond& bond : with.bonds)
    if (!is_across(with, bond)) within.push_back(bond);
  ASSERT_EQ(within.size(), without.bonds.size());
  EXPECT_TRUE(same_bits(within, without.bonds));
  EXPECT_TRUE(std::is_sorted(with.bonds.begin(), with.bonds.end(), [](const Bond& x, const Bond& y) {
    return std::pair(x.a, x.b) < std::pair(y.a, y.b);
  }));
}

TEST(ContactReport, CountsAndListsTheLargestFirst) {
  const Fractured made = fracture_solid(
      solid_in_contact({kTable[0], kTable[1], box({-1, 0.25, -1}, {0, 1, 1}), box({5, 5, 5}, {6, 6, 6})},
                       0.001),
      cut_by({{0, 0, 0}}));
  ASSERT_TRUE(made.report.contacts);
  const ContactReport& report = *made.report.contacts;
  EXPECT_EQ(report.gap, 0.001);
  EXPECT_EQ(report.parts, 4u);
  EXPECT_EQ(report.alone, 1u);
  EXPECT_EQ(report.pairs, 2u);
  EXPECT_EQ(report.touching, 1u);
  EXPECT_EQ(report.overlapping, 1u);
  EXPECT_NEAR(report.area, 2 + 0.0625, 1e-12);
  EXPECT_NEAR(report.volume, 0.0625 * 0.125, 1e-12);
  ASSERT_EQ(report.listed.size(), 2u);
  EXPECT_EQ(report.listed[0].b, 2u);
  const nlohmann::json json = fracture_extras(made, {})["report"]["contacts"];
  EXPECT_EQ(json["listed"]["kind"], nlohmann::json({"touching", "overlapping"}));
  EXPECT_EQ(json["alone"], 1);
  EXPECT_FALSE(fracture_mesh(cube(), cut_by({{0, 0, 0}})).report.contacts);
  EXPECT_FALSE(fracture_solid(solid_in_contact({cube()}), cut_by({{0, 0, 0}})).report.contacts);
}

TEST(ContactReport, IsBounded) {
  std::vector<Mesh> bricks;
  for (int k = 0; k < 150; ++k) bricks.push_back(box({k * 1.0, 0, 0}, {k + 1.0, 1, 1 + k / 256.0}));
  const auto report = contact_report(solid_in_contact(bricks));
  ASSERT_TRUE(report);
  EXPECT_EQ(report->pairs, 149u);
  ASSERT_EQ(report->listed.size(), kMostListedContacts);
  EXPECT_EQ(report->listed[0].a, 148u);
  EXPECT_EQ(report->listed[99].a, 49u);
}

}  // namespace
}  // namespace fracture::test
