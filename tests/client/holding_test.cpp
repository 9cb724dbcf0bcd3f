// While many bodies move, a break makes fewer and larger pieces.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <vector>

#include "tests/client/cubes.hpp"

namespace fracture::world {
namespace {

/// Sizes of the groups, ascending, after a ball has hit a wall of 12 times 12 cubes.
std::vector<std::size_t> groups_after_hit(std::size_t live) {
  WorldSettings settings;
  settings.live_bodies = live;
  World world(settings);
  const FragmentSet set = test::cubes(12, 12, 0.2, 2000, 2e4);
  ObjectSpec spec = test::whole_of(set);
  spec.reach = 4;
  spec.crack_front = 0.002;
  // Ten balls that move while the wall breaks.
  for (int k = 0; k < 10; ++k) world.throw_ball({20.0 + k, 5, 0}, {0, 0, 0}, 0.1, 1000);
  const ObjectId id = world.add_object(spec);
  world.fracture(id, prepare(set));
  world.throw_ball({1.2, 1.2, 0.6}, {0, 0, -20}, 0.2, 7800);
  test::run(world, 0.1);
  std::vector<FragmentState> states;
  world.fragment_states(id, states);
  std::map<std::uint32_t, std::size_t> count;
  for (const FragmentState& state : states) ++count[state.group];
  std::vector<std::size_t> sizes;
  for (const auto& [group, size] : count) sizes.push_back(size);
  std::sort(sizes.begin(), sizes.end());
  return sizes;
}

TEST(Holding, BeyondTheBudgetNothingSmallComesOff) {
  const std::vector<std::size_t> fine = groups_after_hit(1000), coarse = groups_after_hit(10);
  EXPECT_GT(fine.size(), 40u);
  EXPECT_EQ(fine.front(), 1u);
  EXPECT_GT(coarse.size(), 1u) << "it breaks";
  EXPECT_LT(coarse.size(), 33u) << "into no more than the shares of three hundredths that there are";
  EXPECT_GE(coarse.front(), 5u) << "144 cubes, of which the smallest piece has three hundredths";
}

}  // namespace
}  // namespace fracture::world
