#include "client/world/steady_pairs.hpp"

#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>

namespace fracture::world {

namespace {

/// The root of all squares of what a rotation changed by: no vector of unit length is turned by more.
btScalar turned(const btMatrix3x3& from, const btMatrix3x3& to) {
  btScalar sum = 0;
  for (int row = 0; row < 3; ++row) sum += (to[row] - from[row]).length2();
  return btSqrt(sum);
}

btScalar reach_of_contacts(const btCollisionObjectWrapper& body) {
  return body.getCollisionObject()->getCollisionShape()->getContactBreakingThreshold(
      gContactBreakingThreshold);
}

}  // namespace

bool Steadiness::holds(const btCollisionObjectWrapper& first, const btCollisionObjectWrapper& second) {
  const btTransform now = first.getWorldTransform().inverseTimes(second.getWorldTransform());
  const btMatrix3x3& basis = first.getWorldTransform().getBasis();
  if (still_ >= 0) {
    const btScalar moved = (now.getOrigin() - second_in_first_.getOrigin()).length();
    if (moved + reach_ * turned(second_in_first_.getBasis(), now.getBasis()) <= still_ &&
        turned(first_, basis) <= kTurned)
      return true;
  }
  first_ = basis;
  second_in_first_ = now;
  still_ = btMin(kStill, 0.5 * btMin(reach_of_contacts(first), reach_of_contacts(second)));
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
