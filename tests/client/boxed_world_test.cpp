// Our world has fewer pairs than Bullet's, but every contact.
#include "client/world/boxed_world.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <set>
#include <utility>
#include <vector>

namespace fracture::world {
namespace {

/// Cubes of 4 cm that fly towards one another, in Bullet's own world or in ours.
template <class World>
class Swarm {
 public:
  Swarm()
      : dispatcher_(&configuration_), world_(&dispatcher_, &tree_, &solver_, &configuration_), cube_(half()) {
    world_.setGravity({0, 0, 0});
    for (int k = 0; k < kSide * kSide * kSide; ++k) {
      const btVector3 cell(k % kSide, k / kSide % kSide, k / kSide / kSide);
      btRigidBody::btRigidBodyConstructionInfo info(1, nullptr, &cube_, {0.01, 0.01, 0.01});
      info.m_startWorldTransform = btTransform(btQuaternion(cell + btVector3(1, 1, 1), 0.2 * k), 0.1 * cell);
      bodies_.push_back(std::make_unique<btRigidBody>(info));
      bodies_.back()->setLinearVelocity(-0.2 * (cell - 0.5 * (kSide - 1) * btVector3(1, 1, 1)));
      bodies_.back()->setUserIndex(k);
      world_.addRigidBody(bodies_.back().get());
    }
  }
  ~Swarm() {
    for (const auto& body : bodies_) world_.removeRigidBody(body.get());
  }
  void step() { world_.stepSimulation(1.0 / 120, 0); }
  int pairs() { return world_.getPairCache()->getNumOverlappingPairs(); }
  /// The pairs of bodies that have a contact.
  std::set<std::pair<int, int>> touching() {
    std::set<std::pair<int, int>> found;
    for (int m = 0; m < dispatcher_.getNumManifolds(); ++m) {
      const btPersistentManifold& manifold = *dispatcher_.getManifoldByIndexInternal(m);
      if (manifold.getNumContacts() > 0)
        found.insert(std::minmax(manifold.getBody0()->getUserIndex(), manifold.getBody1()->getUserIndex()));
    }
    return found;
  }

 private:
  static constexpr int kSide = 4;
  static btVector3 half() { return {0.02, 0.02, 0.02}; }
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_;
  btDbvtBroadphase tree_;
  btSequentialImpulseConstraintSolver solver_;
  World world_;
  btBoxShape cube_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
};

TEST(BoxedWorld, HasFewerPairsAndEveryContact) {
  constexpr btScalar kTheirs = 0.05, kOurs = 0.01;  // a global variable of Bullet's
  Swarm<btDiscreteDynamicsWorld> bullet;
  Swarm<BoxedWorld> ours;
  std::size_t contacts = 0;
  // Both worlds move alike until the first cubes meet.
  for (int step = 0; step < 60 && contacts == 0; ++step) {
    gDbvtMargin = kTheirs;
    bullet.step();
    gDbvtMargin = kOurs;
    ours.step();
    EXPECT_EQ(ours.touching(), bullet.touching()) << step;
    contacts += bullet.touching().size();
    EXPECT_LT(2 * ours.pairs(), bullet.pairs());
  }
  EXPECT_GT(contacts, 0u);
}

}  // namespace
}  // namespace fracture::world
