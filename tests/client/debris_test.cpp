// Dust, crumbs and marks as numbers: how many, where, until when.
#include "client/effects/debris.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/client/cubes.hpp"

namespace fracture::effects {
namespace {

world::Witnessed cracked(std::size_t count = 1, double area = 0.02) {
  world::Witnessed seen;
  for (std::size_t k = 0; k < count; ++k)
    seen.cracks.push_back({.point = {0, 2, 0}, .normal = {1, 0, 0}, .area = area, .velocity = {0, 0, 3}});
  return seen;
}

world::Witnessed knocked(world::Knock::Side::Kind kind) {
  world::Knock knock;
  knock.point = {1, 0, 2};
  knock.impulse = 20;
  knock.approach = 4;
  knock.a.kind = kind;
  knock.a.mass = 5;
  return {{knock}, {}};
}

Debris after(const world::Witnessed& seen, const std::string& material, double seconds = 0,
             std::uint64_t seed = 1) {
  world::World world;
  Debris debris(seed);
  const auto named = [&](world::ObjectId) { return material; };
  debris.follow(world, seen, named);
  test::run(world, seconds);
  debris.follow(world, {}, named);
  return debris;
}

TEST(DebrisTest, NothingComesOfNothing) {
  const Debris debris = after({}, "glass", 1);
  EXPECT_TRUE(debris.crumbs().empty());
  EXPECT_TRUE(debris.puffs().empty());
  EXPECT_TRUE(debris.marks().empty());
}

TEST(DebrisTest, TheMaterialDecidesWhatComesOfABond) {
  const Debris concrete = after(cracked(50), "concrete"), glass = after(cracked(50), "glass"),
               metal = after(cracked(50), "metal");
  EXPECT_GT(concrete.puffs().size(), 3 * glass.puffs().size());
  EXPECT_GT(glass.crumbs().size(), concrete.crumbs().size());
  EXPECT_TRUE(metal.puffs().empty());
  EXPECT_LT(metal.crumbs().size(), concrete.crumbs().size() / 4);
  const Debris brick = after(cracked(5), "brick");
  for (const Puff& puff : brick.puffs())
    EXPECT_GT(puff.color.r, 1.5f * puff.color.b) << "brick's dust is red";
}

TEST(DebrisTest, ALargerBondGivesMore) {
  EXPECT_GT(after(cracked(30, 0.04), "stone").crumbs().size(),
            2 * after(cracked(30, 0.01), "stone").crumbs().size());
  EXPECT_TRUE(after(cracked(30, 0), "stone").crumbs().empty());
}

TEST(DebrisTest, CrumbsFlyOnWithWhatBrokeAndEndOnTheGround) {
  const Debris start = after(cracked(10), "concrete");
  ASSERT_GT(start.crumbs().size(), 20u);
  glm::vec3 mean(0);
  for (const Crumb& crumb : start.crumbs()) {
    mean += crumb.velocity / static_cast<float>(start.crumbs().size());
    EXPECT_LT(glm::distance(crumb.position, glm::vec3(0, 2, 0)), 0.09f);  // within the bond
    EXPECT_NEAR(crumb.position.x, 0, 1e-5f);                              // on its plane
  }
  EXPECT_NEAR(mean.z, 3, 0.5);
  const Debris fallen = after(cracked(10), "concrete", 4);
  ASSERT_EQ(fallen.crumbs().size(), start.crumbs().size());
  for (const Crumb& crumb : fallen.crumbs()) {
    EXPECT_GE(crumb.position.y, 0);
    EXPECT_LT(crumb.position.y, 0.02f);
    EXPECT_EQ(crumb.velocity, glm::vec3(0));
  }
}

TEST(DebrisTest, AllOfItGoes) {
  EXPECT_TRUE(after(cracked(10), "concrete", 3).puffs().empty());
  EXPECT_TRUE(after(cracked(10), "concrete", 10.1).crumbs().empty());
}

TEST(DebrisTest, ThereIsNeverMoreThanTheBounds) {
  const Debris debris = after(cracked(2000, 1), "concrete");
  EXPECT_EQ(debris.crumbs().size(), Debris::kMostCrumbs);
  EXPECT_EQ(debris.puffs().size(), Debris::kMostPuffs);
  world::World world;
  Debris marked;
  for (int k = 0; k < 500; ++k)
    marked.follow(world, knocked(world::Knock::Side::Kind::kObject), [](world::ObjectId) { return "stone"; });
  EXPECT_EQ(marked.marks().size(), Debris::kMostMarks);
}

TEST(DebrisTest, EqualSeedsGiveEqualDust) {
  const Debris a = after(cracked(), "ice", 0.5), b = after(cracked(), "ice", 0.5),
               other = after(cracked(), "ice", 0.5, 2);
  ASSERT_EQ(a.crumbs().size(), b.crumbs().size());
  for (std::size_t k = 0; k < a.crumbs().size(); ++k)
    EXPECT_EQ(a.crumbs()[k].position, b.crumbs()[k].position);
  ASSERT_FALSE(other.crumbs().empty());
  EXPECT_NE(a.crumbs()[0].position, other.crumbs()[0].position);
}

TEST(DebrisTest, HitsLeaveMarksOnTheGroundAndOnWhatTheyMeet) {
  // An intact object breaks where it is hit, so there would be nothing to mark.
  const Debris whole = after(knocked(world::Knock::Side::Kind::kObject), "concrete");
  ASSERT_EQ(whole.marks().size(), 1u);
  EXPECT_FALSE(whole.marks()[0].on_object);
  EXPECT_EQ(whole.marks()[0].position, glm::vec3(1, 0, 2));
  // A fragment carries the mark with it.
  world::World world;
  const world::FragmentSet set = test::cubes(2, 1);
  world::ObjectSpec spec = test::whole_of(set);
  spec.pose.position = {0, 5, 0};
  const world::ObjectId object = world.add_object(spec);
  world.fracture(object, world::prepare(set));
  world::Witnessed seen = knocked(world::Knock::Side::Kind::kObject);
  seen.knocks[0].a.object = object;
  seen.knocks[0].a.fragment = 1;
  seen.knocks[0].point = {0.75, 5.5, 0};
  Debris debris;
  debris.follow(world, seen, [](world::ObjectId) { return std::string("ceramic"); });
  ASSERT_EQ(debris.marks().size(), 2u);
  EXPECT_TRUE(debris.marks()[0].on_object);
  EXPECT_TRUE(debris.marks()[0].cracks);
  EXPECT_LT(glm::distance(debris.marks()[0].position, glm::vec3(0.75, 0.5, 0)), 1e-6f);
  // On a clear object the mark would appear on the objects behind it.
  Debris clear;
  clear.follow(world, seen, [](world::ObjectId) { return std::string("glass"); });
  ASSERT_EQ(clear.marks().size(), 1u);
  EXPECT_FALSE(clear.marks()[0].on_object);
  // The hit is too soft.
  seen.knocks[0].impulse = 0.1;
  Debris soft;
  soft.follow(world, seen, [](world::ObjectId) { return std::string("glass"); });
  EXPECT_TRUE(soft.marks().empty());
}

}  // namespace
}  // namespace fracture::effects
