// The limits of a world: debris that fades, and the largest numbers of bodies and balls.
#include <gtest/gtest.h>

#include "client/world/world.hpp"
#include "tests/client/cubes.hpp"

namespace fracture::world {
namespace {

using test::cubes;
using test::run;
using test::whole_of;

TEST(World, SmallDebrisSleepsThenFades) {
  WorldSettings settings;
  settings.fade_after = 0.5;
  settings.fade_time = 0.25;
  settings.debris_share = 0.2;
  World world(settings);
  FragmentSet set = cubes(3, 1);
  set.bonds.clear();
  set.fragments[2].volume = 1e-3;  // the others are large
  ObjectSpec spec = whole_of(set);
  const ObjectId object = world.add_object(spec);
  world.fracture(object, prepare(set));
  run(world, 5);
  std::vector<FragmentState> states;
  world.fragment_states(object, states);
  EXPECT_TRUE(states[0].present);
  EXPECT_TRUE(states[1].present);
  EXPECT_FALSE(states[2].present);
  EXPECT_EQ(world.census().faded, 1u);
}

TEST(World, TheBudgetOfBodiesIsKeptBySmallestFirst) {
  WorldSettings settings;
  settings.max_bodies = 5;
  settings.fade_time = 0.1;
  World world(settings);
  FragmentSet set = cubes(8, 1);
  set.bonds.clear();
  for (std::size_t k = 0; k < 8; ++k) set.fragments[k].volume = 0.01 * static_cast<double>(k + 1);
  const ObjectId object = world.add_object(whole_of(set));
  world.fracture(object, prepare(set));
  run(world, 1);
  std::vector<FragmentState> states;
  world.fragment_states(object, states);
  for (std::size_t k = 0; k < 8; ++k) EXPECT_EQ(states[k].present, k >= 3) << k;
}

TEST(World, BallsAreLimitedToTheNewest) {
  WorldSettings settings;
  settings.max_balls = 3;
  World world(settings);
  for (int k = 0; k < 10; ++k) world.throw_ball({k, 1, 0}, glm::dvec3(0), 0.1, 1000);
  world.step();
  const auto balls = world.balls();
  ASSERT_EQ(balls.size(), 3u);
  EXPECT_EQ(balls.back().id, 10u);
}

}  // namespace
}  // namespace fracture::world
