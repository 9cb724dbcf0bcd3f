// Each break is counted once, with its cause and with the delay of its fragments.
#include <gtest/gtest.h>

#include <optional>

#include "client/world/world.hpp"
#include "tests/client/cubes.hpp"

namespace fracture::world {
namespace {

using test::cubes;
using test::run;
using test::whole_of;

TEST(Breaks, OfFragmentsThatWereThereAreCountedWhenTheirBondsBreak) {
  World world;
  const FragmentSet set = cubes(4, 4, 0.5, 1000, 2e5);
  ObjectSpec spec = whole_of(set);
  spec.strength = 10;
  spec.pose.position = {0, 4, 0};
  const ObjectId object = world.add_object(spec);
  world.fracture(object, prepare(set));
  run(world, 0.8);  // a fall from 4 m takes 0.9 s
  EXPECT_TRUE(world.take_breaks().empty());
  run(world, 1);
  const auto breaks = world.take_breaks();
  ASSERT_EQ(breaks.size(), 1u);
  EXPECT_EQ(breaks[0].object, object);
  EXPECT_EQ(breaks[0].cause, Cause::kFall);
  EXPECT_EQ(breaks[0].late, 0u);
  EXPECT_GT(test::groups_of(world, object), 1u);
}

TEST(Breaks, OfWhatAPieceHitNameThePiece) {
  WorldSettings settings;
  settings.foresight = 0;
  World world(settings);
  const FragmentSet set = cubes(2, 2, 0.5, 1000, 1e3);
  ObjectSpec below = whole_of(set);
  below.strength = 300;
  const ObjectId whole = world.add_object(below);
  const FragmentSet one = cubes(1, 1);
  ObjectSpec above = whole_of(one);
  above.pose.position = {0.25, 5, 0};
  world.fracture(world.add_object(above), prepare(one));
  std::optional<std::uint64_t> hit;
  for (int k = 0; k < 180; ++k) {
    world.step();
    for (const Event& event : world.take_events())
      if (event.kind == Event::Kind::kBreak && event.object == whole && !hit) hit = world.steps();
  }
  ASSERT_TRUE(hit);
  world.fracture(whole, prepare(set));
  const auto breaks = world.take_breaks();
  ASSERT_EQ(breaks.size(), 1u);
  EXPECT_EQ(breaks[0].cause, Cause::kPiece);
  EXPECT_EQ(breaks[0].late, world.steps() - *hit);
}

}  // namespace
}  // namespace fracture::world
