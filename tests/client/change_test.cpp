// A further hit on a fractured object: finer fragments replace some, and everything else stays.
#include "client/world/change.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "client/world/world.hpp"
#include "tests/client/cubes.hpp"

namespace fracture::world {
namespace {

using test::cube_hull;
using test::cube_mass;
using test::cubes;
using test::groups_of;
using test::run;
using test::struck_from_aside;
using test::whole_of;
using test::without_gravity;

constexpr double kSide = 0.5, kDensity = 1000;

/// The cubes with these numbers are replaced by eight smaller ones each, with ids from `next` on. They are
/// bonded to each other and to the cubes next to them.
FragmentChange eighths(const FragmentSet& set, const std::vector<std::uint32_t>& replaced,
                       double strength = 1e6, std::uint64_t next = 5000) {
  FragmentChange change;
  const double side = kSide / 2;
  std::vector<std::pair<std::uint64_t, glm::dvec3>> all;  // ids and centres after the change
  for (std::uint32_t k = 0; k < set.fragments.size(); ++k)
    if (std::find(replaced.begin(), replaced.end(), k) == replaced.end())
      all.emplace_back(set.fragments[k].id, set.fragments[k].mass.center);
  const std::size_t stay = all.size();
  for (const std::uint32_t k : replaced) {
    change.gone.push_back(set.fragments[k].id);
    for (int corner = 0; corner < 8; ++corner) {
      Fragment piece;
      piece.id = next++;
      const glm::dvec3 center =
          set.fragments[k].mass.center +
          0.5 * side * glm::dvec3(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
      piece.volume = side * side * side;
      piece.mass = cube_mass(center, side, kDensity);
      piece.hulls = {cube_hull(center, 0.999 * side)};
      piece.anchored = set.fragments[k].anchored;
      change.added.push_back(piece.id);
      change.fragments.push_back(piece);
      all.emplace_back(piece.id, center);
    }
  }
  for (std::size_t b = stay; b < all.size(); ++b)
    for (std::size_t a = 0; a < b; ++a) {
      const glm::dvec3 way = all[b].second - all[a].second, size = glm::abs(way);
      const double reach = a < stay ? 0.5 * (kSide + side) : side;
      // The cubes touch along one axis, and overlap along the other two.
      const int axis = size.x > size.y ? (size.x > size.z ? 0 : 2) : (size.y > size.z ? 1 : 2);
      bool beside = std::abs(size[axis] - reach) < 1e-6;
      for (int other = 0; other < 3; ++other)
        if (other != axis) beside = beside && size[other] < reach - 0.01;
      if (!beside) continue;
      glm::dvec3 normal(0);
      normal[axis] = way[axis] > 0 ? 1 : -1;
      Bond bond{.area = side * side, .strength = strength * side * side, .normal = normal};
      bond.center = all[b].second - 0.5 * side * normal;
      change.bonds.push_back(bond);
      change.ends.push_back({all[a].first, all[b].first});
    }
  return change;
}

std::vector<FragmentState> states_of(const World& world, ObjectId object) {
  std::vector<FragmentState> states;
  world.fragment_states(object, states);
  return states;
}

double mass_of(const World& world) { return world.total_momentum().mass; }

/// Prepares the change. A refusal fails the test.
std::shared_ptr<const PreparedFragments> prepared(const std::shared_ptr<const PreparedFragments>& before,
                                                  FragmentChange change) {
  auto result = prepare(before, std::move(change));
  if (!result) throw std::runtime_error(result.error().detail);
  return *result;
}

TEST(Change, KeepsTheNumbersOfWhatStays) {
  const FragmentSet set = cubes(3, 1);
  const auto changed = apply_change(set, eighths(set, {1}));
  ASSERT_TRUE(changed) << changed.error().detail;
  ASSERT_EQ(changed->set.fragments.size(), 11u);
  EXPECT_EQ(changed->replaced, std::vector<std::uint32_t>{1});
  EXPECT_EQ(changed->made, (std::vector<std::uint32_t>{3, 4, 5, 6, 7, 8, 9, 10}));
  for (const std::uint32_t k : {0u, 1u, 2u}) {
    EXPECT_EQ(changed->set.fragments[k].id, 1000 + k);
    EXPECT_EQ(changed->set.fragments[k].gone, k == 1);
  }
  // Both bonds of the three cubes led to the middle one. Now four bonds lead to each of its neighbours, and
  // twelve connect the eight new cubes.
  EXPECT_EQ(changed->first_bond, 2u);
  for (std::size_t k = 0; k < changed->set.bonds.size(); ++k)
    EXPECT_EQ(changed->set.bonds[k].gone, k < 2) << k;
  EXPECT_EQ(changed->set.bonds.size(), 2u + 12u + 4u + 4u);
}

TEST(Change, WhatChangedKeepsItsNumberToo) {
  const FragmentSet set = cubes(2, 1);
  FragmentChange change;
  change.changed = {1001};
  change.fragments = {set.fragments[1]};
  change.fragments[0].volume = 0.1;
  Bond bond = set.bonds[0];
  bond.area = 0.05;
  change.bonds = {bond};
  change.ends = {{1001, 1000}};
  const auto changed = apply_change(set, change);
  ASSERT_TRUE(changed) << changed.error().detail;
  EXPECT_EQ(changed->replaced, std::vector<std::uint32_t>{1});
  EXPECT_EQ(changed->made, std::vector<std::uint32_t>{1});
  EXPECT_FALSE(changed->set.fragments[1].gone);
  EXPECT_EQ(changed->set.fragments[1].volume, 0.1);
  EXPECT_TRUE(changed->set.bonds[0].gone);
  EXPECT_EQ(changed->set.bonds[1].a, 1u);
  EXPECT_EQ(changed->set.bonds[1].b, 0u);
}

TEST(Change, OfAnotherSetIsATypedErrorThatSaysWhat) {
  const FragmentSet set = cubes(3, 1);
  const auto refusal = [&](auto&& spoil) {
    FragmentChange change = eighths(set, {1});
    spoil(change);
    const auto changed = apply_change(set, std::move(change));
    if (changed) return std::string("accepted");
    EXPECT_EQ(changed.error().code, ErrorCode::kMalformedMesh);
    return changed.error().detail;
  };
  const auto says = [](const std::string& detail, const char* what) {
    return detail.find(what) != std::string::npos;
  };
  EXPECT_TRUE(says(refusal([](FragmentChange& c) { c.gone[0] = 77; }), "77"));
  EXPECT_TRUE(says(refusal([](FragmentChange& c) { c.gone.push_back(1001); }), "1001"));
  EXPECT_TRUE(says(refusal([](FragmentChange& c) { c.changed.push_back(78); }), "78"));
  EXPECT_TRUE(says(refusal([](FragmentChange& c) { c.fragments[2].id = 1002; }), "1002"));
  EXPECT_TRUE(says(refusal([](FragmentChange& c) { c.ends[3].a = 1001; }), "1001"));
}

TEST(Change, AMovingGroupMovesOnAsOneBodyWithTheSameMomentum) {
  World world(without_gravity());
  const FragmentSet set = cubes(3, 2);
  const ObjectId object = struck_from_aside(world, set);
  const auto first = prepare(set);
  world.fracture(object, first);
  world.take_swaps();
  const double mass = mass_of(world);
  const FragmentState before = states_of(world, object)[0];
  ASSERT_TRUE(world.change(object, prepared(first, eighths(set, {2, 4}))));
  EXPECT_EQ(groups_of(world, object), 1u);
  EXPECT_NEAR(mass_of(world), mass, 1e-9 * mass);
  const auto swaps = world.take_swaps();
  ASSERT_EQ(swaps.size(), 1u);
  EXPECT_EQ(swaps[0].fragments, 4u + 16u);
  EXPECT_EQ(swaps[0].broken_bonds, 0u);
  EXPECT_GT(glm::length(swaps[0].before.angular), 1);
  EXPECT_LT(glm::distance(swaps[0].before.linear, swaps[0].after.linear),
            1e-9 * glm::length(swaps[0].before.linear));
  EXPECT_LT(glm::distance(swaps[0].before.angular, swaps[0].after.angular),
            1e-9 * glm::length(swaps[0].before.angular));
  const std::vector<FragmentState> after = states_of(world, object);
  ASSERT_EQ(after.size(), 6u + 16u);
  for (std::size_t k = 0; k < after.size(); ++k) {
    EXPECT_EQ(after[k].present, k != 2 && k != 4) << k;
    if (!after[k].present) continue;
    EXPECT_LT(glm::distance(after[k].asset_to_world.position, before.asset_to_world.position), 1e-9);
    EXPECT_LT(glm::length(after[k].asset_to_world.rotation - before.asset_to_world.rotation), 1e-9);
  }
}

/// A row of cubes on the ground. The last cube has come off and lies next to the others.
struct Broken {
  World world{without_gravity()};
  FragmentSet set = cubes(4, 1);
  std::shared_ptr<const PreparedFragments> first;
  ObjectId object = 0;
  Broken() {
    std::erase_if(set.bonds, [](const Bond& bond) { return bond.a == 2; });
    object = world.add_object(whole_of(set));
    first = prepare(set);
    world.fracture(object, first);
    world.throw_ball({1.75, 0.25, 4}, {0, 0, -20}, 0.1, 2000);
    run(world, 0.4);
  }
};

TEST(Change, LooseFragmentsAreLeftAlone) {
  Broken broken;
  World& world = broken.world;
  ASSERT_EQ(groups_of(world, broken.object), 2u);
  const std::vector<FragmentState> before = states_of(world, broken.object);
  ASSERT_GT(glm::distance(before[3].asset_to_world.position, before[0].asset_to_world.position), 0.1);
  ASSERT_TRUE(world.change(broken.object, prepared(broken.first, eighths(broken.set, {2}))));
  EXPECT_EQ(groups_of(world, broken.object), 2u) << "nor are they bonded to what is new where they have been";
  const std::vector<FragmentState> after = states_of(world, broken.object);
  EXPECT_EQ(after[3].group, before[3].group);
  EXPECT_EQ(after[3].asset_to_world.position, before[3].asset_to_world.position);
  run(world, 0.1);
  const glm::dvec3 went =
      states_of(world, broken.object)[3].asset_to_world.position - after[3].asset_to_world.position;
  EXPECT_LT(went.z, 0) << "it flies on";
}

TEST(Change, OfWhatHasComeApartIsNone) {
  Broken broken;
  World& world = broken.world;
  const std::uint64_t fingerprint = world.fingerprint();
  EXPECT_FALSE(world.change(broken.object, prepared(broken.first, eighths(broken.set, {2, 3}))));
  EXPECT_EQ(world.fingerprint(), fingerprint);
  EXPECT_EQ(states_of(world, broken.object).size(), 4u);
}

TEST(Change, OfWhatIsThereNoMoreIsNone) {
  Broken broken;
  World& world = broken.world;
  const auto once = prepared(broken.first, eighths(broken.set, {1}));
  EXPECT_TRUE(world.change(broken.object, once));
  EXPECT_FALSE(world.change(broken.object, once));
  EXPECT_FALSE(world.change(broken.object, prepared(broken.first, eighths(broken.set, {0}))));
  EXPECT_FALSE(world.change(broken.object, nullptr));
}

TEST(Change, OneHitAfterAnother) {
  Broken broken;
  World& world = broken.world;
  auto now = prepared(broken.first, eighths(broken.set, {1}));
  ASSERT_TRUE(world.change(broken.object, now));
  FragmentChange next = eighths(broken.set, {0}, 1e6, 6000);
  // Its neighbour is no longer cube 1. The right half of cube 0 touches the left half of cube 1's pieces.
  for (std::size_t k = 0; k < next.ends.size(); ++k)
    if (next.ends[k].a == 1001) next.ends[k].a = next.ends[k].b - 1001;
  ASSERT_TRUE(world.change(broken.object, prepared(now, next)));
  EXPECT_EQ(groups_of(world, broken.object), 2u);
  std::size_t present = 0;
  for (const FragmentState& state : states_of(world, broken.object)) present += state.present;
  EXPECT_EQ(present, 2u + 8u + 8u);
}

TEST(Change, WhatStandsStaysHeldAndGainsNothing) {
  World world;
  FragmentSet set = cubes(3, 3, kSide, kDensity, 1e7);
  for (const std::size_t k : {0u, 1u, 2u}) set.fragments[k].anchored = true;
  ObjectSpec spec = whole_of(set);
  spec.held = true;
  const ObjectId object = world.add_object(spec);
  const auto first = prepare(set);
  world.fracture(object, first);
  run(world, 0.5);
  ASSERT_TRUE(world.change(object, prepared(first, eighths(set, {1, 4, 7}, 1e7))));
  run(world, 1);
  EXPECT_EQ(groups_of(world, object), 1u);
  for (const FragmentState& state : states_of(world, object))
    EXPECT_TRUE(!state.present || state.asset_to_world.position == glm::dvec3(0));
  EXPECT_EQ(mass_of(world), 0) << "all of it is held";
  EXPECT_NEAR(world.ledger().worst_gain, 0, 1e-9 * world.ledger().brought);
}

TEST(Change, WhatLiesOnTheGroundLiesOn) {
  World world;
  const FragmentSet set = cubes(3, 2, kSide, kDensity, 1e7);
  const ObjectId object = world.add_object(whole_of(set));
  const auto first = prepare(set);
  world.fracture(object, first);
  run(world, 0.5);
  ASSERT_TRUE(world.change(object, prepared(first, eighths(set, {0, 5}, 1e7))));
  run(world, 2);
  EXPECT_EQ(groups_of(world, object), 1u);
  EXPECT_NEAR(states_of(world, object)[1].asset_to_world.position.y, 0, 0.01);
  EXPECT_LT(world.ledger().worst_gain, 1e-3 * world.ledger().brought);
}

TEST(Change, ACrackThatWasThereIsThereStill) {
  // Cubes in a square: bonds 0-1, 0-2, 1-3, 2-3, in some order.
  const FragmentSet set = cubes(2, 2);
  const auto changed = apply_change(set, eighths(set, {0}));
  ASSERT_TRUE(changed) << changed.error().detail;
  std::vector<bool> broken;
  for (const Bond& bond : set.bonds) broken.push_back(bond.a == 0 && bond.b == 1);
  std::size_t cracked = 0, sound = 0;
  for (std::size_t k = changed->first_bond; k < changed->set.bonds.size(); ++k) {
    const Bond& bond = changed->set.bonds[k];
    const bool to_one = bond.a == 1 || bond.b == 1;
    EXPECT_EQ(is_cracked(*changed, set, k, broken), to_one) << bond.a << "-" << bond.b;
    ++(to_one ? cracked : sound);
  }
  EXPECT_EQ(cracked, 4u);
  EXPECT_EQ(sound, 12u + 4u);
}

TEST(Change, ABrokenBondOfTheGroupIsNotMended) {
  World world(without_gravity());
  FragmentSet set = cubes(2, 2);
  for (Bond& bond : set.bonds)
    if (bond.a == 0 && bond.b == 1) bond.strength = 0;  // any load breaks it
  const ObjectId object = world.add_object(whole_of(set));
  const auto first = prepare(set);
  world.fracture(object, first);
  world.throw_ball({0.25, -2, 0}, {0, 4, 0}, 0.1, 500);
  run(world, 1);
  const auto broken_of = [&](const FragmentSet& all) {
    const std::vector<float> loads = world.bond_states(object);
    std::size_t count = 0;
    for (std::size_t k = 0; k < loads.size(); ++k) count += loads[k] < 0 && !all.bonds[k].gone;
    return count;
  };
  ASSERT_EQ(broken_of(set), 1u);
  ASSERT_EQ(groups_of(world, object), 1u) << "the others go round";
  const auto now = prepared(first, eighths(set, {0}));
  ASSERT_TRUE(world.change(object, now));
  EXPECT_EQ(groups_of(world, object), 1u);
  EXPECT_EQ(broken_of(fragments_of(*now)), 4u) << "all that lead across it";
}

TEST(Change, IsAskedForWhereABallComesAtBondedFragmentsInTime) {
  const auto asked = [](double speed, double from, double strength) {
    World world;
    FragmentSet set = cubes(3, 3);
    for (const std::size_t k : {0u, 1u, 2u}) set.fragments[k].anchored = true;
    ObjectSpec spec = whole_of(set);
    spec.held = true;
    spec.strength = strength;
    world.fracture(world.add_object(spec), prepare(set));
    const BallId ball = world.throw_ball({0.75, 1, from}, {0, 0, -speed}, 0.1, 7800);
    std::vector<Event> events;
    for (int k = 0; k < 4; ++k) {
      world.step();
      for (const Event& event : world.take_events())
        if (event.kind == Event::Kind::kAgain) events.push_back(event);
    }
    for (const Event& event : events) {
      EXPECT_EQ(event.ball, ball);
      EXPECT_NEAR(event.impact.point.x, 0.75, 0.01);
      EXPECT_NEAR(event.impact.point.z, 0.25, 0.02);
      EXPECT_NEAR(event.impact.direction.z, -1, 0.01);
    }
    return events.size();
  };
  // 33 kg at 20 m/s: 650 N·s.
  EXPECT_EQ(asked(20, 6, 500), 1u) << "each four steps";
  EXPECT_EQ(asked(20, 6, 800), 0u) << "it bears that";
  EXPECT_EQ(asked(20, 1.5, 500), 0u) << "no answer would come in time";
  EXPECT_EQ(asked(20, 15, 500), 0u) << "farther than is foreseen";
}

// Only the newer fragment lists a pair. When the other one is replaced, the pair is gone.
TEST(Change, APairOfAReplacedFragmentIsForgottenByTheOther) {
  FragmentSet set = cubes(3, 1, kSide);
  set.fragments[0].apart = {set.fragments[1].id, set.fragments[2].id};
  const Expected<ChangedFragments> changed = apply_change(set, eighths(set, {1}));
  ASSERT_TRUE(changed) << changed.error().detail;
  EXPECT_EQ(changed->set.fragments[0].apart, std::vector<std::uint64_t>{set.fragments[2].id});
}

}  // namespace
}  // namespace fracture::world
