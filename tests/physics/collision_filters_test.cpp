#include "common/physics/collision_filters.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "common/base/id.hpp"
#include "common/base/random.hpp"

namespace fracture::test {
namespace {

/// As KHR_physics_rigid_bodies has it: one of the two lists the system of the other.
bool collide(const CollisionFilters& filters, std::uint32_t a, std::uint32_t b) {
  if (filters.of_body.empty() || filters.of_body[a] == kNoIndex || filters.of_body[b] == kNoIndex)
    return true;
  const CollisionFilters::Filter &x = filters.filters[filters.of_body[a]],
                                 &y = filters.filters[filters.of_body[b]];
  const auto lists = [](const CollisionFilters::Filter& one, std::uint32_t system) {
    return std::find(one.excluded.begin(), one.excluded.end(), system) != one.excluded.end();
  };
  return !lists(x, y.system) && !lists(y, x.system);
}

/// Exactly the pairs, but for those beyond, are excluded.
CollisionFilters expect_exact(std::uint32_t bodies, const std::vector<BodyPair>& pairs) {
  const CollisionFilters filters = make_collision_filters(bodies, pairs, {});
  EXPECT_LE(filters.systems, kMostCollisionSystems);
  for (const CollisionFilters::Filter& filter : filters.filters) {
    EXPECT_LT(filter.system, filters.systems);
    EXPECT_TRUE(std::find(filter.excluded.begin(), filter.excluded.end(), 0u) == filter.excluded.end());
  }
  for (std::uint32_t a = 0; a < bodies; ++a)
    for (std::uint32_t b = a + 1; b < bodies; ++b) {
      const bool excluded = std::binary_search(pairs.begin(), pairs.end(), BodyPair{a, b}) &&
                            !std::binary_search(filters.beyond.begin(), filters.beyond.end(), BodyPair{a, b});
      EXPECT_EQ(collide(filters, a, b), !excluded) << a << " " << b;
    }
  return filters;
}

TEST(CollisionFilters, AreNotTransitive) {
  const CollisionFilters filters = expect_exact(4, {{0, 1}, {1, 2}});
  EXPECT_EQ(filters.systems, 2u);  // bodies 0 and 2 are twins
  EXPECT_EQ(filters.of_body[3], kNoIndex);
}

TEST(CollisionFilters, OfNoPairsAreNone) {
  const CollisionFilters filters = expect_exact(3, {});
  EXPECT_EQ(filters.systems, 0u);
  EXPECT_TRUE(filters.filters.empty());
}

TEST(CollisionFilters, TwinsShareASystem) {
  std::vector<BodyPair> pairs;  // each of 40 bodies with each of 50 others
  for (std::uint32_t a = 0; a < 40; ++a)
    for (std::uint32_t b = 40; b < 90; ++b) pairs.push_back({a, b});
  const CollisionFilters filters = expect_exact(90, pairs);
  EXPECT_EQ(filters.systems, 2u);
  EXPECT_EQ(filters.filters.size(), 2u);
  EXPECT_TRUE(filters.beyond.empty());
}

TEST(CollisionFilters, AHubNeedsOneSystemHoweverManyBodiesItHas) {
  std::vector<BodyPair> pairs;  // three hubs with hundred bodies each
  for (std::uint32_t hub = 0; hub < 3; ++hub)
    for (std::uint32_t k = 0; k < 100; ++k) pairs.push_back({hub, 3 + 100 * hub + k});
  EXPECT_EQ(expect_exact(303, pairs).systems, 4u);
}

TEST(CollisionFilters, ThirtyOnePairsFitAndTheNextIsBeyond) {
  std::vector<BodyPair> pairs;
  for (std::uint32_t k = 0; k < 31; ++k) pairs.push_back({2 * k, 2 * k + 1});
  EXPECT_TRUE(expect_exact(64, pairs).beyond.empty());
  pairs.push_back({62, 63});
  const CollisionFilters filters = expect_exact(64, pairs);
  EXPECT_EQ(filters.beyond, (std::vector<BodyPair>{{62, 63}}));
  EXPECT_EQ(filters.systems, 32u);
}

TEST(CollisionFilters, ExcludeExactlyThePairsOfAnyGraph) {
  Random random(7);
  for (int round = 0; round < 60; ++round) {
    const std::uint32_t bodies = 5 + static_cast<std::uint32_t>(round);
    std::vector<BodyPair> pairs;
    const double density = 0.3 * random.uniform();
    for (std::uint32_t a = 0; a < bodies; ++a)
      for (std::uint32_t b = a + 1; b < bodies; ++b)
        if (random.uniform() < density) pairs.push_back({a, b});
    expect_exact(bodies, pairs);
  }
}

}  // namespace
}  // namespace fracture::test
