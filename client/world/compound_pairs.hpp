// Contacts between two bodies, at least one of which has several hulls. Private to this folder.
#pragma once

#include <BulletCollision/BroadphaseCollision/btCollisionAlgorithm.h>
#include <BulletCollision/CollisionDispatch/btCollisionCreateFunc.h>

#include <vector>

#include "client/world/bullet.hpp"
#include "client/world/hull_pairs.hpp"
#include "client/world/steady_pairs.hpp"

namespace fracture::world {

/// Replaces Bullet's own algorithms for two compounds, or for a compound and a hull or box. It makes the same
/// contacts whenever it checks a pair. Bullet walks two trees and copies contacts in every step. A ragged
/// piece has two to four hulls, and most hulls of two neighbours do not meet. We compare the boxes of hulls
/// in the frames of both bodies (two thirds of the axes of Gottschalk, Lin and Manocha, "OBBTree", 1996).
/// Together with HullPair, this gives the distance between the bodies as a whole. Nothing is done until they
/// can have come that much nearer (steady_pairs.hpp).
class CompoundPair final : public btCollisionAlgorithm {
 public:
  CompoundPair(const btCollisionAlgorithmConstructionInfo& info, HullPair::CreateFunc& hulls)
      : btCollisionAlgorithm(info), hulls_(hulls) {}
  ~CompoundPair() override;
  void processCollision(const btCollisionObjectWrapper* first, const btCollisionObjectWrapper* second,
                        const btDispatcherInfo& info, btManifoldResult* result) override;
  /// Not needed; Bullet does not compute it for compounds either.
  btScalar calculateTimeOfImpact(btCollisionObject*, btCollisionObject*, const btDispatcherInfo&,
                                 btManifoldResult*) override {
    return 1;
  }
  void getAllContactManifolds(btManifoldArray& manifolds) override;

  struct CreateFunc final : btCollisionAlgorithmCreateFunc {
    explicit CreateFunc(HullPair::CreateFunc& of_hulls) : hulls(of_hulls) {}
    btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                   const btCollisionObjectWrapper* first,
                                                   const btCollisionObjectWrapper* second) override;
    HullPair::CreateFunc& hulls;
  };

 private:
  /// Two hulls with overlapping boxes.
  struct Meeting {
    int first, second;  ///< index of each body's hull
    HullPair* pair;
    bool seen;  ///< in this step
  };
  struct Look;
  void meet(const Look& look, int first, int second, btScalar& gap);
  void free(const Meeting& meeting);

  HullPair::CreateFunc& hulls_;
  Steadiness steadiness_;
  std::vector<Meeting> meetings_;  ///< by `first`, then `second`
  btManifoldArray manifolds_;
};

}  // namespace fracture::world
