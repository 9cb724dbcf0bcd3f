#include "client/world/boxed_world.hpp"

namespace fracture::world {
namespace {
constexpr btScalar kLargest = 1e12;  // square metres, of a box from corner to corner
constexpr int kBoxed = 1;            // marks a body that has its box
}  // namespace

BoxedWorld::BoxedWorld(btDispatcher* dispatcher, btBroadphaseInterface* boxes, btConstraintSolver* solver,
                       btCollisionConfiguration* configuration)
    : btDiscreteDynamicsWorld(dispatcher, boxes, solver, configuration) {
  gDbvtMargin = 0.01;  // metres that a box in the tree is too large; one for all of Bullet
}

/// Those that Bullet foresaw for a ball in the last step: it leaves them to its pool, and ours are no pool's.
BoxedWorld::~BoxedWorld() { releasePredictiveContacts(); }

void BoxedWorld::updateAabbs() {
  for (int k = 0; k < m_collisionObjects.size(); ++k) {
    btCollisionObject& object = *m_collisionObjects[k];
    if (!object.isActive() && object.getUserIndex2() == kBoxed) continue;  // it sleeps where its box is
    object.setUserIndex2(kBoxed);
    const btCollisionShape& shape = *object.getCollisionShape();
    // Contacts reach as far as the lesser one of two shapes says, which is at most half of both.
    const btScalar reach = 0.5 * shape.getContactBreakingThreshold(gContactBreakingThreshold);
    btVector3 low, high;
    shape.getAabb(object.getWorldTransform(), low, high);
    if (!object.isStaticOrKinematicObject()) {  // and where it is going
      btVector3 next_low, next_high;
      shape.getAabb(object.getInterpolationWorldTransform(), next_low, next_high);
      low.setMin(next_low);
      high.setMax(next_high);
    }
    // What has no place (NaN) would spoil the boxes of others in the tree: it is left out, as Bullet does.
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
