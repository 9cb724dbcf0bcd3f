// Contacts of a convex hull with the ground, found before it is reached. Private to this folder.
#pragma once

#include <BulletCollision/BroadphaseCollision/btCollisionAlgorithm.h>
#include <BulletCollision/CollisionDispatch/btCollisionCreateFunc.h>

#include <vector>

#include "client/world/bullet.hpp"

class btPersistentManifold;

namespace fracture::world {

/// Replaces Bullet's own algorithm for a hull and a plane. That one finds a single corner in each step, and only
/// once it is within two hundredths of the hull's size: a shard that falls at 5 m/s is 4 cm under the ground by
/// then, and a plate that lies on it rocks from corner to corner. We look at every corner that may
/// be at the ground after this step, and keep four of them that spread widely. A contact that is not
/// closed yet lets the corner come exactly as far as the ground (speculative contacts: Catto, "Continuous Collision",
/// Game Developers Conference 2013).
///
/// Of a compound each hull has contacts of its own.
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

  std::vector<btPersistentManifold*>
      manifolds_;  ///< of the body, then the plane; one for each hull, null: not yet
};

}  // namespace fracture::world
