// Leaves out of collision detection what stands as it did. Private to this folder.
#pragma once

#include <BulletCollision/BroadphaseCollision/btCollisionAlgorithm.h>

#include "client/world/bullet.hpp"

namespace fracture::world {

/// Most of a heap hardly moves long before it sleeps, and its contacts are what they were: it is enough to see how deep
/// they are now (the body pair cache of Jolt: Rouwe, "Architecting Jolt Physics for Horizon Forbidden West", Game
/// Developers Conference 2022). What is apart need not be looked at before it can have come near (the idea of
/// conservative advancement: Mirtich, "Impulse-based Dynamic Simulation of Rigid Body Systems", 1996). Of two bodies; what
/// it remembers goes with their pair, and their shapes stay what they are.
class Steadiness {
 public:
  static constexpr btScalar kStill = 0.0005;  ///< metres, of bodies from 5 cm on
  static constexpr btScalar kTurned = 0.01;   ///< radians
  /// True where no point of the smaller shape is farther than kStill from where it was, as the larger one sees it, when the
  /// answer was false for the last time: of small bodies half of what their contacts may move, which else would go. And
  /// where the larger has not turned by kTurned: normals of contacts stay as they are in the world.
  bool holds(const btCollisionObjectWrapper& first, const btCollisionObjectWrapper& second);
  /// Since the answer was false: the two have no contact, and get none before they are so many metres nearer. Where that
  /// is more than kStill, it counts instead, however they turn. Zero or less: nothing is known.
  void part(btScalar gap);

 private:
  btMatrix3x3 outer_;           ///< how the larger one was turned …
  btTransform inner_in_outer_;  ///< … and where the smaller one was
  btScalar still_ = -1;         ///< metres; negative: not seen yet
  btScalar least_ = 0;          ///< metres: kStill, or less
  btScalar reach_ = 0;          ///< of the smaller shape from its origin
  bool second_is_larger_ = false, apart_ = false;
};

/// Depths of a pair's contacts as the bodies stand now; those that came apart go. `manifolds`: room for the work.
void refresh_contacts(btCollisionAlgorithm& pair, btManifoldArray& manifolds);

}  // namespace fracture::world
