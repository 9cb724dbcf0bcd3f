#include "client/world/ground_pairs.hpp"

#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>
#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace fracture::world {
namespace {

/// Distance in metres that counts as near for a body at rest. In a step, gravity alone moves it by less.
constexpr btScalar kNear = 0.003;

struct Corner {
  int index;          ///< among the hull's points
  btVector3 local;    ///< on the hull's surface, in its body
  btVector3 world;    ///< the same point in the world
  btScalar height;    ///< above the plane
  btScalar nearness;  ///< 1: touches; 0: just out of reach
};

/// Chooses the lowest corner, and up to three that span the largest quadrilateral with it, seen from above.
/// Near ones have more weight.
int choose(const std::vector<Corner>& corners, const btVector3& up, std::array<const Corner*, 4>& chosen) {
  const auto flat = [&](const btVector3& v) { return v - up.dot(v) * up; };
  const auto best = [&](auto value) -> const Corner* {
    const Corner* found = nullptr;
    btScalar most = 1e-12;
    for (const Corner& corner : corners)
      if (const btScalar v = corner.nearness * value(corner); v > most) {
        most = v;
        found = &corner;
      }
    return found;
  };
  chosen[0] = &*std::min_element(corners.begin(), corners.end(),
                                 [](const Corner& a, const Corner& b) { return a.height < b.height; });
  const btVector3 origin = chosen[0]->world;
  chosen[1] = best([&](const Corner& c) { return flat(c.world - origin).length2(); });
  if (chosen[1] == nullptr) return 1;
  const btVector3 side = up.cross(flat(chosen[1]->world - origin));
  int count = 2;
  for (const btScalar sign : {1.0, -1.0})
    if (const Corner* corner = best([&](const Corner& c) { return sign * side.dot(c.world - origin); }))
      chosen[static_cast<std::size_t>(count++)] = corner;
  return count;
}

}  // namespace

GroundPair::~GroundPair() {
  for (btPersistentManifold* manifold : manifolds_)
    if (manifold != nullptr) m_dispatcher->releaseManifold(manifold);
}

void GroundPair::getAllContactManifolds(btManifoldArray& manifolds) {
  for (btPersistentManifold* manifold : manifolds_)
    if (manifold != nullptr) manifolds.push_back(manifold);
}

void GroundPair::processCollision(const btCollisionObjectWrapper* first,
                                  const btCollisionObjectWrapper* second, const btDispatcherInfo& info,
                                  btManifoldResult*) {
  const bool swapped = first->getCollisionShape()->getShapeType() == STATIC_PLANE_PROXYTYPE;
  const btCollisionObjectWrapper &body = swapped ? *second : *first, &plane = swapped ? *first : *second;
  if (!body.getCollisionShape()->isCompound()) {
    manifolds_.resize(1, nullptr);
    meet(body, plane, info.m_timeStep, manifolds_[0]);
    return;
  }
  const auto& compound = static_cast<const btCompoundShape&>(*body.getCollisionShape());
  manifolds_.resize(static_cast<std::size_t>(compound.getNumChildShapes()), nullptr);
  for (int k = 0; k < compound.getNumChildShapes(); ++k) {
    const btTransform place = body.getWorldTransform() * compound.getChildTransform(k);
    const btCollisionObjectWrapper hull(&body, compound.getChildShape(k), body.getCollisionObject(), place,
                                        -1, k);
    meet(hull, plane, info.m_timeStep, manifolds_[static_cast<std::size_t>(k)]);
  }
}

