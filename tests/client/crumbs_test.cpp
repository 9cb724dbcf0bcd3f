// The pieces that the world leaves out if more pieces move than it has time for.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/client/cubes.hpp"

namespace fracture::world {
namespace {

constexpr double kCrumb = 0.2;

/// Drops a tower of six loose cubes. Returns how high the highest one is after a second.
double height_of_heap(std::size_t live) {
  WorldSettings settings;
  settings.live_bodies = live;
  settings.debris_share = 0.2;  // each cube is smaller than this
  World world(settings);
  FragmentSet set = test::cubes(1, 6, kCrumb);
  set.bonds.clear();
  ObjectSpec spec = test::whole_of(set);
  spec.pose.position.y = 0.01;
  world.fracture(world.add_object(spec), prepare(set));
  test::run(world, 1);
  double highest = 0;
  std::vector<FragmentState> states;
  world.fragment_states(0, states);
  for (std::size_t k = 0; k < states.size(); ++k)
    highest = std::fmax(highest, states[k].asset_to_world.point(set.fragments[k].mass.center).y);
  EXPECT_LT(world.ledger().deepest, 0.005) << "the ground holds them";
  return highest;
}

TEST(Crumbs, BeyondTheBudgetSmallPiecesMeetOnlyWhatIsLarger) {
  EXPECT_NEAR(height_of_heap(100), 5.5 * kCrumb, 0.02) << "they carry one another";
  EXPECT_LT(height_of_heap(2), 3 * kCrumb) << "the upper four lie on the second, at the same place";
}

}  // namespace
}  // namespace fracture::world
