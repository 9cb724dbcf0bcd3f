#include "client/world/steady_pairs.hpp"

#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>

namespace fracture::world {

namespace {

/// The Frobenius norm of a rotation's change, an upper bound on how far a unit vector moves.
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
  const bool known = still_ >= 0;
  if (!known) {
    const btScalar a = first.getCollisionShape()->getAngularMotionDisc(),
                   b = second.getCollisionShape()->getAngularMotionDisc();
    second_is_larger_ = b > a;
    reach_ = btMin(a, b);
    least_ = btMin(kStill, 0.5 * btMin(reach_of_contacts(first), reach_of_contacts(second)));
  }
  const btTransform &outer = (second_is_larger_ ? second : first).getWorldTransform(),
                    &inner = (second_is_larger_ ? first : second).getWorldTransform();
  const btTransform now = outer.inverseTimes(inner);
  if (known) {
    const btScalar moved = (now.getOrigin() - inner_in_outer_.getOrigin()).length();
    if (moved <= still_ && moved + reach_ * turned(inner_in_outer_.getBasis(), now.getBasis()) <= still_ &&
        (apart_ || turned(outer_, outer.getBasis()) <= kTurned))
      return true;
  }
  outer_ = outer.getBasis();
  inner_in_outer_ = now;
  still_ = least_;
  apart_ = false;
  return false;
}

void Steadiness::part(btScalar gap) {
  if (!(gap > still_)) return;
  still_ = gap;
  apart_ = true;
}

void refresh_contacts(btCollisionAlgorithm& pair, btManifoldArray& manifolds) {
  manifolds.resize(0);
  pair.getAllContactManifolds(manifolds);
  for (int m = 0; m < manifolds.size(); ++m)
    if (manifolds[m]->getNumContacts() > 0)
      manifolds[m]->refreshContactPoints(manifolds[m]->getBody0()->getWorldTransform(),
                                         manifolds[m]->getBody1()->getWorldTransform());
}

}  // namespace fracture::world
