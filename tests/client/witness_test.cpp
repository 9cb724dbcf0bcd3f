// The world's reports for pictures and sounds.
#include <gtest/gtest.h>

#include <cmath>

#include "client/world/world.hpp"
#include "tests/client/cubes.hpp"

namespace fracture::world {
namespace {

using test::cubes;
using test::run;
using test::whole_of;

WorldSettings watched(std::size_t most = 1000) {
  WorldSettings settings;
  settings.max_witnessed = most;
  return settings;
}

TEST(Witness, ABoxThatFallsIsOneKnockWithItsMomentum) {
  World world(watched());
  ObjectSpec spec = whole_of(cubes(1, 1));
  spec.restitution = 0;
  spec.pose.position = {0, 1, 0};
  world.add_object(spec);
  const double fall = std::sqrt(2 * 9.81 * 1);  // m/s
  double impulse = 0, fastest = 0;
  for (int k = 0; k < 70; ++k) {  // it lands after 0.45 s
    world.step();
    const Witnessed seen = world.take_witnessed();
    if (k < 50) {
      EXPECT_TRUE(seen.knocks.empty()) << "nothing is met in the air";
    }
    for (const Knock& knock : seen.knocks) {
      impulse += knock.impulse;
      fastest = std::max(fastest, knock.approach);
      EXPECT_NEAR(knock.point.y, 0, 0.05);
      EXPECT_NEAR(std::abs(knock.normal.y), 1, 1e-6);
      const bool first = knock.a.kind == Knock::Side::Kind::kObject;
      const Knock::Side &box = first ? knock.a : knock.b, &ground = first ? knock.b : knock.a;
      EXPECT_EQ(box.kind, Knock::Side::Kind::kObject);
      EXPECT_DOUBLE_EQ(box.mass, spec.mass.mass);
      EXPECT_EQ(ground.kind, Knock::Side::Kind::kFixed);
    }
  }
  EXPECT_NEAR(fastest, fall, 0.15);
  EXPECT_NEAR(impulse, spec.mass.mass * fall, 0.15 * spec.mass.mass * fall);
  run(world, 3);
  world.take_witnessed();
  run(world, 1);
  EXPECT_TRUE(world.take_witnessed().knocks.empty()) << "it lies";
}

TEST(Witness, EveryBrokenBondIsOneCrackWhereItWas) {
  World world(watched());
  const FragmentSet set = cubes(6, 5, 0.5, 1000, 3e4);
  FragmentSet standing = set;
  for (std::size_t k = 0; k < 6; ++k) standing.fragments[k].anchored = true;
  ObjectSpec spec = whole_of(standing);
  spec.held = true;
  const ObjectId object = world.add_object(spec);
  world.fracture(object, prepare(standing));
  world.throw_ball({1.5, 1.5, 4}, {0, 1, -20}, 0.2, 5000);
  std::size_t cracks = 0;
  for (int k = 0; k < 120; ++k) {
    world.step();
    for (const Crack& crack : world.take_witnessed().cracks) {
      ++cracks;
      const Bond& bond = standing.bonds[crack.bond];
      EXPECT_EQ(crack.object, object);
      EXPECT_DOUBLE_EQ(crack.area, 0.25);
      EXPECT_NEAR(crack.mass, 125, 1e-9);
      if (k > 24) continue;  // the ball arrives after 21 steps, so the pieces have not gone far
      EXPECT_LT(glm::distance(crack.point, bond.center), 0.2);
    }
  }
  std::size_t broken = 0;
  for (const float load : world.bond_states(object)) broken += load < 0;
  EXPECT_GT(broken, 3u);
  EXPECT_EQ(cracks, broken);
}

TEST(Witness, NothingIsKeptUnlessAskedForAndNeverMoreThanThat) {
  const auto knocks = [](std::size_t most) {
    World world(watched(most));
    for (int k = 0; k < 10; ++k) {
      ObjectSpec spec = whole_of(cubes(1, 1));
      spec.pose.position = {2 * k, 1, 0};
      world.add_object(spec);
    }
    run(world, 1);
    return std::pair(world.take_witnessed().knocks.size(), world.fingerprint());
  };
  EXPECT_EQ(knocks(0).first, 0u);
  EXPECT_EQ(knocks(4).first, 4u);
  EXPECT_GE(knocks(1000).first, 10u);
  EXPECT_EQ(knocks(0).second, knocks(1000).second) << "watching changes nothing";
}

}  // namespace
}  // namespace fracture::world
