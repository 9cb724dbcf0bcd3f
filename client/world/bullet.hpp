// Bullet's headers, and conversions to glm and back. Private to this folder.
#pragma once

#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <btBulletDynamicsCommon.h>

#include "client/world/change.hpp"
#include "client/world/hull_shape.hpp"
#include "client/world/world.hpp"

// In single precision, touching pieces would jitter and creep at ten metres from the origin.
#ifndef BT_USE_DOUBLE_PRECISION
#error "Bullet must be built in double precision (pkg-config bullet-float64)"
#endif

namespace fracture::world {

inline btVector3 to_bullet(const glm::dvec3& v) { return {v.x, v.y, v.z}; }
inline btQuaternion to_bullet(const glm::dquat& q) { return {q.x, q.y, q.z, q.w}; }
inline btTransform to_bullet(const Pose& pose) {
  return btTransform(to_bullet(pose.rotation), to_bullet(pose.position));
}
inline glm::dvec3 from_bullet(const btVector3& v) { return {v.x(), v.y(), v.z()}; }
inline Pose from_bullet(const btTransform& t) {
  const btQuaternion q = t.getRotation();
  return {from_bullet(t.getOrigin()), glm::normalize(glm::dquat(q.w(), q.x(), q.y(), q.z()))};
}

/// A hull shape that has the hull's surface once Bullet adds its margin: the points are moved inwards by the
/// margin.
std::unique_ptr<HullShape> make_hull(std::span<const glm::dvec3> points);

struct PreparedFragments : ChangedFragments {
  /// The fragments that this changes, if it is a change. Unchanged fragments share their shapes.
  std::weak_ptr<const PreparedFragments> before;
  struct Part {
    Pose frame;  ///< origin at the centre of mass, principal axes; in the asset's frame
    glm::dvec3 moments;
    std::vector<std::shared_ptr<HullShape>> hulls;  ///< in `frame`
  };
  std::vector<Part> parts;
  double volume = 0;
};

}  // namespace fracture::world
