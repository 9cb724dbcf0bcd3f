#include "client/world/steady_pairs.hpp"

#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionDispatch/btConvexConvexAlgorithm.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "client/world/compound_pairs.hpp"

namespace fracture::world {
namespace {

constexpr btScalar kStill = Steadiness::kStill;

btTransform at(const btVector3& place, const btVector3& axis = {0, 1, 0}, btScalar angle = 0) {
  return btTransform(btQuaternion(axis, angle), place);
}

class SteadinessOf {
 public:
  explicit SteadinessOf(btScalar size = 1) : box_(size * btVector3(2, 2, 1)) {
    object_.setCollisionShape(&box_);
  }
  bool holds(const btTransform& first, const btTransform& second) {
    const btCollisionObjectWrapper a(nullptr, &box_, &object_, first, -1, -1),
        b(nullptr, &box_, &object_, second, -1, -1);
    return steadiness_.holds(a, b);
  }
  void part(btScalar gap) { steadiness_.part(gap); }
  /// The distance from a corner to the middle in metres, if the size is 1.
  static constexpr btScalar kReach = 3;

 private:
  btBoxShape box_;
  btCollisionObject object_;
  Steadiness steadiness_;
};

TEST(Steadiness, WhatMovesTogetherIsSteady) {
  SteadinessOf pair;
  EXPECT_FALSE(pair.holds(at({0, 0, 0}), at({5, 0, 0}))) << "not seen before";
  EXPECT_TRUE(pair.holds(at({0, 0, 0}), at({5, 0, 0})));
  const btTransform moved = at({7, -3, 2}, {0, 0, 1}, 0.5 * Steadiness::kTurned);
  EXPECT_TRUE(pair.holds(moved, moved * at({5, 0, 0})));
}

TEST(Steadiness, WhatTurnsTogetherIsLookedAtAgain) {
  SteadinessOf pair;
  EXPECT_FALSE(pair.holds(at({0, 0, 0}), at({5, 0, 0})));
  int steady = 0;
  for (int step = 1; step <= 100; ++step) {
    const btTransform turned = at({0, 0, 0}, {0, 0, 1}, 0.1 * Steadiness::kTurned * step);
    steady += pair.holds(turned, turned * at({5, 0, 0}));
  }
  EXPECT_GE(steady, 80);
  EXPECT_LE(steady, 95) << "once for each hundredth of a radian";
}

TEST(Steadiness, SmallBodiesHaveLessRoom) {
  constexpr btScalar kSize = 0.005;  // 3 cm from corner to corner; contacts reach 0.3 mm
  SteadinessOf pair(kSize);
  EXPECT_FALSE(pair.holds(at({0, 0, 0}), at({0.02, 0, 0})));
  EXPECT_TRUE(pair.holds(at({0, 0, 0}), at({0.0201, 0, 0})));
  EXPECT_FALSE(pair.holds(at({0, 0, 0}), at({0.0202, 0, 0})));
}

TEST(Steadiness, SmallStepsAddUp) {
  SteadinessOf pair;
  EXPECT_FALSE(pair.holds(at({0, 0, 0}), at({5, 0, 0})));
  int steady = 0;
  for (int step = 1; step <= 100; ++step)
    steady += pair.holds(at({0, 0, 0}), at({5, 0.3 * kStill * step, 0}));
  EXPECT_EQ(steady, 75) << "three of four steps";
}

TEST(Steadiness, TurnsCountByWhatTheyMove) {
  for (const btScalar far : {0.5, 2.0}) {
    SteadinessOf pair;
    EXPECT_FALSE(pair.holds(at({0, 0, 0}), at({5, 0, 0})));
    const btScalar angle = far * kStill / SteadinessOf::kReach;
    EXPECT_EQ(pair.holds(at({0, 0, 0}), at({5, 0, 0}, {1, 1, 0}, angle)), far < 1) << far;
  }
}

TEST(Steadiness, WhatIsApartIsNotLookedAtBeforeItCanHaveCome) {
  SteadinessOf pair;
  EXPECT_FALSE(pair.holds(at({0, 0, 0}), at({7, 0, 0})));
  pair.part(0.5);
  EXPECT_TRUE(pair.holds(at({0, 0, 0}), at({6.51, 0, 0})));
  EXPECT_TRUE(pair.holds(at({0, 0, 0}, {0, 1, 0}, 1), at({0, 0, 0}, {0, 1, 0}, 1) * at({6.51, 0, 0})))
      << "however they turn together";
  EXPECT_FALSE(pair.holds(at({0, 0, 0}), at({6.49, 0, 0})));
  EXPECT_FALSE(pair.holds(at({0, 0, 0}), at({6.4, 0, 0}))) << "for one look alone";
}

TEST(Steadiness, WhatIsKnownOfNoGapIsLookedAtAsBefore) {
  SteadinessOf pair;
  EXPECT_FALSE(pair.holds(at({0, 0, 0}), at({5, 0, 0})));
  pair.part(0);
  EXPECT_FALSE(pair.holds(at({0, 0, 0}), at({5 + 1.1 * kStill, 0, 0})));
}

/// A pair of blocks with two hulls each, or a block and a hull, in a separate world.
class Blocks {
 public:
  Blocks(bool ours, bool second_is_compound)
      : configuration_(room()),
        dispatcher_(&configuration_),
        world_(&dispatcher_, &broadphase_, &configuration_) {
    if (ours) {
      const int compound = COMPOUND_SHAPE_PROXYTYPE, hull = CONVEX_HULL_SHAPE_PROXYTYPE;
      dispatcher_.registerCollisionCreateFunc(compound, compound, &compounds_);
      dispatcher_.registerCollisionCreateFunc(compound, hull, &compounds_);
      dispatcher_.registerCollisionCreateFunc(hull, compound, &compounds_);
    }
    for (const btScalar x : {-1.0, 1.0})
      for (const btScalar y : {-1.0, 1.0})
        for (const btScalar z : {-1.0, 1.0}) half_.addPoint(btVector3(x, y, z), false);
    half_.recalcLocalAabb();
    for (const btScalar x : {-1.0, 1.0}) block_.addChildShape(at({x, 0, 0}), &half_);
    first_.setCollisionShape(&block_);
    if (second_is_compound)
      second_.setCollisionShape(&block_);
    else
      second_.setCollisionShape(&half_);
    for (btCollisionObject* object : {&first_, &second_}) world_.addCollisionObject(object);
  }
  ~Blocks() {
    for (btCollisionObject* object : {&first_, &second_}) world_.removeCollisionObject(object);
  }
  /// The smallest distance of all contacts; 1 if there is none.
  btScalar distance(const btTransform& first, const btTransform& second) {
    first_.setWorldTransform(first);
    second_.setWorldTransform(second);
    world_.performDiscreteCollisionDetection();
    btScalar least = 1;
    for (int m = 0; m < dispatcher_.getNumManifolds(); ++m) {
      const btPersistentManifold& manifold = *dispatcher_.getManifoldByIndexInternal(m);
      for (int k = 0; k < manifold.getNumContacts(); ++k)
        least = btMin(least, manifold.getContactPoint(k).getDistance());
    }
    return least;
  }
  /// The normal of the deepest contact, from the first body to the second.
  btVector3 normal() {
    btVector3 normal(0, 0, 0);
    btScalar least = 1;
    for (int m = 0; m < dispatcher_.getNumManifolds(); ++m) {
      const btPersistentManifold& manifold = *dispatcher_.getManifoldByIndexInternal(m);
      for (int k = 0; k < manifold.getNumContacts(); ++k) {
        const btManifoldPoint& point = manifold.getContactPoint(k);
        if (!(point.getDistance() < least)) continue;
        least = point.getDistance();
        normal = manifold.getBody0() == &first_ ? -point.m_normalWorldOnB : point.m_normalWorldOnB;
      }
    }
    return normal;
  }

