// Contacts of two bodies of which one at least has several hulls. Private to this folder.
#pragma once

#include <BulletCollision/BroadphaseCollision/btCollisionAlgorithm.h>
#include <BulletCollision/CollisionDispatch/btCollisionCreateFunc.h>

#include <vector>

#include "client/world/bullet.hpp"
#include "client/world/hull_pairs.hpp"
#include "client/world/steady_pairs.hpp"

namespace fracture::world {

/// Replaces Bullet's own algorithms for two compounds, or a compound and a hull or box, and makes the same contacts where
/// they are looked at. Bullet's walk two trees and copy contacts in every step; a ragged piece has two to four hulls, and of
/// those of two neighbours most do not meet. We compare the boxes of hulls in the frames of both bodies (two thirds of the
/// axes of Gottschalk, Lin and Manocha, "OBBTree", 1996), and know from them and from HullPair how far
/// apart the bodies are as a whole: until they can have come so near, nothing is done (steady_pairs.hpp).
class CompoundPair final : public btCollisionAlgorithm {
 public:
  CompoundPair(const btCollisionAlgorithmConstructionInfo& info, HullPair::CreateFunc& hulls)
      : btCollisionAlgorithm(info), hulls_(hulls) {}
  ~CompoundPair() override;
  void processCollision(const btCollisionObjectWrapper* first, const btCollisionObjectWrapper* second,
                        const btDispatcherInfo& info, btManifoldResult* result) override;
  /// Bullet has none for compounds either.
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
  /// Two hulls whose boxes overlap.
  struct Meeting {
    int first, second;  ///< which of the bodies' hulls
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
