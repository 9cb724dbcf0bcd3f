#include "client/world/boxed_world.hpp"

namespace fracture::world {
namespace {
constexpr btScalar kLargest = 1e12;  // square metres: squared diagonal of the largest box
constexpr int kBoxed = 1;            // marks a body whose box is set
}  // namespace

BoxedWorld::BoxedWorld(btDispatcher* dispatcher, btBroadphaseInterface* boxes, btConstraintSolver* solver,
                       btCollisionConfiguration* configuration)
    : btDiscreteDynamicsWorld(dispatcher, boxes, solver, configuration) {
  gDbvtMargin = 0.01;  // metres that Bullet adds to boxes in its tree; global for all of Bullet
}

/// Frees the contacts that Bullet predicted for a ball in the last step. Its own destructor would put them
/// into its pool, but they do not come from a pool here.
BoxedWorld::~BoxedWorld() { releasePredictiveContacts(); }

void BoxedWorld::updateAabbs() {
  for (int k = 0; k < m_collisionObjects.size(); ++k) {
    btCollisionObject& object = *m_collisionObjects[k];
    if (!object.isActive() && object.getUserIndex2() == kBoxed) continue;  // it sleeps, so its box is right
    object.setUserIndex2(kBoxed);
    const btCollisionShape& shape = *object.getCollisionShape();
    // Contacts reach as far as the smaller value of two shapes, which is at most half the sum of both.
    const btScalar reach = 0.5 * shape.getContactBreakingThreshold(gContactBreakingThreshold);
    btVector3 low, high;
    shape.getAabb(object.getWorldTransform(), low, high);
    if (!object.isStaticOrKinematicObject()) {  // extend the box to the next position
      btVector3 next_low, next_high;
      shape.getAabb(object.getInterpolationWorldTransform(), next_low, next_high);
      low.setMin(next_low);
      high.setMax(next_high);
    }
    // A body without a valid position (NaN) would spoil other boxes in the tree. It is disabled, as in
    // Bullet.
    if (!((high - low).length2() < kLargest) && !object.isStaticOrKinematicObject()) {
      object.setActivationState(DISABLE_SIMULATION);
      continue;
    }
    const btVector3 by(reach, reach, reach);
    m_broadphasePairCache->setAabb(object.getBroadphaseHandle(), low - by, high + by, m_dispatcher1);
  }
}

void BoxedWorld::calculateSimulationIslands() {
  if (when_contacts_are_found) when_contacts_are_found();
  btDiscreteDynamicsWorld::calculateSimulationIslands();
}

}  // namespace fracture::world
