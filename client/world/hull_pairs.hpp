// Collides two convex hulls, starting from the result of the last step. Private to this folder.
#pragma once

#include <BulletCollision/BroadphaseCollision/btCollisionAlgorithm.h>
#include <BulletCollision/CollisionDispatch/btCollisionCreateFunc.h>

#include <array>

#include "client/world/bullet.hpp"
#include "client/world/steady_pairs.hpp"

class btConvexPenetrationDepthSolver;

namespace fracture::world {

/// Replaces Bullet's own algorithm for pairs of hulls. It makes the same contacts whenever it checks a pair.
///
/// Right after something broke, the boxes of many fragments overlap, but five in six of these pairs do not
/// touch. Bullet runs GJK from scratch for each of them in every step. We keep a direction along which the
/// two hulls are farther apart than a contact may be. It saves that work and usually still separates them in
/// the next step (Chung and Wang, "Quick elimination of non-interference polytopes in virtual environments",
/// 1996).
///
/// If no such direction is known, GJK starts from the corners that were nearest in the last step. If they are
/// still the nearest, it ends at once (Cameron, "Enhancing GJK: computing minimum and
/// penetration distances between convex polyhedra", 1997). If the result is unclear (hulls overlap by about
/// their margins or more), Bullet decides. A pair that has hardly moved is not checked (steady_pairs.hpp).
class HullPair final : public btCollisionAlgorithm {
 public:
  HullPair(const btCollisionAlgorithmConstructionInfo& info, btConvexPenetrationDepthSolver& depths)
      : btCollisionAlgorithm(info), depths_(depths) {}
  ~HullPair() override;
  void processCollision(const btCollisionObjectWrapper* first, const btCollisionObjectWrapper* second,
                        const btDispatcherInfo& info, btManifoldResult* result) override;
  /// Collides the two even if they have not moved. Returns the metres by which they are apart beyond the
  /// reach of contacts, or 0 if that is unknown.
  btScalar collide(const btCollisionObjectWrapper& first, const btCollisionObjectWrapper& second,
                   btManifoldResult& result);
  /// Not needed: only balls are fast enough, and Bullet sweeps balls.
  btScalar calculateTimeOfImpact(btCollisionObject*, btCollisionObject*, const btDispatcherInfo&,
                                 btManifoldResult*) override {
    return 1;
  }
  void getAllContactManifolds(btManifoldArray& manifolds) override;

  struct CreateFunc final : btCollisionAlgorithmCreateFunc {
    explicit CreateFunc(btConvexPenetrationDepthSolver* of_overlaps) : depths(*of_overlaps) {}
    btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                   const btCollisionObjectWrapper* first,
                                                   const btCollisionObjectWrapper* second) override;
    btConvexPenetrationDepthSolver& depths;
  };

 private:
  struct Hulls;    ///< both hulls, in the first's frame
  struct Contact;  ///< in the first's frame
  enum class Outcome { kApart, kNear, kUnclear };

  btScalar gap(const Hulls& hulls);
  Outcome nearest(const Hulls& hulls, Contact& contact, btScalar& beyond);
  bool asked_of_bullet(const Hulls& hulls, Contact& contact) const;

  btConvexPenetrationDepthSolver& depths_;
  Steadiness steadiness_;
  btPersistentManifold* manifold_ = nullptr;  ///< null: the two have not touched yet
  btManifoldArray manifolds_;
  /// Metres: at this distance, Bullet's dispatcher has no contacts either. Negative: not known yet.
  btScalar reach_ = -1;
  btVector3 direction_{0, 0, 0};  ///< in the first's frame, towards the second; zero: none yet
  /// The corners between which the nearest points were, each in its own hull's frame.
  struct Corners {
    btVector3 first, second;
  };
  std::array<Corners, 3> corners_;
  int known_ = 0;  ///< number of valid corners
};

}  // namespace fracture::world
