// Contacts of a convex hull with the ground, found before the hull reaches it. Private to this folder.
#pragma once

#include <BulletCollision/BroadphaseCollision/btCollisionAlgorithm.h>
#include <BulletCollision/CollisionDispatch/btCollisionCreateFunc.h>

#include <vector>

#include "client/world/bullet.hpp"

class btPersistentManifold;

namespace fracture::world {

/// Replaces Bullet's own algorithm for a hull and a plane. Bullet finds only one corner per step, and only
/// within two hundredths of the hull's size. A shard that falls at 5 m/s is 4 cm below the ground by then,
/// and a plate on the ground rocks from corner to corner. We check every corner that may reach the ground in
/// this step, and keep four that are spread widely. A contact that is still open lets its corner come exactly
/// down to the ground (speculative contacts: Catto, "Continuous Collision", Game Developers Conference 2013).
///
/// Each hull of a compound has its own contacts.
class GroundPair final : public btCollisionAlgorithm {
 public:
  explicit GroundPair(const btCollisionAlgorithmConstructionInfo& info) : btCollisionAlgorithm(info) {}
  ~GroundPair() override;
  void processCollision(const btCollisionObjectWrapper* first, const btCollisionObjectWrapper* second,
                        const btDispatcherInfo& info, btManifoldResult* result) override;
  btScalar calculateTimeOfImpact(btCollisionObject*, btCollisionObject*, const btDispatcherInfo&,
                                 btManifoldResult*) override {
    return 1;
  }
  void getAllContactManifolds(btManifoldArray& manifolds) override;

  struct CreateFunc final : btCollisionAlgorithmCreateFunc {
    btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                   const btCollisionObjectWrapper* first,
                                                   const btCollisionObjectWrapper* second) override;
  };

 private:
  void meet(const btCollisionObjectWrapper& hull, const btCollisionObjectWrapper& plane, btScalar step,
            btPersistentManifold*& manifold);

  /// Between the body and the plane, one per hull; null: not created yet
  std::vector<btPersistentManifold*> manifolds_;
};

}  // namespace fracture::world
