// Errors that the world must not make: create energy or speed, let objects sink into the ground, or notice a
// fall too late.
#include <gtest/gtest.h>

#include <cmath>

#include "client/world/world.hpp"
#include "tests/client/cubes.hpp"

namespace fracture::world {
namespace {

using test::cubes;
using test::run;
using test::whole_of;

/// The highest speed of any group at the end of a step.
double fastest_while(World& world, double seconds) {
  double fastest = 0;
  for (int k = 0; k < static_cast<int>(std::lround(seconds / world.settings().step)); ++k) {
    world.step();
    fastest = std::max(fastest, world.census().fastest);
  }
  return fastest;
}

/// A thin plate as a separate fragment: 20 × 20 cm, with this thickness in metres.
FragmentSet shard(double thickness) {
  FragmentSet set;
  Fragment fragment;
  fragment.id = 1;
  fragment.volume = 0.04 * thickness;
  const double mass = 2400 * fragment.volume, flat = mass * (0.04 + thickness * thickness) / 12;
  fragment.mass = {mass, glm::dvec3(0), glm::dmat3(flat, 0, 0, 0, mass * 0.08 / 12, 0, 0, 0, flat)};
  Hull hull;
  for (int k = 0; k < 8; ++k)
    hull.push_back({k & 1 ? 0.1 : -0.1, (k & 2 ? 0.5 : -0.5) * thickness, k & 4 ? 0.1 : -0.1});
  fragment.hulls = {hull};
  set.fragments.push_back(fragment);
  return set;
}

TEST(Physics, WhatFallsFastStopsAtTheGround) {
  for (const double height : {0.5, 3.0, 20.0})
    for (const double tilt : {0.0, 0.4, 1.5}) {
      World world;
      const FragmentSet set = shard(0.01);
      ObjectSpec spec = whole_of(set);
      spec.pose = {{0, height, 0}, glm::angleAxis(tilt, glm::normalize(glm::dvec3(1, 0.2, 0.5)))};
      const ObjectId object = world.add_object(spec);
      world.fracture(object, prepare(set));
      double lowest = 0;
      for (int k = 0; k < 600; ++k) {
        world.step();
        lowest = std::min(lowest, world.census().lowest);
      }
      // The lowest corner in any step; at 20 m/s a step is 16 cm long.
      EXPECT_GT(lowest, -0.003) << height << " " << tilt;
      EXPECT_LT(world.ledger().deepest, 0.001) << height << " " << tilt;
      EXPECT_EQ(world.census().moving, 0u) << height << " " << tilt;
    }
}

TEST(Physics, ABallThatWakesWhatSleepsIsInTheLedger) {
  World world;
  const FragmentSet set = shard(0.2);
  const ObjectId object = world.add_object(whole_of(set));
  world.fracture(object, prepare(set));
  const auto step_until = [&](const auto& done) {
    for (int k = 0; k < 1200 && !done(); ++k) world.step();
    return done();
  };
  ASSERT_TRUE(step_until([&] { return world.ledger().asleep_since.has_value(); }));
  const std::uint64_t slept = *world.ledger().asleep_since;
  EXPECT_EQ(world.ledger().last_woken, 0u);
  // A ball that rolls past wakes nothing.
  world.throw_ball({0.8, 0.1, 2}, {0, 0, -3}, 0.1, 7800);
  for (int k = 0; k < 240; ++k) world.step();
  EXPECT_EQ(world.ledger().last_woken, 0u);
  EXPECT_EQ(world.ledger().asleep_since, slept);
  world.throw_ball({0, 0.1, 2}, {0, 0, -3}, 0.1, 7800);
  ASSERT_TRUE(step_until([&] { return world.ledger().last_woken > 0; }));
  EXPECT_GT(world.ledger().last_woken, slept);
  EXPECT_FALSE(world.ledger().asleep_since);
  EXPECT_TRUE(step_until([&] { return world.ledger().asleep_since.has_value(); }));
}

TEST(Physics, AHeapGainsNoEnergy) {
  for (int turn = 0; turn < 6; ++turn) {
    World world;
    FragmentSet set = cubes(6, 6, 0.25, 2000, 2e4);
    ObjectSpec spec = whole_of(set);
    spec.strength = 10;
    spec.pose = {{0, 2 + 0.5 * turn, 0}, glm::angleAxis(0.3 * turn, glm::normalize(glm::dvec3(0.3, 0.1, 1)))};
    const ObjectId object = world.add_object(spec);
    const double at_first = world.ledger().brought;
    EXPECT_GT(at_first, 0);
    world.throw_ball({0.5, 1.2, 5}, {0, 1, -15}, 0.2, 7800);
    EXPECT_GT(world.ledger().brought, at_first);
    for (int k = 0; k < 900; ++k) {
      world.step();
      for (const Event& event : world.take_events())
        if (event.kind == Event::Kind::kBreak) world.fracture(object, prepare(set));
    }
    const Ledger& ledger = world.ledger();
    EXPECT_FALSE(world.is_whole(object)) << turn;
    EXPECT_LT(ledger.worst_gain, 0.01 * ledger.brought) << turn;
    EXPECT_LT(ledger.energy, ledger.brought) << turn;
  }
}

TEST(Physics, ARowOfLighterAndLighterPiecesIsNoWhip) {
  // A fast object elsewhere must not raise the limit here.
  for (const bool fast_ball_elsewhere : {false, true}) {
    WorldSettings settings;
    settings.gravity = glm::dvec3(0);
    World world(settings);
    // Cubes in a row, each half as large as the one before. Newton's cradle would end five times as fast.
    FragmentSet set;
    double x = 0, side = 0.6;
    for (std::uint32_t k = 0; k < 5; ++k, side /= 2) {
      Fragment fragment;
      fragment.id = k;
      fragment.volume = side * side * side;
      fragment.mass = test::cube_mass({x + side / 2, 0, 0}, side, 2000);
      fragment.hulls = {test::cube_hull({x + side / 2, 0, 0}, side)};
      set.fragments.push_back(fragment);
      x += side + 0.01;
    }
    set.restitution = 0.9;
    ObjectSpec spec = whole_of(set);
    spec.pose.position = {0, 10, 0};
    const ObjectId object = world.add_object(spec);
    world.fracture(object, prepare(set));
    world.throw_ball({-1, 10, 0}, {12, 0, 0}, 0.3, 7800);
    if (fast_ball_elsewhere) world.throw_ball({0, 500, 0}, {1000, 0, 0}, 0.2, 7800);
    const glm::dvec3 before = world.total_momentum().linear;
    EXPECT_LT(fastest_while(world, 1), 12.001);
    EXPECT_GT(world.census().fastest, 6);  // the pieces were hit
    EXPECT_LT(glm::distance(world.total_momentum().linear, before), 1e-9 * glm::length(before));
  }
}

TEST(Physics, AFallIsSeenAhead) {
  World world;
  ObjectSpec spec = whole_of(cubes(2, 2));
  spec.strength = 500;
  spec.pose.position = {0, 3, 0};
  const ObjectId object = world.add_object(spec);
  std::vector<Event> events;
  std::uint64_t ahead = 0, contact = 0;
  for (int k = 0; k < 240; ++k) {
    world.step();
    for (const Event& event : world.take_events()) {
      events.push_back(event);
      (event.kind == Event::Kind::kAhead ? ahead : contact) = world.steps();
    }
  }
  ASSERT_EQ(events.size(), 2u);  // once each
  EXPECT_EQ(events[0].kind, Event::Kind::kAhead);
  EXPECT_EQ(events[0].object, object);
  EXPECT_NEAR(events[0].impact.point.y, 0, 0.01);
  EXPECT_NEAR(events[0].impact.direction.y, 1, 1e-6);
  EXPECT_NEAR(events[0].where.y, 0, 0.02);
  EXPECT_EQ(events[1].kind, Event::Kind::kBreak);
  // A fall of 3 m takes 0.78 s; the world looks half a second ahead.
  EXPECT_NEAR(static_cast<double>(contact - ahead), 0.5 / world.settings().step, 6);
}

TEST(Physics, ABallThatRollsIsSeenAheadWhereItCouldBreakSomething) {
  for (const double speed : {4.0, 1.0}) {
    SCOPED_TRACE(speed);
    World world;
    ObjectSpec spec = whole_of(cubes(2, 2));
    spec.strength = 60;
    spec.held = true;
    world.add_object(spec);
    // 33 kg.
    world.throw_ball({0.5, 0.1, 1.5}, {0, 0, -speed}, 0.1, 7800);
    std::size_t ahead = 0, broken = 0;
    for (int k = 0; k < 240; ++k) {
      world.step();
      for (const Event& event : world.take_events())
        ++(event.kind == Event::Kind::kAhead && broken == 0 ? ahead : broken);
    }
    EXPECT_EQ(ahead, speed > 3 ? 1U : 0U);
    EXPECT_EQ(broken, speed > 3 ? 1U : 0U);
  }
}

TEST(Physics, NeighboursOfWhatIsHitAndWhatABallMeetsBehindItAreAskedForAhead) {
  World world;
  ObjectSpec spec = whole_of(cubes(1, 1, 0.5));
  spec.strength = 30;
  // Two objects that touch, one behind them in the path of the ball, and one to the side.
  std::vector<ObjectId> things;
  for (const glm::dvec3& place : {glm::dvec3(0, 0, 0), {0.499, 0, 0}, {0, 0, -1.5}, {3, 0, -1.5}}) {
    spec.pose.position = place;
    things.push_back(world.add_object(spec));
  }
  run(world, 0.5);  // they come to a halt
  EXPECT_TRUE(world.take_events().empty());
  world.throw_ball({0.25, 0.25, 4}, {0, 1, -20}, 0.1, 7800);
  std::vector<ObjectId> asked;
  for (int k = 0; k < 12; ++k) {  // of the 23 steps until the first is hit
    world.step();
    for (const Event& event : world.take_events()) {
      EXPECT_EQ(event.kind, Event::Kind::kAhead);
      asked.push_back(event.object);
    }
  }
  std::sort(asked.begin(), asked.end());
  EXPECT_EQ(asked, (std::vector<ObjectId>{things[0], things[1], things[2]}));
}

TEST(Physics, WhatTiltsOnItsSupportIsAskedForAhead) {
  World world;
  ObjectSpec spec = whole_of(cubes(1, 6, 0.25));  // a column
  spec.strength = 0.6 * spec.mass.mass;
  spec.pose.position = {0, 0, 0};
  spec.pose.rotation = glm::angleAxis(0.7, glm::dvec3(0, 0, 1));  // tilted beyond its edge
  const ObjectId object = world.add_object(spec);
  std::uint64_t ahead = 0, hit = 0;
  for (int k = 0; k < 480 && hit == 0; ++k) {
    world.step();
    for (const Event& event : world.take_events())
      (event.kind == Event::Kind::kAhead ? ahead : hit) = world.steps();
  }
  EXPECT_TRUE(world.expects_hit(object)) << "it was hit";
  ASSERT_GT(hit, 0u);
  ASSERT_GT(ahead, 0u);
  EXPECT_GE(hit, ahead + 12);  // a tenth of a second
}

TEST(Physics, AWrongGuessChangesNothing) {
  // The object might break as it falls, but does not. Its bonds could not bear the landing.
  World world;
  const FragmentSet set = cubes(4, 2, 0.25, 1000, 500);
  ObjectSpec spec = whole_of(set);
  spec.strength =
      2.4 * spec.mass.mass;  // the impulse if it stopped at once, but its corners land one after the other
  spec.pose = {{0, 0.35, 0}, glm::angleAxis(0.1, glm::dvec3(0, 0, 1))};
  const ObjectId object = world.add_object(spec);
  bool foreseen = false;
  for (int k = 0; k < 240; ++k) {
    world.step();
    for (const Event& event : world.take_events()) {
      ASSERT_EQ(event.kind, Event::Kind::kAhead);
      foreseen = true;
    }
    if (foreseen && world.is_whole(object)) world.fracture(object, prepare(set));
  }
  ASSERT_TRUE(foreseen);
  EXPECT_EQ(test::groups_of(world, object), 1u);
  EXPECT_TRUE(world.take_breaks().empty());
  // The same without anticipation: its bonds decide.
  World other;
  const ObjectId unguarded = other.add_object(spec);
  other.fracture(unguarded, prepare(set));
  run(other, 2);
  EXPECT_GT(test::groups_of(other, unguarded), 1u);
  // A hit beyond the object's strength breaks it, even though it was anticipated.
  world.throw_ball({0.5, 0.25, 4}, {0, 0.5, -30}, 0.15, 7800);
  run(world, 0.5);
  EXPECT_GT(test::groups_of(world, object), 1u);
  EXPECT_EQ(world.take_breaks().size(), 1u);
}

TEST(Physics, WhatIsWedgedUnderAHeavyBlockDoesNotLiftIt) {
  World world;
  // A block of two tonnes that overlaps light shards on the ground by two centimetres.
  const FragmentSet shards = cubes(4, 1, 0.1, 500, 0);
  ObjectSpec spec = whole_of(shards);
  const ObjectId below = world.add_object(spec);
  world.fracture(below, prepare(shards));
  ObjectSpec block = whole_of(cubes(1, 1, 1, 2000));
  block.pose.position = {-0.3, 0.08, 0};
  world.add_object(block);
  run(world, 3);
  EXPECT_LT(world.ledger().worst_gain, 1e-4 * world.ledger().brought);
}

TEST(Physics, AColumnThatLeansFallsAsAPendulumOverItsEdge) {
  const double half = 0.3, high = 1.4, mass = 1000, start = 0.3, end = 0.7;  // m, kg, rad
  ObjectSpec spec;
  spec.hulls.emplace_back();
  for (int k = 0; k < 8; ++k)
    spec.hulls[0].emplace_back(k & 1 ? half : -half, k & 2 ? high : -high, k & 4 ? half : -half);
  const double along = mass / 3 * (half * half + high * high), across = mass / 3 * 2 * half * half;
  spec.mass = {mass, glm::dvec3(0), glm::dmat3(along, 0, 0, 0, across, 0, 0, 0, along)};
  spec.strength = 1e9;
  const double arm = std::hypot(half, high), balanced = std::atan2(half, high);
  ASSERT_GT(start, balanced);
  spec.pose = {{0, arm * std::cos(start - balanced), 0}, glm::angleAxis(-start, glm::dvec3(0, 0, 1))};
  World world;
  const ObjectId object = world.add_object(spec);
  const auto tilt = [&] {
    const glm::dvec3 up = world.object_pose(object).rotation * glm::dvec3(0, 1, 0);
    return std::atan2(std::hypot(up.x, up.z), up.y);
  };
  double taken = 0;
  for (; tilt() < end; taken += world.settings().step) {
    ASSERT_LT(taken, 10) << "it leans by " << tilt();
    world.step();
  }
  // The same from rest by integration: (I + m arm²) φ'' = m g arm sin φ, with φ measured from the balanced
  // position.
  double expected = 0, angle = start - balanced, spin = 0;
  constexpr double kStep = 1e-5;  // seconds
  for (; angle < end - balanced; expected += kStep) {
    spin += kStep * mass * 9.81 * arm * std::sin(angle) / (along + mass * arm * arm);
    angle += kStep * spin;
  }
  EXPECT_NEAR(taken, expected, 0.1 * expected);
}

TEST(Physics, WhatLiesOrFallsSoftlyIsNotAskedForAhead) {
  World world;
  ObjectSpec spec = whole_of(cubes(2, 2));
  spec.strength = 2.5 * spec.mass.mass;  // the impulse of a fall of 0.3 m
  spec.pose.position = {0, 0.1, 0};
  world.add_object(spec);
  run(world, 3);
  EXPECT_TRUE(world.take_events().empty());
}

TEST(Physics, FragmentsThatComeLateGetNoMoreEnergyThanTheHitCost) {
  for (const std::uint64_t late : {1u, 12u, 60u}) {
    WorldSettings settings;
    settings.foresight = 0;
    World world(settings);
    FragmentSet set = cubes(5, 5, 0.3, 2000, 1e4);
    for (std::size_t k = 0; k < 5; ++k) set.fragments[k].anchored = true;
    ObjectSpec spec = whole_of(set);
    spec.held = true;
    spec.strength = 10;
    const ObjectId object = world.add_object(spec);
    world.throw_ball({0.75, 0.9, 2}, {0, 0.5, -12}, 0.15, 7800);
    std::optional<std::uint64_t> hit;
    for (int k = 0; k < 360; ++k) {
      world.step();
      for (const Event& event : world.take_events())
        if (event.kind == Event::Kind::kBreak) hit = world.steps();
      if (hit && world.is_whole(object) && world.steps() == *hit + late) world.fracture(object, prepare(set));
    }
    ASSERT_TRUE(hit);
    const auto breaks = world.take_breaks();
    ASSERT_EQ(breaks.size(), 1u);
    EXPECT_EQ(breaks[0].late, late);
    EXPECT_EQ(breaks[0].cause, Cause::kBall);
    EXPECT_LT(world.ledger().worst_gain, 0.01 * world.ledger().brought) << late;
  }
}

}  // namespace
}  // namespace fracture::world
