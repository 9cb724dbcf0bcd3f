#include "client/world/touching.hpp"

#include <gtest/gtest.h>

#include "client/world/bond_loads.hpp"
#include "tests/client/cubes.hpp"

namespace fracture::world {
namespace {

/// Two bonded cubes of 0.5 m in a row, moved by `shift`, at the end of `set`.
void add_pair(FragmentSet& set, const glm::dvec3& shift) {
  const auto first = static_cast<std::uint32_t>(set.fragments.size());
  FragmentSet pair = test::cubes(2, 1);
  for (Fragment& fragment : pair.fragments) {
    fragment.id += first;
    fragment.mass.center += shift;
    for (Hull& hull : fragment.hulls)
      for (glm::dvec3& p : hull) p += shift;
    set.fragments.push_back(fragment);
  }
  for (Bond bond : pair.bonds) {
    bond.a += first;
    bond.b += first;
    set.bonds.push_back(bond);
  }
}

TEST(TouchingParts, BecomeOne) {
  FragmentSet set;
  add_pair(set, {0, 0, 0});
  add_pair(set, {0, 0.5, 0});       // upon the first, a hair's breadth above it
  add_pair(set, {0.8, 0.25, 0.2});  // overlaps both
  add_pair(set, {0, 1.6, 0});       // hangs 10 cm above the second
  const double strength_of_an_area = set.bonds[0].strength / set.bonds[0].area;
  const std::size_t before = set.bonds.size();
  const std::size_t added = bond_touching_parts(set);
  EXPECT_EQ(set.bonds.size(), before + added);
  std::vector<std::uint32_t> members, bonds;
  for (std::uint32_t k = 0; k < set.fragments.size(); ++k) members.push_back(k);
  for (std::uint32_t k = 0; k < set.bonds.size(); ++k) bonds.push_back(k);
  const auto parts = components(members, bonds, set);
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_EQ(parts[0], (std::vector<std::uint32_t>{0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(parts[1], (std::vector<std::uint32_t>{6, 7}));
  for (std::size_t k = before; k < set.bonds.size(); ++k) {
    const Bond& bond = set.bonds[k];
    EXPECT_LT(bond.a, bond.b);
    EXPECT_GT(bond.area, 0);
    EXPECT_NEAR(bond.strength / bond.area, strength_of_an_area, 1e-9 * strength_of_an_area);
    EXPECT_NEAR(glm::length(bond.normal), 1, 1e-12);
  }
  EXPECT_EQ(bond_touching_parts(set), 0u);  // nothing is left to do
}

TEST(TouchingParts, WithoutBondsNothingIsKnownOfTheirStrength) {
  FragmentSet set = test::cubes(3, 1);
  set.bonds.clear();
  EXPECT_EQ(bond_touching_parts(set), 0u);
  EXPECT_TRUE(set.bonds.empty());
}

}  // namespace
}  // namespace fracture::world
