#include "client/world/world.hpp"

#include <gtest/gtest.h>

#include "tests/client/cubes.hpp"

namespace fracture::world {
namespace {

using test::cubes;
using test::groups_of;
using test::run;
using test::struck_from_aside;
using test::whole_of;
using test::without_gravity;

constexpr double kMomentum = 1e-4;  ///< relative error that a swap may have

void expect_conserved(const Swap& swap) {
  EXPECT_FALSE(swap.held);
  EXPECT_LT(glm::distance(swap.before.linear, swap.after.linear),
            kMomentum * std::max(glm::length(swap.before.linear), 1e-3 * swap.before.mass));
  EXPECT_LT(glm::distance(swap.before.angular, swap.after.angular),
            kMomentum * std::max(glm::length(swap.before.angular), 1e-3 * swap.before.mass));
}

TEST(World, AWholeObjectFallsAndRestsOnTheGround) {
  World world;
  const FragmentSet set = cubes(2, 2);
  ObjectSpec spec = whole_of(set);
  spec.pose.position = {0, 1, 0};
  const ObjectId object = world.add_object(spec);
  run(world, 5);  // Bullet puts objects to sleep after two seconds of rest
  EXPECT_TRUE(world.is_whole(object));
  const Census census = world.census();
  EXPECT_EQ(census.moving, 0u);
  EXPECT_NEAR(world.object_pose(object).position.y, 0, 0.01);
  EXPECT_GT(census.lowest, -0.01);
}

TEST(World, ABondedSwapMovesOnAsOneBodyWithTheSameMomentum) {
  World world(without_gravity());
  const FragmentSet set = cubes(3, 2);
  const ObjectId object = struck_from_aside(world, set);
  ASSERT_GT(glm::length(world.total_momentum().angular), 1);
  const Pose before = world.object_pose(object);
  world.fracture(object, prepare(set));
  EXPECT_FALSE(world.is_whole(object));
  EXPECT_EQ(groups_of(world, object), 1u);
  const auto swaps = world.take_swaps();
  ASSERT_EQ(swaps.size(), 1u);
  EXPECT_EQ(swaps[0].fragments, 6u);
  EXPECT_EQ(swaps[0].broken_bonds, 0u);
  EXPECT_GT(glm::length(swaps[0].before.angular), 1);
  expect_conserved(swaps[0]);
  std::vector<FragmentState> states;
  world.fragment_states(object, states);
  for (const FragmentState& state : states) {
    EXPECT_LT(glm::distance(state.asset_to_world.position, before.position), 1e-9);
    EXPECT_LT(glm::length(state.asset_to_world.rotation - before.rotation), 1e-9);
  }
}

TEST(World, LooseFragmentsHaveTheMomentumOfTheWhole) {
  World world(without_gravity());
  FragmentSet set = cubes(3, 3);
  set.bonds.clear();
  ObjectSpec spec = whole_of(set);
  spec.pose.position = {0, 10, 0};
  const ObjectId object = world.add_object(spec);
  world.throw_ball({-2, 11.2, 0.1}, {20, 0, 1}, 0.2, 5000);
  run(world, 0.3);
  world.fracture(object, prepare(set));
  EXPECT_EQ(groups_of(world, object), 9u);
  const auto swaps = world.take_swaps();
  ASSERT_EQ(swaps.size(), 1u);
  EXPECT_EQ(swaps[0].groups, 9u);
  expect_conserved(swaps[0]);
}

TEST(World, AHeavierOrLighterAnswerStillHasTheMomentum) {
  World world(without_gravity());
  FragmentSet set = cubes(3, 1);
  ObjectSpec spec = whole_of(set);
  spec.mass.mass *= 1.3;  // the mass that was assumed for an open mesh
  spec.mass.inertia *= 1.5;
  spec.mass.center += glm::dvec3(0.05, 0, 0.02);
  spec.pose.position = {0, 10, 0};
  const ObjectId object = world.add_object(spec);
  world.throw_ball({-2, 10.4, 0}, {10, 0, 0}, 0.2, 5000);
  run(world, 0.4);
  set.bonds.clear();
  world.fracture(object, prepare(set));
  const auto swaps = world.take_swaps();
  ASSERT_EQ(swaps.size(), 1u);
  expect_conserved(swaps[0]);
}

TEST(World, AnImpactBeforeTheAnswerBreaksTheBondsItOverloads) {
  WorldSettings settings;
  settings.foresight = 0;  // the contact requests, not the anticipation
  World world(settings);
  const FragmentSet set = cubes(4, 4, 0.5, 1000, 2e5);
  ObjectSpec spec = whole_of(set);
  spec.strength = 10;
  spec.pose.position = {0, 4, 0};
  const ObjectId object = world.add_object(spec);
  std::vector<Event> events;
  while (events.empty()) {
    world.step();
    for (const Event& event : world.take_events()) events.push_back(event);
  }
  EXPECT_EQ(events[0].kind, Event::Kind::kBreak);
  EXPECT_EQ(events[0].object, object);
  EXPECT_GT(events[0].impact.impulse, 1000);  // 2 t that fell 4 m
  EXPECT_GT(events[0].impact.energy, 0);
  EXPECT_NEAR(events[0].impact.direction.y, 1, 0.1);
  EXPECT_NEAR(events[0].impact.point.y, 0, 0.05);
  run(world, 0.1);  // the answer is late
  world.fracture(object, prepare(set));
  const auto swaps = world.take_swaps();
  ASSERT_FALSE(swaps.empty());
  EXPECT_GT(swaps[0].broken_bonds, 0u);
  EXPECT_GT(groups_of(world, object), 1u);
  expect_conserved(swaps[0]);
}

TEST(World, ALightTouchAsksForNothing) {
  World world;
  ObjectSpec spec = whole_of(cubes(2, 2));
  spec.strength = 1e5;
  spec.pose.position = {0, 0.5, 0};
  world.add_object(spec);
  run(world, 2);
  EXPECT_TRUE(world.take_events().empty());
}

TEST(World, AnchorsHoldAndWhatHangsOnThemToo) {
  World world;
  FragmentSet set = cubes(1, 4, 0.5, 1000, 1e7);
  set.fragments[3].anchored = true;  // the top one; the others hang from it
  ObjectSpec spec = whole_of(set);
  spec.held = true;
  spec.pose.position = {0, 2, 0};
  const ObjectId object = world.add_object(spec);
  world.fracture(object, prepare(set));
  run(world, 2);
  EXPECT_EQ(groups_of(world, object), 1u);
  std::vector<FragmentState> states;
  world.fragment_states(object, states);
  for (const FragmentState& state : states) EXPECT_EQ(state.asset_to_world.position.y, 2);
}

TEST(World, WhatIsNotSupportedFalls) {
  World world;
  FragmentSet set = cubes(1, 4, 0.5, 1000, 1e9);
  set.fragments[3].anchored = true;
  set.bonds.erase(set.bonds.begin() + 1);  // between the second and the third
  ObjectSpec spec = whole_of(set);
  spec.held = true;
  spec.pose.position = {0, 2, 0};
  const ObjectId object = world.add_object(spec);
  world.fracture(object, prepare(set));
  run(world, 3);
  std::vector<FragmentState> states;
  world.fragment_states(object, states);
  EXPECT_EQ(groups_of(world, object), 2u);
  EXPECT_EQ(states[0].group, states[1].group);
  EXPECT_NEAR(states[0].asset_to_world.position.y, 0, 0.02);  // fell by 2 m, together
  EXPECT_EQ(states[3].asset_to_world.position.y, 2);
}

TEST(World, BondsTooWeakForTheWeightGiveWay) {
  World world;
  FragmentSet set = cubes(1, 4, 0.5, 1000, 1e3);  // 250 N each, less than a cube's 1.2 kN
  set.fragments[3].anchored = true;
  ObjectSpec spec = whole_of(set);
  spec.held = true;
  spec.pose.position = {0, 2, 0};
  const ObjectId object = world.add_object(spec);
  world.fracture(object, prepare(set));
  std::vector<FragmentState> states;
  world.fragment_states(object, states);
  EXPECT_NE(states[3].group, states[2].group);  // the bond that carries all three
  run(world, 2);
  world.fragment_states(object, states);
  for (const std::size_t k : {0u, 1u, 2u}) EXPECT_LT(states[k].asset_to_world.position.y, 1) << k;
}

TEST(World, ABallGoesThroughAWallAndLeavesTheRestStanding) {
  World world;
  FragmentSet set = cubes(9, 7, 0.4, 1800, 1e6);
  for (int k = 0; k < 9; ++k) set.fragments[static_cast<std::size_t>(k)].anchored = true;
  ObjectSpec spec = whole_of(set);
  spec.held = true;
  const ObjectId object = world.add_object(spec);
  world.fracture(object, prepare(set));
  ASSERT_EQ(groups_of(world, object), 1u);
  world.throw_ball({1.8, 1.6, 3}, {0, 0.5, -25}, 0.25, 7800);
  run(world, 1);
  EXPECT_GT(groups_of(world, object), 1u);
  ASSERT_EQ(world.balls().size(), 1u);
  EXPECT_LT(world.balls()[0].pose.position.z, -0.5);  // it came out behind the wall
  std::vector<FragmentState> states;
  world.fragment_states(object, states);
  for (const std::size_t corner : {0u, 8u, 54u, 62u}) EXPECT_EQ(states[corner].asset_to_world.position.z, 0);
  EXPECT_LT(world.census().fastest, 25.6);
}

TEST(World, GroupsSplitLaterUnderFurtherImpactsWithoutAServer) {
  World world;
  FragmentSet set = cubes(9, 3, 0.4, 1800, 3e6);
  for (int k = 0; k < 9; ++k) set.fragments[static_cast<std::size_t>(k)].anchored = true;
  ObjectSpec spec = whole_of(set);
  spec.held = true;
  const ObjectId object = world.add_object(spec);
  world.fracture(object, prepare(set));
  std::size_t last = 1;
  for (const double x : {0.8, 2.8}) {
    world.throw_ball({x, 1.0, 3}, {0, 0.5, -20}, 0.12, 7800);
    run(world, 0.5);
    EXPECT_GT(groups_of(world, object), last);
    last = groups_of(world, object);
  }
}

TEST(World, SplitsInFlightConserveMomentum) {
  World world(without_gravity());
  const FragmentSet set = cubes(5, 1, 0.4, 1800, 2e4);
  ObjectSpec spec = whole_of(set);
  spec.pose.position = {0, 5, 0};
  const ObjectId object = world.add_object(spec);
  world.fracture(object, prepare(set));
  world.take_swaps();
  world.throw_ball({0.2, 5.2, 3}, {0, 0, -20}, 0.15, 7800);
  const Momentum before = world.total_momentum();
  run(world, 0.5);
  EXPECT_GT(groups_of(world, object), 1u);
  const auto swaps = world.take_swaps();
  ASSERT_FALSE(swaps.empty());
  for (const Swap& swap : swaps) expect_conserved(swap);
  const Momentum after = world.total_momentum();
  // Ball and pieces together, over all contacts and splits.
  EXPECT_LT(glm::distance(before.linear, after.linear), 1e-6 * glm::length(before.linear));
}

TEST(World, ALargeFragmentThatIsHitHardAsksToBeBrokenAgain) {
  World world;
  FragmentSet set = cubes(2, 1, 1, 1000, 1e3);
  set.bonds.clear();
  ObjectSpec spec = whole_of(set);
  spec.strength = 500;
  spec.pose.position = {0, 6, 0};
  const ObjectId object = world.add_object(spec);
  world.fracture(object, prepare(set));
  world.take_swaps();
  std::vector<Event> events;
  for (int k = 0; k < 240 && events.empty(); ++k) {
    world.step();
    for (const Event& event : world.take_events())
      if (event.kind == Event::Kind::kBreakFragment) events.push_back(event);
  }
  ASSERT_FALSE(events.empty());
  const std::uint32_t fragment = events[0].fragment;
  // The pieces of the fragment: the same cube as 2 × 2 × 1 cubes of half the side.
  FragmentSet pieces = cubes(2, 2, 0.5);
  for (Fragment& piece : pieces.fragments) {
    const glm::dvec3 shift(fragment, 0, 0);
    piece.mass.center += shift;
    for (glm::dvec3& p : piece.hulls[0]) p += shift;
  }
  const auto made = world.fracture_fragment(object, fragment, prepare(pieces));
  ASSERT_TRUE(made);
  const auto swaps = world.take_swaps();
  ASSERT_EQ(swaps.size(), 1u);
  expect_conserved(swaps[0]);
  EXPECT_EQ(groups_of(world, *made), 4u);
  EXPECT_FALSE(world.fracture_fragment(object, fragment, prepare(pieces)));  // it no longer exists
  run(world, 3);
  EXPECT_GT(world.census().lowest, -0.01);
}

TEST(World, ABallOnItsWayIsSeenAhead) {
  World world;
  ObjectSpec spec = whole_of(cubes(4, 4));
  spec.held = true;
  spec.strength = 50;
  const ObjectId object = world.add_object(spec);
  world.throw_ball({1, 1, 5}, {0, 1, -15}, 0.2, 5000);
  world.step();
  std::vector<Event> events;
  for (int k = 0; k < 8; ++k) {
    world.step();
    for (const Event& event : world.take_events()) events.push_back(event);
  }
  ASSERT_EQ(events.size(), 1u);  // once
  EXPECT_EQ(events[0].kind, Event::Kind::kAhead);
  EXPECT_EQ(events[0].object, object);
  EXPECT_NEAR(events[0].impact.point.z, 0.25, 0.05);
  EXPECT_NEAR(events[0].impact.direction.z, -1, 0.05);
}

TEST(World, FragmentsThatTheFileKeepsApartDoNotCollide) {
  World world(without_gravity());
  FragmentSet set = cubes(2, 1);
  set.bonds.clear();
  set.fragments[1].apart = {set.fragments[0].id};  // after a hit only one of the two may say so
  // Their hulls overlap by half.
  set.fragments[1].mass.center.x -= 0.25;
  for (glm::dvec3& p : set.fragments[1].hulls[0]) p.x -= 0.25;
  ObjectSpec spec = whole_of(set);
  spec.pose.position = {0, 5, 0};
  const ObjectId object = world.add_object(spec);
  world.fracture(object, prepare(set));
  run(world, 0.5);
  EXPECT_LT(world.census().fastest, 1e-9);
  std::vector<FragmentState> states;
  world.fragment_states(object, states);
  EXPECT_LT(glm::distance(states[1].asset_to_world.position, glm::dvec3(0, 5, 0)), 1e-9);
}

TEST(World, EqualHistoriesGiveEqualBits) {
  const auto play = [] {
    World world;
    FragmentSet set = cubes(8, 6, 0.3, 1800, 8e4);
    for (int k = 0; k < 8; ++k) set.fragments[static_cast<std::size_t>(k)].anchored = true;
    ObjectSpec spec = whole_of(set);
    spec.held = true;
    const ObjectId object = world.add_object(spec);
    world.fracture(object, prepare(set));
    world.throw_ball({1.1, 1.0, 3}, {0.2, 1, -22}, 0.2, 7800);
    run(world, 1.5);
    EXPECT_GT(groups_of(world, object), 3u);
    return world.fingerprint();
  };
  EXPECT_EQ(play(), play());
}

TEST(World, TheFallenRestAndNothingIsBelowTheGround) {
  World world;
  FragmentSet set = cubes(5, 5, 0.3, 1800, 3e4);
  ObjectSpec spec = whole_of(set);
  spec.strength = 10;
  spec.pose = {{0, 2, 0}, glm::angleAxis(0.4, glm::dvec3(0, 0, 1))};
  const ObjectId object = world.add_object(spec);
  bool broken = false;
  for (int k = 0; k < 720; ++k) {
    world.step();
    for (const Event& event : world.take_events())
      if (event.kind == Event::Kind::kBreak && !broken) {
        world.fracture(object, prepare(set));
        broken = true;
      }
    EXPECT_GT(world.census().lowest, -0.01) << k;
  }
  EXPECT_TRUE(broken);
  EXPECT_GT(world.census().lowest, -0.01);
  EXPECT_EQ(world.census().moving, 0u);
}

}  // namespace
}  // namespace fracture::world
