// Leaves out of collision detection what stands as it did. Private to this folder.
#pragma once

#include <BulletCollision/CollisionDispatch/btCompoundCollisionAlgorithm.h>
#include <BulletCollision/CollisionDispatch/btCompoundCompoundCollisionAlgorithm.h>

#include "client/world/bullet.hpp"

namespace fracture::world {

/// Most of a heap hardly moves long before it sleeps, and its contacts are what they were: it is enough to see how deep
/// they are now (the body pair cache of Jolt: Rouwe, "Architecting Jolt Physics for Horizon Forbidden West", Game
/// Developers Conference 2022). Of two bodies; what it remembers goes with their pair.
class Steadiness {
 public:
  static constexpr btScalar kStill = 0.0005;  ///< metres, of bodies from 5 cm on
  static constexpr btScalar kTurned = 0.01;   ///< radians
  /// True where no point of the second shape is farther than kStill from where it was, as the first one sees it, when the
  /// answer was false for the last time: of small bodies half of what their contacts may move, which else would go. And
  /// where the first has not turned by kTurned: normals of contacts stay as they are in the world.
  bool holds(const btCollisionObjectWrapper& first, const btCollisionObjectWrapper& second);

 private:
  btMatrix3x3 first_;
  btTransform second_in_first_;
  btScalar still_ = -1;  ///< metres; negative: not seen yet
  btScalar reach_ = 0;   ///< of the second shape from its origin
};

/// Depths of a pair's contacts as the bodies stand now; those that came apart go. `manifolds`: room for the work.
void refresh_contacts(btCollisionAlgorithm& pair, btManifoldArray& manifolds);

/// Bullet's algorithm for two bodies of which one at least has several hulls, but where they stand as they did.
template <class Theirs>
class SteadyPair final : public Theirs {
 public:
  using Theirs::Theirs;
  void processCollision(const btCollisionObjectWrapper* first, const btCollisionObjectWrapper* second,
                        const btDispatcherInfo& info, btManifoldResult* result) override {
    if (steadiness_.holds(*first, *second))
      refresh_contacts(*this, manifolds_);
    else
      Theirs::processCollision(first, second, info, result);
  }

  struct CreateFunc final : btCollisionAlgorithmCreateFunc {
    /// `swapped`: the second has several hulls, the first has one.
    explicit CreateFunc(bool swapped) { m_swapped = swapped; }
    btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                   const btCollisionObjectWrapper* first,
                                                   const btCollisionObjectWrapper* second) override {
      void* memory = info.m_dispatcher1->allocateCollisionAlgorithm(sizeof(SteadyPair));
      return new (memory) SteadyPair(info, first, second, m_swapped);
    }
  };

 private:
  Steadiness steadiness_;
  btManifoldArray manifolds_;
};

using SteadyCompoundPair = SteadyPair<btCompoundCompoundCollisionAlgorithm>;
using SteadyCompoundAndHull = SteadyPair<btCompoundCollisionAlgorithm>;

}  // namespace fracture::world
