// Skips collision detection for pairs that have hardly moved. Private to this folder.
#pragma once

#include <BulletCollision/BroadphaseCollision/btCollisionAlgorithm.h>

#include "client/world/bullet.hpp"

namespace fracture::world {

/// Most of a heap hardly moves long before it sleeps, and its contacts do not change. It is enough to update
/// their depths (Jolt's body pair cache: Rouwe, "Architecting Jolt Physics for Horizon Forbidden West", Game
/// Developers Conference 2022). Two bodies apart need not be checked before they can have met (the idea of
/// conservative advancement: Mirtich, "Impulse-based Dynamic Simulation of Rigid Body Systems", 1996). One
/// object belongs to one pair of bodies and lives as long as the pair; their shapes must not change.
class Steadiness {
 public:
  static constexpr btScalar kStill = 0.0005;  ///< metres, for bodies of at least 5 cm
  static constexpr btScalar kTurned = 0.01;   ///< radians
  /// Returns true if the pair has hardly moved since the answer was last false. In the frame of the larger
  /// shape, no point of the smaller one may have moved by more than kStill. For small bodies the limit is
  /// half of the distance at which their contacts break. The larger shape may not have turned by more than
  /// kTurned, so that contact normals stay valid in the world.
  bool holds(const btCollisionObjectWrapper& first, const btCollisionObjectWrapper& second);
  /// Call after an answer of false if the two have no contact, and can have none before they are `gap` metres
  /// nearer. If `gap` exceeds kStill, it becomes the limit, however they turn. Zero or less: unknown.
  void part(btScalar gap);

 private:
  btMatrix3x3 outer_;           ///< rotation of the larger one …
  btTransform inner_in_outer_;  ///< … and position of the smaller one, when the answer was last false
  btScalar still_ = -1;         ///< metres: the current limit; negative: not checked yet
  btScalar least_ = 0;          ///< metres: the usual limit, kStill or less
  btScalar reach_ = 0;          ///< distance of the smaller shape's farthest point from its origin
  bool second_is_larger_ = false, apart_ = false;
};

/// Updates the depths of a pair's contacts to the current poses and drops contacts that parted. `manifolds`:
/// scratch space.
void refresh_contacts(btCollisionAlgorithm& pair, btManifoldArray& manifolds);

}  // namespace fracture::world
