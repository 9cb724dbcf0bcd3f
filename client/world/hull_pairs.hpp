// Asks Bullet to collide two convex hulls only where they may touch. Private to this folder.
#pragma once

#include <BulletCollision/CollisionDispatch/btConvexConvexAlgorithm.h>

#include "client/world/bullet.hpp"
#include "client/world/steady_pairs.hpp"

namespace fracture::world {

/// Replaces Bullet's own algorithm for pairs of hulls and makes the same contacts where they are looked at.
///
/// Right after something broke, the boxes of many fragments overlap, but five in six of these pairs do not
/// touch, and Bullet runs GJK from scratch for each of them in every step. We keep a direction along which the
/// two hulls are farther apart than a contact may be: it saves that work, and mostly still separates them in the
/// next step (Chung and Wang, "Quick elimination of non-interference polytopes in virtual environments", 1996).
/// Where we find no such direction, Bullet decides. What stands as it did is not looked at (steady_pairs.hpp).
class HullPair final : public btConvexConvexAlgorithm {
 public:
  using btConvexConvexAlgorithm::btConvexConvexAlgorithm;
  void processCollision(const btCollisionObjectWrapper* first, const btCollisionObjectWrapper* second,
                        const btDispatcherInfo& info, btManifoldResult* result) override;
  /// The same without regard to how they stood. Metres by which the two are apart beyond the reach of contacts; zero: not
  /// known.
  btScalar collide(const btCollisionObjectWrapper& first, const btCollisionObjectWrapper& second,
                   const btDispatcherInfo& info, btManifoldResult& result);

  struct CreateFunc final : btConvexConvexAlgorithm::CreateFunc {
    using btConvexConvexAlgorithm::CreateFunc::CreateFunc;
    btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                   const btCollisionObjectWrapper* first,
                                                   const btCollisionObjectWrapper* second) override;
  };

 private:
  btScalar gap(const btCollisionObjectWrapper& first, const btCollisionObjectWrapper& second);

  Steadiness steadiness_;
  btManifoldArray manifolds_;
  btVector3 direction_{0, 0, 0};  ///< from the first to the second, in the first's frame; zero: none yet
};

}  // namespace fracture::world