 private:
  static btDefaultCollisionConstructionInfo room() {
    btDefaultCollisionConstructionInfo info;
    // Bullet reserves 4096 of each, which takes longer than the test.
    info.m_defaultMaxPersistentManifoldPoolSize = info.m_defaultMaxCollisionAlgorithmPoolSize = 64;
    info.m_customCollisionAlgorithmMaxElementSize =
        static_cast<int>(std::max(sizeof(HullPair), sizeof(CompoundPair)));
    return info;
  }
  btConvexPenetrationDepthSolver* depths() {
    return static_cast<btConvexConvexAlgorithm::CreateFunc*>(
               configuration_.getCollisionAlgorithmCreateFunc(CONVEX_HULL_SHAPE_PROXYTYPE,
                                                              CONVEX_HULL_SHAPE_PROXYTYPE))
        ->m_pdSolver;
  }
  btDefaultCollisionConfiguration configuration_;
  HullPair::CreateFunc hulls_{depths()};
  CompoundPair::CreateFunc compounds_{hulls_};
  btCollisionDispatcher dispatcher_;
  btDbvtBroadphase broadphase_;
  btCollisionWorld world_;
  btConvexHullShape half_;
  btCompoundShape block_;
  btCollisionObject first_, second_;
};

TEST(SteadyPair, DepthsAreThoseThatBulletHas) {
  for (const bool compound : {true, false})
    for (const bool swapped : {true, false}) {
      SCOPED_TRACE(::testing::Message() << compound << swapped);
      Blocks ours(true, compound), bullet(false, compound);
      std::size_t touching = 0, late = 0;
      // One block is lowered onto the other, by a fifth of the still distance in each step. It rests there
      // and is lifted again.
      for (int step = 0; step < 400; ++step) {
        const btScalar down = step < 150 ? step : step < 250 ? 150 : 400 - step;
        const btTransform low = at({0, 0, 0}), high = at({0.1, 2.02 - 0.2 * kStill * down, 0.2});
        const btScalar expected = swapped ? bullet.distance(high, low) : bullet.distance(low, high),
                       distance = swapped ? ours.distance(high, low) : ours.distance(low, high);
        if ((distance < 1) != (expected < 1)) {
          ++late;
          continue;
        }
        EXPECT_NEAR(distance, expected, 1e-9) << step;
        touching += expected < 1;
      }
      EXPECT_GT(touching, 200u);
      EXPECT_LE(late, 10u) << "five steps where they come together, and where they part";
    }
}

/// A block lies on another. Both turn over together, and the contact normal turns with them.
TEST(SteadyPair, NormalsTurnWithTheBodies) {
  Blocks pair(true, true);
  for (int step = 0; step <= 200; ++step) {
    const btTransform turned = at({0, 0, 0}, {0, 0, 1}, 0.004 * step);
    EXPECT_LT(pair.distance(turned, turned * at({0.1, 1.99, 0.2})), 0.05);
    const btVector3 up = turned.getBasis() * btVector3(0, 1, 0);
    EXPECT_LT((pair.normal() - up).length(), 2 * Steadiness::kTurned) << step;
  }
}

TEST(SteadyPair, WhatIsPulledAwayHasNoContacts) {
  Blocks pair(true, true);
  const btTransform low = at({0, 0, 0});
  EXPECT_LT(pair.distance(low, at({0, 2.0, 0})), 0.05);
  EXPECT_LT(pair.distance(low, at({0, 2.0, 0})), 0.05) << "as it was";
  EXPECT_EQ(pair.distance(low, at({0, 2.5, 0})), 1);
  EXPECT_LT(pair.distance(low, at({0, 2.0, 0})), 0.05) << "and back";
}

/// Bullet also reports contacts between bodies that are near but do not overlap. Ours compares tighter boxes
/// and finds those later.
TEST(CompoundPair, WhatFliesPastHasContactsWhereBulletHasThem) {
  std::mt19937_64 random(3);
  const auto number = [&] { return std::uniform_real_distribution<double>(-1, 1)(random); };
  std::size_t touching = 0, apart = 0;
  for (int flight = 0; flight < 40; ++flight) {
    const bool compound = flight % 2 == 0;
    Blocks ours(true, compound);
    const btVector3 axis = btVector3(number(), number(), number() + 2).normalized(),
                    aside(number(), 1.5 + 1.5 * number(), number());
    for (int step = 0; step <= 200; ++step) {
      const double t = 0.01 * step - 1;
      const btTransform there = at(btVector3(8 * t, 0, 0) + aside, axis, 2 * t);
      // The reference has seen nothing before, because contacts kept from earlier steps may be deeper than
      // the present ones.
      const btScalar expected = Blocks(false, compound).distance(at({0, 0, 0}), there),
                     found = ours.distance(at({0, 0, 0}), there);
      if (expected <= 0) {
        EXPECT_LE(found, expected + 0.02) << flight << ", " << step;
        ++touching;
      } else if (expected == 1) {
        EXPECT_EQ(found, 1) << flight << ", " << step;
        ++apart;
      }
    }
  }
  EXPECT_GT(touching, 300u);
  EXPECT_GT(apart, 1000u);
}

}  // namespace
}  // namespace fracture::world
