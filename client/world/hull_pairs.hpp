// Bullet's collision of two convex hulls, asked only where they may touch. Private to this folder.
#pragma once

#include <BulletCollision/CollisionDispatch/btConvexConvexAlgorithm.h>

#include "client/world/bullet.hpp"

namespace fracture::world {

/// Takes the place of Bullet's own algorithm for pairs of hulls, with the same contacts.
///
/// Among the fragments of something just broken, five pairs in six whose boxes overlap do not touch, and
/// Bullet runs GJK from nothing for each in every step. A direction along which the two are farther apart
/// than a contact may be spares that, and is one in the next step too: Chung and Wang, "Quick elimination of
/// non-interference polytopes in virtual environments" (1996). Where none is found Bullet decides.
class HullPair final : public btConvexConvexAlgorithm {
 public:
  using btConvexConvexAlgorithm::btConvexConvexAlgorithm;
  void processCollision(const btCollisionObjectWrapper* first, const btCollisionObjectWrapper* second,
                        const btDispatcherInfo& info, btManifoldResult* result) override;

  struct CreateFunc final : btConvexConvexAlgorithm::CreateFunc {
    using btConvexConvexAlgorithm::CreateFunc::CreateFunc;
    btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                   const btCollisionObjectWrapper* first,
                                                   const btCollisionObjectWrapper* second) override;
  };

 private:
  bool separated(const btCollisionObjectWrapper& first, const btCollisionObjectWrapper& second);

  btVector3 direction_{0, 0, 0};  ///< from the first to the second, in the first's frame; zero: none yet
};

}  // namespace fracture::world
