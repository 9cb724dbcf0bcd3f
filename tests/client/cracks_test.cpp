// A bond may break without splitting the body.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/client/cubes.hpp"

namespace fracture::world {
namespace {

TEST(Cracks, OneThatPartsNothingLeavesItsBody) {
  World world(test::without_gravity());
  // Four cubes in a square. One of the four bonds carries nothing; without it they are a chain.
  FragmentSet set = test::cubes(2, 2, 0.5, 1000, 1e9);
  set.bonds.back().strength = 1e-3;
  const ObjectId id = world.add_object(test::whole_of(set));
  world.fracture(id, prepare(set));
  std::vector<FragmentState> before, after;
  world.fragment_states(id, before);
  world.take_swaps();
  world.throw_ball({0.25, 0.25, 1.5}, {0, 0, -8}, 0.1, 2000);
  test::run(world, 0.3);
  const std::vector<float> bonds = world.bond_states(id);
  ASSERT_LT(bonds.back(), 0) << "the weak bond broke";
  ASSERT_EQ(std::count_if(bonds.begin(), bonds.end(), [](float load) { return load < 0; }), 1);
  world.fragment_states(id, after);
  for (std::size_t k = 0; k < after.size(); ++k)
    EXPECT_EQ(after[k].group, before[k].group) << "another body would be another group";
  // This counts as a swap.
  const std::vector<Swap> swaps = world.take_swaps();
  ASSERT_EQ(swaps.size(), 1u);
  EXPECT_EQ(swaps[0].groups, 1u);
  EXPECT_EQ(swaps[0].fragments, 4u);
  EXPECT_EQ(swaps[0].broken_bonds, 1u);
  EXPECT_GT(glm::length(swaps[0].before.linear), 1);
  EXPECT_EQ(swaps[0].after.linear, swaps[0].before.linear);
}

}  // namespace
}  // namespace fracture::world
