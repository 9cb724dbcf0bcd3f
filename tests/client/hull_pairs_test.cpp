// The pairs that are spared GJK are those that Bullet itself finds no contact for, and no others.
#include "client/world/hull_pairs.hpp"

#include <gtest/gtest.h>

#include <array>
#include <random>
#include <vector>

namespace fracture::world {
namespace {

/// Two hulls in a world of their own, with Bullet's algorithm or ours.
class Pair {
 public:
  Pair(const btConvexHullShape& a, const btConvexHullShape& b, bool ours)
      : configuration_(room()),
        dispatcher_(&configuration_),
        world_(&dispatcher_, &broadphase_, &configuration_),
        create_(static_cast<btConvexConvexAlgorithm::CreateFunc*>(
                    configuration_.getCollisionAlgorithmCreateFunc(CONVEX_HULL_SHAPE_PROXYTYPE,
                                                                   CONVEX_HULL_SHAPE_PROXYTYPE))
                    ->m_pdSolver) {
    if (ours)
      dispatcher_.registerCollisionCreateFunc(CONVEX_HULL_SHAPE_PROXYTYPE, CONVEX_HULL_SHAPE_PROXYTYPE,
                                              &create_);
    first_.setCollisionShape(const_cast<btConvexHullShape*>(&a));
    second_.setCollisionShape(const_cast<btConvexHullShape*>(&b));
    world_.addCollisionObject(&first_);
    world_.addCollisionObject(&second_);
  }
  ~Pair() {
    world_.removeCollisionObject(&first_);
    world_.removeCollisionObject(&second_);
  }
  /// Points of contact with the second hull there: positions and distances.
  std::vector<std::array<double, 4>> contacts(const btTransform& there) {
    second_.setWorldTransform(there);
    world_.performDiscreteCollisionDetection();
    std::vector<std::array<double, 4>> points;
    for (int m = 0; m < dispatcher_.getNumManifolds(); ++m) {
      const btPersistentManifold& manifold = *dispatcher_.getManifoldByIndexInternal(m);
      for (int k = 0; k < manifold.getNumContacts(); ++k) {
        const btManifoldPoint& p = manifold.getContactPoint(k);
        const btVector3& at = p.getPositionWorldOnB();
        points.push_back({at.x(), at.y(), at.z(), p.getDistance()});
      }
    }
    return points;
  }

 private:
  static btDefaultCollisionConstructionInfo room() {
    btDefaultCollisionConstructionInfo info;
    info.m_customCollisionAlgorithmMaxElementSize = sizeof(HullPair);
    return info;
  }
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_;
  btDbvtBroadphase broadphase_;
  btCollisionWorld world_;
  HullPair::CreateFunc create_;
  btCollisionObject first_, second_;
};

TEST(HullPair, HasTheContactsThatBulletHas) {
  std::mt19937_64 random(7);
  const auto coordinate = [&] { return std::uniform_real_distribution<double>(-1, 1)(random); };
  const auto vector = [&] { return btVector3(coordinate(), coordinate(), coordinate()); };
  std::size_t touching = 0, apart = 0, changes = 0;
  for (int k = 0; k < 200; ++k) {
    btConvexHullShape a, b;
    for (int p = 0; p < 12; ++p) {
      a.addPoint(0.1 * vector());
      b.addPoint(0.1 * vector());
    }
    a.setMargin(0.002);
    b.setMargin(0.002);
    Pair bullet(a, b, false), ours(a, b, true);
    // Past one another, turning: apart, touching, apart.
    const btVector3 from = 0.25 * vector().normalized(), aside = 0.12 * vector(),
                    axis = vector().normalized();
    bool touched = false;
    for (int step = 0; step <= 40; ++step) {
      const double t = step / 40.0;
      const btTransform there(btQuaternion(axis, 2 * t), (1 - 2 * t) * from + aside);
      const auto expected = bullet.contacts(there);
      ASSERT_EQ(ours.contacts(there), expected) << "pair " << k << ", step " << step;
      changes += touched != !expected.empty();
      touched = !expected.empty();
      ++(touched ? touching : apart);
    }
  }
  EXPECT_GT(touching, 500u);
  EXPECT_GT(apart, 500u);
  EXPECT_GT(changes, 100u);
}

}  // namespace
}  // namespace fracture::world
