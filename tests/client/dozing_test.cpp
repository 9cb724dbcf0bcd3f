// Pieces of a heap fall asleep one by one, and wake when they must.
#include <gtest/gtest.h>

#include <vector>

#include "tests/client/cubes.hpp"

namespace fracture::world {
namespace {

constexpr double kCube = 0.2;
constexpr double kMoment = 1;  ///< seconds; Bullet lets nothing sleep before 1.2 s have passed

FragmentSet loose_cubes(int columns, int rows) {
  FragmentSet set = test::cubes(columns, rows, kCube);
  set.bonds.clear();
  return set;
}

/// A wall of loose cubes on the ground.
ObjectId wall_of(World& world, int columns, int rows) {
  const FragmentSet set = loose_cubes(columns, rows);
  const ObjectId id = world.add_object(test::whole_of(set));
  world.fracture(id, prepare(set));
  return id;
}

std::vector<glm::dvec3> centers(const World& world, ObjectId id, const FragmentSet& set) {
  std::vector<FragmentState> states;
  world.fragment_states(id, states);
  std::vector<glm::dvec3> result;
  for (std::size_t k = 0; k < states.size(); ++k)
    result.push_back(states[k].asset_to_world.point(set.fragments[k].mass.center));
  return result;
}

/// Adds `count` loose cubes, 3 m apart, beginning with number `first`.
void add_loose_cubes(World& world, int first, int count) {
  const FragmentSet one = loose_cubes(1, 1);
  for (int k = first; k < first + count; ++k) {
    ObjectSpec spec = test::whole_of(one);
    spec.pose.position.x = 3.0 * k;
    world.fracture(world.add_object(spec), prepare(one));
  }
}

/// The speed of a ball of 8 kg a tenth of a second after it met the first of several cubes that are far
/// apart.
double ball_after_hit(int cubes) {
  World world;
  add_loose_cubes(world, 0, cubes);
  test::run(world, kMoment);
  world.throw_ball({kCube / 2, kCube / 2, 0.8}, {0, 0, -8}, 0.1, 2000);
  const double before = 0.9 - kCube / 2;
  test::run(world, 0.2);
  const glm::dvec3 at = world.balls().at(0).pose.position;
  return (before - at.z) / 0.2;
}

TEST(Dozing, PiecesOfAHeapSleepBeforeItDoes) {
  World heap, few;
  wall_of(heap, 8, 6);
  wall_of(few, 6, 4);
  test::run(heap, kMoment);
  test::run(few, kMoment);
  EXPECT_LE(heap.census().moving, 1u);
  EXPECT_EQ(few.census().moving, 24u) << "which are no heap";
}

TEST(Dozing, NothingHangsInTheAirWhereItsSupportIsGone) {
  World world;
  const FragmentSet two = loose_cubes(1, 2);
  for (int k = 0; k < 25; ++k) {
    ObjectSpec spec = test::whole_of(two);
    spec.pose.position.x = 3.0 * k;
    world.fracture(world.add_object(spec), prepare(two));
  }
  test::run(world, kMoment);
  ASSERT_LE(world.census().moving, 1u);
  EXPECT_NEAR(centers(world, 0, two)[1].y, 1.5 * kCube, 0.01);
  world.throw_ball({kCube / 2, kCube / 2, 1}, {0, 0, -25}, 0.09, 7800);
  test::run(world, 2);
  EXPECT_LT(centers(world, 0, two)[1].y, 0.8 * kCube) << "the upper one lies where the lower one was";
  EXPECT_NEAR(centers(world, 1, two)[1].y, 1.5 * kCube, 0.01) << "and nothing else has changed";
}

TEST(Dozing, WhatBearsSomethingDoesNotFade) {
  for (const int others : {45, 0}) {
    WorldSettings settings;
    settings.debris_share = 0.2;
    settings.fade_after = 1;
    World world(settings);
    FragmentSet two = loose_cubes(1, 2);
    two.fragments[0].volume *= 0.1;  // the lower one would fade
    const ObjectId id = world.add_object(test::whole_of(two));
    world.fracture(id, prepare(two));
    add_loose_cubes(world, 1, others);
    test::run(world, 6);
    EXPECT_EQ(world.census().faded, 0u);
    EXPECT_EQ(world.census().moving, 0u);
    EXPECT_NEAR(centers(world, id, two)[1].y, 1.5 * kCube, 0.01);
  }
}

TEST(Dozing, NothingHangsInTheAirWhereItsSupportHasFaded) {
  for (const int others : {45, 0}) {
    WorldSettings settings;
    settings.max_bodies = static_cast<std::size_t>(others) + 1;  // the smallest fades at once
    World world(settings);
    FragmentSet two = loose_cubes(1, 2);
    two.fragments[0].volume *= 0.1;
    const ObjectId id = world.add_object(test::whole_of(two));
    world.fracture(id, prepare(two));
    add_loose_cubes(world, 1, others);
    test::run(world, 6);
    ASSERT_EQ(world.census().faded, 1u);
    EXPECT_LT(centers(world, id, two)[1].y, 0.8 * kCube) << "where the lower one was; " << others;
    EXPECT_LT(world.ledger().worst_gain, 1e-3);
  }
}

TEST(Dozing, NothingHangsInTheAirWhereABallIsGone) {
  WorldSettings settings;
  settings.max_balls = 1;
  World world(settings);
  add_loose_cubes(world, 1, 45);
  world.throw_ball({0, 0.3, 0}, {0, 0, 0}, 0.3, 2000);
  world.add_static_box({{0.45, 0.6, 0}, {1, 0, 0, 0}},
                       {0.15, 0.6, 0.5});  // the cube between them lies on the ball
  world.add_static_box({{-0.45, 0.6, 0}, {1, 0, 0, 0}}, {0.15, 0.6, 0.5});
  world.add_static_box({{0, 0.6, 0.45}, {1, 0, 0, 0}}, {0.3, 0.6, 0.15});
  world.add_static_box({{0, 0.6, -0.45}, {1, 0, 0, 0}}, {0.3, 0.6, 0.15});
  FragmentSet one = loose_cubes(1, 1);
  const ObjectSpec plain = test::whole_of(one);
  ObjectSpec spec = plain;
  spec.pose.position = {-kCube / 2, 0.6, 0};
  const ObjectId id = world.add_object(spec);
  world.fracture(id, prepare(one));
  test::run(world, 2 * kMoment);
  ASSERT_GT(centers(world, id, one)[0].y, 0.65);
  ASSERT_LE(world.census().moving, 2u);
  world.throw_ball({-5, 0.1, 8}, {0, 0, 0}, 0.1, 2000);
  test::run(world, kMoment);
  ASSERT_EQ(world.balls().size(), 1u);
  EXPECT_LT(centers(world, id, one)[0].y, 0.3) << "it lies on the ground";
}

TEST(Dozing, NothingHangsInTheAirWhereWhatWasHeldBreaks) {
  World world;
  add_loose_cubes(world, 1, 45);
  const FragmentSet one = loose_cubes(1, 1);
  ObjectSpec shelf = test::whole_of(one), above = shelf;
  shelf.held = true;
  shelf.pose.position.y = 1;
  above.pose.position.y = 1 + kCube;
  const ObjectId held = world.add_object(shelf), id = world.add_object(above);
  world.fracture(id, prepare(one));
  test::run(world, 2 * kMoment);
  ASSERT_EQ(world.census().moving, 0u);
  ASSERT_NEAR(centers(world, id, one)[0].y, 1 + 1.5 * kCube, 0.01);
  world.fracture(held, prepare(one));  // nothing in it is anchored, so it falls
  test::run(world, 2);
  ASSERT_LT(centers(world, held, one)[0].y, 2 * kCube);
  EXPECT_LT(centers(world, id, one)[0].y, 2 * kCube) << "what lay on it has come down, too";
}

TEST(Dozing, WhatDozesIsHitLikeWhatIsAwake) {
  const double awake = ball_after_hit(1), dozing = ball_after_hit(45);
  EXPECT_GT(awake, 1) << "the ball flies on";
  EXPECT_NEAR(dozing, awake, 0.05 * awake);
}

TEST(Dozing, ABlastWakes) {
  World world;
  wall_of(world, 8, 6);
  test::run(world, kMoment);
  ASSERT_LE(world.census().moving, 1u);
  world.explode({{0.8, 0.5, 0.5}, 400, 5});
  EXPECT_GT(world.census().moving, 40u);
  EXPECT_GT(world.census().fastest, 0.1);
}

}  // namespace
}  // namespace fracture::world
