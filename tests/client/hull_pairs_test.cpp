// Our algorithm skips GJK only for pairs in which Bullet finds no contact.
#include "client/world/hull_pairs.hpp"

#include <BulletCollision/CollisionDispatch/btConvexConvexAlgorithm.h>
#include <gtest/gtest.h>

#include <array>
#include <optional>
#include <random>
#include <vector>

namespace fracture::world {
namespace {

/// Two hulls in a separate world, with Bullet's algorithm or ours.
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
  /// Contact points (position and distance) with the second hull at `there`.
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
    // Bullet reserves 4096 of each, which takes longer than the test.
    info.m_defaultMaxPersistentManifoldPoolSize = info.m_defaultMaxCollisionAlgorithmPoolSize = 64;
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

/// Two hulls of twelve random corners, with both algorithms.
class HullPairTest : public ::testing::Test {
 protected:
  double coordinate() { return std::uniform_real_distribution<double>(-1, 1)(random_); }
  btVector3 vector() { return {coordinate(), coordinate(), coordinate()}; }
  void make_pairs() {
    ours_.reset();
    bullet_.reset();
    for (btConvexHullShape* hull : {&a_, &b_}) {
      *hull = {};
      for (int p = 0; p < 12; ++p) hull->addPoint(0.1 * vector());
      hull->setMargin(0.002);
    }
    bullet_.emplace(a_, b_, false);
    ours_.emplace(a_, b_, true);
  }
  /// GJK with another starting point ends at the same points, up to rounding.
  void expect_equal_contacts(const btTransform& there) {
    const auto expected = bullet_->contacts(there), found = ours_->contacts(there);
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t p = 0; p < found.size(); ++p)
      for (std::size_t c = 0; c < 4; ++c) ASSERT_NEAR(found[p][c], expected[p][c], 1e-10);
    changes_ += touched_ != !expected.empty();
    touched_ = !expected.empty();
    ++(touched_ ? touching_ : apart_);
  }

  std::mt19937_64 random_{7};
  btConvexHullShape a_, b_;
  std::optional<Pair> bullet_, ours_;
  bool touched_ = false;
  std::size_t touching_ = 0, apart_ = 0, changes_ = 0;
};

TEST_F(HullPairTest, HasTheContactsThatBulletHas) {
  for (int k = 0; k < 200; ++k) {
    make_pairs();
    // They pass each other while turning: apart, touching, apart.
    const btVector3 from = 0.25 * vector().normalized(), aside = 0.12 * vector(),
                    axis = vector().normalized();
    touched_ = false;
    for (int step = 0; step <= 40; ++step) {
      SCOPED_TRACE(::testing::Message() << "pair " << k << ", step " << step);
      const double t = step / 40.0;
      expect_equal_contacts(btTransform(btQuaternion(axis, 2 * t), (1 - 2 * t) * from + aside));
    }
  }
  EXPECT_GT(touching_, 500u);
  EXPECT_GT(apart_, 500u);
  EXPECT_GT(changes_, 100u);
}

TEST_F(HullPairTest, WhatItRemembersOfElsewhereDoesNotMislead) {
  for (int k = 0; k < 50; ++k) {
    make_pairs();
    touched_ = false;
    for (int jump = 0; jump < 60; ++jump) {
      SCOPED_TRACE(::testing::Message() << "pair " << k << ", jump " << jump);
      expect_equal_contacts(
          btTransform(btQuaternion(vector().normalized(), 3 * coordinate()), 0.16 * vector()));
    }
  }
  EXPECT_GT(touching_, 300u);
  EXPECT_GT(apart_, 300u);
  EXPECT_GT(changes_, 300u);
}

}  // namespace
}  // namespace fracture::world