void GroundPair::meet(const btCollisionObjectWrapper& hull, const btCollisionObjectWrapper& plane,
                      btScalar step, btPersistentManifold*& manifold) {
  const auto& shape = static_cast<const btConvexHullShape&>(*hull.getCollisionShape());
  const auto& ground = static_cast<const btStaticPlaneShape&>(*plane.getCollisionShape());
  const btTransform &pose = hull.getWorldTransform(), &floor = plane.getWorldTransform();
  const btVector3 up = floor.getBasis() * ground.getPlaneNormal();
  const btScalar level = ground.getPlaneConstant() + up.dot(floor.getOrigin()),
                 margin = shape.getMarginNonVirtual();
  const auto* body = btRigidBody::upcast(hull.getCollisionObject());
  const btVector3 velocity = body != nullptr ? body->getLinearVelocity() : btVector3(0, 0, 0),
                  spin = body != nullptr ? body->getAngularVelocity() : btVector3(0, 0, 0),
                  center = hull.getCollisionObject()->getWorldTransform().getOrigin();
  // Factor 2, because a corner that hits the ground turns the body, and the others then come down faster.
  const btScalar radius = shape.getAngularMotionDisc(),
                 farthest = (pose.getOrigin() - center).length() + radius,
                 reach = kNear + 2 * step * (velocity.length() + spin.length() * farthest);
  if (up.dot(pose.getOrigin()) - level - radius - margin > reach) {
    if (manifold != nullptr) manifold->setNumContacts(0);
    return;
  }

  static thread_local std::vector<Corner> corners;
  corners.clear();
  for (int k = 0; k < shape.getNumPoints(); ++k) {
    const btVector3 world = pose * shape.getScaledPoint(k);
    const btScalar height = up.dot(world) - level - margin;
    if (height > reach) continue;
    const btVector3 touching = world - margin * up;
    corners.push_back({k, hull.getCollisionObject()->getWorldTransform().invXform(touching), touching, height,
                       1 - std::max(height, btScalar(0)) / reach});
  }
  if (corners.empty()) {
    if (manifold != nullptr) manifold->setNumContacts(0);
    return;
  }
  if (manifold == nullptr)
    manifold = m_dispatcher->getNewManifold(hull.getCollisionObject(), plane.getCollisionObject());
  std::array<const Corner*, 4> chosen{};
  const int count = choose(corners, up, chosen);

  std::array<btManifoldPoint, 4> before;
  const int known = manifold->getNumContacts();
  for (int k = 0; k < known; ++k) before[static_cast<std::size_t>(k)] = manifold->getContactPoint(k);
  manifold->setNumContacts(count);
  for (int k = 0; k < count; ++k) {
    const Corner& corner = *chosen[static_cast<std::size_t>(k)];
    const btVector3 below = corner.world - corner.height * up;
    btManifoldPoint point(corner.local, floor.invXform(below), up, corner.height);
    const auto end = before.begin() + known;
    const auto same = std::find_if(before.begin(), end,
                                   [&](const btManifoldPoint& p) { return p.m_index1 == corner.index; });
    if (same != end) {  // the solver starts from the impulse of the last step
      const bool pressed = same->m_appliedImpulse > 0;
      point = *same;
      point.m_localPointA = corner.local;
      point.m_localPointB = floor.invXform(below);
      point.m_normalWorldOnB = up;
      point.m_distance1 = corner.height;
      point.m_lifeTime = pressed ? same->m_lifeTime + 1 : 0;  // counts the steps in which it carried load
    }
    point.m_positionWorldOnA = corner.world;
    point.m_positionWorldOnB = below;
    point.m_index0 = hull.m_index;  // index of the hull in its compound
    point.m_index1 = corner.index;
    const btCollisionObject &a = *hull.getCollisionObject(), &b = *plane.getCollisionObject();
    point.m_combinedFriction = gCalculateCombinedFrictionCallback(&a, &b);
    point.m_combinedRestitution = btManifoldResult::calculateCombinedRestitution(&a, &b);
    point.m_combinedRollingFriction = btManifoldResult::calculateCombinedRollingFriction(&a, &b);
    point.m_combinedSpinningFriction = btManifoldResult::calculateCombinedSpinningFriction(&a, &b);
    manifold->getContactPoint(k) = point;
  }
}

btCollisionAlgorithm* GroundPair::CreateFunc::CreateCollisionAlgorithm(
    btCollisionAlgorithmConstructionInfo& info, const btCollisionObjectWrapper*,
    const btCollisionObjectWrapper*) {
  void* memory = info.m_dispatcher1->allocateCollisionAlgorithm(sizeof(GroundPair));
  return new (memory) GroundPair(info);
}

}  // namespace fracture::world
