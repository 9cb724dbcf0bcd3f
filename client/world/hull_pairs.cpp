#include "client/world/hull_pairs.hpp"

#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>

namespace fracture::world {

btScalar HullPair::gap(const btCollisionObjectWrapper& first, const btCollisionObjectWrapper& second) {
  constexpr int kTries = 2;  // more find little, and cost what GJK does
  const auto& a = *static_cast<const btConvexShape*>(first.getCollisionShape());
  const auto& b = *static_cast<const btConvexShape*>(second.getCollisionShape());
  // As far apart as this there is no contact in Bullet either, by the rule of its dispatcher.
  const btScalar reach = a.getMarginNonVirtual() + b.getMarginNonVirtual() +
                         btMin(first.getCollisionObject()->getCollisionShape()->getContactBreakingThreshold(
                                   gContactBreakingThreshold),
                               second.getCollisionObject()->getCollisionShape()->getContactBreakingThreshold(
                                   gContactBreakingThreshold));
  const btTransform b_in_a = first.getWorldTransform().inverseTimes(second.getWorldTransform());
  btVector3 direction = direction_;
  if (direction.fuzzyZero()) direction = b_in_a.getOrigin();  // hulls stand about their centres of mass
  for (int k = 0; k < kTries && !direction.fuzzyZero(); ++k) {
    direction.normalize();
    const btVector3 from = a.localGetSupportVertexWithoutMarginNonVirtual(direction),
                    to = b_in_a *
                         b.localGetSupportVertexWithoutMarginNonVirtual(-(direction * b_in_a.getBasis()));
    const btVector3 way = to - from;
    if (const btScalar beyond = way.dot(direction) - reach; beyond > 0) {
      direction_ = direction;
      return beyond;
    }
    if (way.fuzzyZero()) break;
    const btVector3 r = way.normalized();
    direction -= 2 * r.dot(direction) * r;
  }
  direction_.setZero();
  return 0;
}

btScalar HullPair::collide(const btCollisionObjectWrapper& first, const btCollisionObjectWrapper& second,
                           const btDispatcherInfo& info, btManifoldResult& result) {
  const btPersistentManifold* manifold = getManifold();
  // Contacts of the last step are Bullet's to keep or to drop.
  if (manifold == nullptr || manifold->getNumContacts() == 0)
    if (const btScalar beyond = gap(first, second); beyond > 0) return beyond;
  btConvexConvexAlgorithm::processCollision(&first, &second, info, &result);
  return 0;
}

void HullPair::processCollision(const btCollisionObjectWrapper* first, const btCollisionObjectWrapper* second,
                                const btDispatcherInfo& info, btManifoldResult* result) {
  if (steadiness_.holds(*first, *second))
    refresh_contacts(*this, manifolds_);
  else
    steadiness_.part(collide(*first, *second, info, *result));
}

btCollisionAlgorithm* HullPair::CreateFunc::CreateCollisionAlgorithm(
    btCollisionAlgorithmConstructionInfo& info, const btCollisionObjectWrapper* first,
    const btCollisionObjectWrapper* second) {
  void* memory = info.m_dispatcher1->allocateCollisionAlgorithm(sizeof(HullPair));
  return new (memory) HullPair(info.m_manifold, info, first, second, m_pdSolver, m_numPerturbationIterations,
                               m_minimumPointsPerturbationThreshold);
}

}  // namespace fracture::world
