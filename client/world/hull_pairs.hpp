// Collides two convex hulls, beginning where the last step ended. Private to this folder.
#pragma once

#include <BulletCollision/BroadphaseCollision/btCollisionAlgorithm.h>
#include <BulletCollision/CollisionDispatch/btCollisionCreateFunc.h>

#include <array>

#include "client/world/bullet.hpp"
#include "client/world/steady_pairs.hpp"

class btConvexPenetrationDepthSolver;

namespace fracture::world {

/// Replaces Bullet's own algorithm for pairs of hulls and makes the same contacts where they are looked at.
///
/// Right after something broke, the boxes of many fragments overlap, but five in six of these pairs do not
/// touch, and Bullet runs GJK from scratch for each of them in every step. We keep a direction along which the
/// two hulls are farther apart than a contact may be: it saves that work, and mostly still separates them in the
/// next step (Chung and Wang, "Quick elimination of non-interference polytopes in virtual environments", 1996).
///
/// Where there is none, GJK begins with the corners between which the nearest points were in the last step, and ends at once
/// where they still are there (Cameron, "Enhancing GJK: computing minimum and penetration distances between convex
/// polyhedra", 1997). Where it comes to no clear end (hulls overlap by more than their margins, or nearly), Bullet decides.
/// What stands as it did is not looked at (steady_pairs.hpp).
class HullPair final : public btCollisionAlgorithm {
 public:
  HullPair(const btCollisionAlgorithmConstructionInfo& info, btConvexPenetrationDepthSolver& depths)
      : btCollisionAlgorithm(info), depths_(depths) {}
  ~HullPair() override;
  void processCollision(const btCollisionObjectWrapper* first, const btCollisionObjectWrapper* second,
                        const btDispatcherInfo& info, btManifoldResult* result) override;
  /// The same without regard to how they stood. Metres by which the two are apart beyond the reach of contacts; zero: not
  /// known.
  btScalar collide(const btCollisionObjectWrapper& first, const btCollisionObjectWrapper& second,
                   btManifoldResult& result);
  /// What is fast enough for it is a ball, which Bullet sweeps.
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
  struct Hulls;    ///< the two, as the first sees them
  struct Contact;  ///< in the first's frame
  enum class Outcome { kApart, kNear, kUnclear };

  btScalar gap(const Hulls& hulls);
  Outcome nearest(const Hulls& hulls, Contact& contact, btScalar& beyond);
  bool asked_of_bullet(const Hulls& hulls, Contact& contact) const;

  btConvexPenetrationDepthSolver& depths_;
  Steadiness steadiness_;
  btPersistentManifold* manifold_ = nullptr;  ///< null: they have not touched yet
  btManifoldArray manifolds_;
  /// Metres: as far apart there is no contact in Bullet either, by the rule of its dispatcher. Negative: not known yet.
  btScalar reach_ = -1;
  btVector3 direction_{0, 0, 0};  ///< from the first to the second, in the first's frame; zero: none yet
  /// Between which the nearest points were, each in its own hull's frame.
  struct Corners {
    btVector3 first, second;
  };
  std::array<Corners, 3> corners_;
  int known_ = 0;  ///< of them
};

}  // namespace fracture::world
