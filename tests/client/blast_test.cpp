// The effect of an explosion on whole objects, groups and loose pieces, and on the energy ledger.
#include <gtest/gtest.h>

#include <cmath>

#include "client/world/world.hpp"
#include "tests/client/cubes.hpp"

namespace fracture::world {
namespace {

using test::cubes;
using test::run;
using test::whole_of;

/// No gravity, so that only the blast changes momenta and energies.
WorldSettings weightless() {
  WorldSettings settings;
  settings.gravity = glm::dvec3(0);
  return settings;
}

TEST(Blast, PushesAwayByTheShareOfAllDirectionsAndLessWithDistance) {
  World world(weightless());
  constexpr double kRadius = 0.1, kDensity = 1000, kBlast = 5, kImpulse = 50;
  const double mass = kDensity * 4 / 3 * std::acos(-1.0) * std::pow(kRadius, 3);
  const std::vector<double> distances = {0.5, 1, 2, 4, 6};
  for (const double d : distances) world.throw_ball({d, 10, 0}, {}, kRadius, kDensity);
  world.explode({{0, 10, 0}, kImpulse, kBlast});
  const glm::dvec3 momentum = world.total_momentum().linear;
  double sum = 0;
  for (const double d : distances) {
    // The area of a cap of the unit sphere divided by the area of the sphere, 2π h / 4π.
    const double height = 1 - std::cos(std::asin(kRadius / d));
    sum += std::max(0.0, 1 - (d - kRadius) / kBlast) * kImpulse * height / 2;
  }
  EXPECT_NEAR(momentum.x, sum, 1e-9 * sum);
  EXPECT_NEAR(glm::length(momentum), momentum.x, 1e-12 * sum);
  const std::vector<BallState> before = world.balls();
  world.step();
  const std::vector<BallState> after = world.balls();
  std::vector<double> moved;
  for (std::size_t k = 0; k < before.size(); ++k)
    moved.push_back(after[k].pose.position.x - before[k].pose.position.x);
  for (std::size_t k = 1; k < moved.size(); ++k) EXPECT_GT(moved[k - 1], moved[k]);
  EXPECT_EQ(moved.back(), 0);  // beyond the radius
  EXPECT_GT(mass * moved[0] / world.settings().step,
            0.9 * kImpulse * (1 - 0.4 / kBlast) * 0.5 * (1 - std::cos(std::asin(0.2))));
}

TEST(Blast, WhatIsNearIsNoFasterThanTheGas) {
  World world(weightless());
  world.throw_ball({0.06, 10, 0}, {}, 0.05, 500);
  world.explode({{0, 10, 0}, 1e6, 5});
  const Momentum momentum = world.total_momentum();
  EXPECT_NEAR(glm::length(momentum.linear) / momentum.mass, 20, 1e-9);
}

TEST(Blast, ManyTogetherMakeNothingFasterThanTheGas) {
  World world(weightless());
  world.throw_ball({0.5, 10, 0}, {}, 0.05, 500);
  world.throw_ball({0, 10, 3}, {0, 0, 30}, 0.05, 500);  // it was faster before and must not become slower
  for (int k = 0; k < 50; ++k) world.explode({{0, 10, 0}, 1e4, 5});
  world.step();
  const std::vector<BallState> balls = world.balls();
  world.step();
  EXPECT_NEAR(world.balls()[0].pose.position.x - balls[0].pose.position.x, 20 * world.settings().step, 1e-4);
  EXPECT_NEAR(world.balls()[1].pose.position.z - balls[1].pose.position.z, 30 * world.settings().step, 1e-4);
}

TEST(Blast, TheLedgerCountsWhatItBrings) {
  World world(weightless());
  world.throw_ball({1, 10, 0}, {-3, 0, 0}, 0.2, 7800);  // towards the blast, which slows it
  world.throw_ball({0, 10, 2}, {0, 0, 4}, 0.2, 7800);
  const double before = world.ledger().brought;
  world.explode({{0, 10, 0}, 2000, 5});
  world.step();
  EXPECT_NE(world.ledger().brought, before);
  EXPECT_NEAR(world.ledger().energy, world.ledger().brought, 1e-3 * world.ledger().brought);
}

TEST(Blast, AWholeThatIsHitBeyondItsStrengthBreaksAndItsPiecesTakeTheBlast) {
  for (const std::uint64_t late : {0u, 6u, 60u}) {
    World world;
    const FragmentSet set = cubes(4, 4, 0.25, 2000, 2e4);
    ObjectSpec spec = whole_of(set);
    spec.strength = 200;
    spec.pose.position = {-0.5, 0, 0};
    const ObjectId object = world.add_object(spec);
    run(world, 0.2);
    world.take_events();
    world.explode({{0, 0.5, 0.4}, 2e4, 6});
    const std::vector<Event> events = world.take_events();
    ASSERT_EQ(events.size(), 1u);
    EXPECT_EQ(events[0].kind, Event::Kind::kBreak);
    EXPECT_EQ(events[0].object, object);
    EXPECT_GT(events[0].impact.impulse, spec.strength);
    EXPECT_LT(events[0].impact.direction.z, -0.9);
    EXPECT_NEAR(events[0].where.z, 0.125, 0.01);  // the face towards the blast
    for (std::uint64_t k = 0; k < late; ++k) world.step();
    EXPECT_LT(glm::length(world.total_momentum().linear), 1) << "it waits for its pieces";
    world.fracture(object, prepare(set));
    EXPECT_GT(test::groups_of(world, object), 8u);
    EXPECT_LT(world.total_momentum().linear.z, -100);
    const std::vector<Break> breaks = world.take_breaks();
    ASSERT_EQ(breaks.size(), 1u);
    EXPECT_EQ(breaks[0].cause, Cause::kBlast);
    EXPECT_EQ(breaks[0].late, late);
    run(world, 5);
    EXPECT_LT(world.ledger().worst_gain, 0.01 * world.ledger().brought) << late;
    EXPECT_LT(world.ledger().energy, world.ledger().brought);
  }
}

TEST(Blast, AWholeThatBearsItIsPushed) {
  World world(weightless());
  ObjectSpec spec = whole_of(cubes(2, 2));
  spec.pose.position = {-0.5, 10, 2};
  const ObjectId object = world.add_object(spec);
  world.explode({{0, 10.5, 0}, 20000, 6});
  EXPECT_TRUE(world.take_events().empty());
  EXPECT_GT(world.total_momentum().linear.z, 100);
  EXPECT_TRUE(world.is_whole(object));
}

TEST(Blast, WhereNoPiecesComeTheWholeIsPushedAndTheNextHitAsksAgain) {
  World world(weightless());
  ObjectSpec spec = whole_of(cubes(2, 2));
  spec.strength = 100;
  spec.pose.position = {-0.5, 10, 2};
  const ObjectId object = world.add_object(spec);
  const Blast blast{{0, 10.5, 0}, 20000, 6};
  world.explode(blast);
  EXPECT_EQ(world.take_events().size(), 1u);
  world.ask_again(object);
  const double pushed = world.total_momentum().linear.z;
  EXPECT_GT(pushed, 100);
  world.explode(blast);
  EXPECT_EQ(world.take_events().size(), 1u);
  EXPECT_NEAR(world.total_momentum().linear.z, pushed, 1e-9 * pushed);
}

TEST(Blast, AHeldWallBreaksWhereItIsAndItsAnchorsStay) {
  World world;
  FragmentSet set = cubes(6, 6, 0.25, 2000, 2e5);
  for (std::size_t k = 0; k < 6; ++k) set.fragments[k].anchored = true;
  ObjectSpec spec = whole_of(set);
  spec.held = true;
  spec.strength = 30;
  const ObjectId object = world.add_object(spec);
  world.explode({{0.75, 1.2, 0.5}, 4000, 3});
  ASSERT_EQ(world.take_events().size(), 1u);
  world.fracture(object, prepare(set));
  EXPECT_GT(test::groups_of(world, object), 4u);
  run(world, 2);
  std::vector<FragmentState> states;
  world.fragment_states(object, states);
  for (std::size_t k = 0; k < 6; ++k) EXPECT_EQ(states[k].asset_to_world.position, glm::dvec3(0)) << k;
  // The fragment nearest to the blast.
  EXPECT_LT(states[27].asset_to_world.point(set.fragments[27].mass.center).z, -0.2);
  EXPECT_LT(world.ledger().worst_gain, 0.01 * world.ledger().brought);
}

TEST(Blast, WhatHangsTogetherBreaksAtOnce) {
  World world;
  FragmentSet set = cubes(6, 6, 0.25, 2000, 2e5);
  for (std::size_t k = 0; k < 6; ++k) set.fragments[k].anchored = true;
  const ObjectId object = world.add_object(whole_of(set));
  world.fracture(object, prepare(set));
  run(world, 0.2);
  ASSERT_EQ(test::groups_of(world, object), 1u);
  world.explode({{0.75, 1.2, 0.5}, 4000, 3});
  EXPECT_TRUE(world.take_events().empty()) << "nothing has to be asked for";
  EXPECT_GT(test::groups_of(world, object), 4u);
  const std::vector<Break> breaks = world.take_breaks();
  ASSERT_EQ(breaks.size(), 1u);
  EXPECT_EQ(breaks[0].cause, Cause::kBlast);
  EXPECT_EQ(breaks[0].late, 0u);
  run(world, 2);
  EXPECT_LT(world.ledger().worst_gain, 0.01 * world.ledger().brought);
}

TEST(Blast, EqualOnesGiveEqualBits) {
  std::optional<std::uint64_t> fingerprint;
  for (int turn = 0; turn < 2; ++turn) {
    World world;
    const FragmentSet set = cubes(5, 5, 0.2, 2000, 2e4);
    ObjectSpec spec = whole_of(set);
    spec.pose.position = {0, 0.5, 0};
    const ObjectId object = world.add_object(spec);
    world.fracture(object, prepare(set));
    run(world, 0.3);
    world.explode({{0.5, 0.3, 0.3}, 3000, 4});
    run(world, 1);
    if (!fingerprint) fingerprint = world.fingerprint();
    EXPECT_EQ(world.fingerprint(), *fingerprint);
  }
}

TEST(Blast, NothingComesOfNone) {
  World world(weightless());
  world.throw_ball({0.5, 10, 0}, {}, 0.1, 1000);
  for (const Blast& blast : {Blast{{0, 10, 0}, 0, 5}, Blast{{0, 10, 0}, -1, 5}, Blast{{0, 10, 0}, 100, 0}})
    world.explode(blast);
  EXPECT_EQ(world.total_momentum().linear, glm::dvec3(0));
}

TEST(Blast, TheFirstThingOnAWayIsMet) {
  World world;
  ObjectSpec spec = whole_of(cubes(1, 1, 1));
  spec.pose.position = {0, 0, -5};
  world.add_object(spec);
  const auto met = world.first_met({0.5, 0.5, 5}, {0.5, 0.5, -50});
  ASSERT_TRUE(met);
  EXPECT_NEAR(met->z, -4.5, 0.01);
  const auto ground = world.first_met({5, 1, 0}, {5, -1, 0});
  ASSERT_TRUE(ground);
  EXPECT_NEAR(ground->y, 0, 1e-6);
  EXPECT_FALSE(world.first_met({0, 5, 0}, {0, 50, 0}));
}

}  // namespace
}  // namespace fracture::world
