#include "client/world/steady_pairs.hpp"

#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>

namespace fracture::world {

bool Steadiness::holds(const btCollisionObjectWrapper& first, const btCollisionObjectWrapper& second) {
  const btTransform now = first.getWorldTransform().inverseTimes(second.getWorldTransform());
  if (reach_ >= 0) {
    // No vector is turned by more than the root of all squares of what the matrix changed by.
    btScalar turned = 0;
    for (int row = 0; row < 3; ++row)
      turned += (now.getBasis()[row] - second_in_first_.getBasis()[row]).length2();
    const btScalar moved = (now.getOrigin() - second_in_first_.getOrigin()).length();
    if (moved + reach_ * btSqrt(turned) <= kStill) return true;
  }
  second_in_first_ = now;
  reach_ = second.getCollisionShape()->getAngularMotionDisc();
  return false;
}

void refresh_contacts(btCollisionAlgorithm& pair, btManifoldArray& manifolds) {
  manifolds.resize(0);
  pair.getAllContactManifolds(manifolds);
  for (int m = 0; m < manifolds.size(); ++m)
    manifolds[m]->refreshContactPoints(manifolds[m]->getBody0()->getWorldTransform(),
                                       manifolds[m]->getBody1()->getWorldTransform());
}

}  // namespace fracture::world
