#include "client/world/hull_pairs.hpp"

#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>
#include <BulletCollision/NarrowPhaseCollision/btConvexPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>

namespace fracture::world {
namespace {

constexpr int kMostRounds = 32;  ///< of GJK; with a good start, two or three are enough
/// Relative to the squared distance: a smaller improvement ends the search. The distance then has eight
/// correct digits, its direction four.
constexpr btScalar kNearEnough = 1e-8;
/// Metres: between nearer hulls the direction is uncertain. Margins are a hundred times as wide.
constexpr btScalar kTooNear = 1e-5;

}  // namespace

struct HullPair::Hulls {
  const btConvexShape &a, &b;
  btTransform b_in_a;

  /// The corner of the Minkowski difference that is farthest in the direction −`v`.
  Corners corners(const btVector3& v) const {
    return {a.localGetSupportVertexWithoutMarginNonVirtual(-v),
            b.localGetSupportVertexWithoutMarginNonVirtual(v * b_in_a.getBasis())};
  }
};

struct HullPair::Contact {
  btVector3 normal, on_second;  ///< the normal points to the first; both include the margins
  btScalar distance;
};

HullPair::~HullPair() {
  if (manifold_ != nullptr) m_dispatcher->releaseManifold(manifold_);
}

void HullPair::getAllContactManifolds(btManifoldArray& manifolds) {
  if (manifold_ != nullptr) manifolds.push_back(manifold_);
}

btScalar HullPair::gap(const Hulls& hulls) {
  constexpr int kTries = 2;  // further tries rarely succeed and cost as much as GJK
  btVector3 direction = direction_;
  if (direction.fuzzyZero()) direction = hulls.b_in_a.getOrigin();  // origins are the centres of mass
  for (int k = 0; k < kTries && !direction.fuzzyZero(); ++k) {
    direction.normalize();
    const Corners ends = hulls.corners(-direction);
    const btVector3 way = hulls.b_in_a * ends.second - ends.first;
    if (const btScalar beyond = way.dot(direction) - reach_; beyond > 0) {
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

/// GJK (Gilbert, Johnson and Keerthi 1988) for the hulls without their margins, with Bullet's rule for the
/// nearest point of a simplex (Ericson, "Real-Time Collision Detection", 2005).
HullPair::Outcome HullPair::nearest(const Hulls& hulls, Contact& contact, btScalar& beyond) {
  btVoronoiSimplexSolver simplex;
  simplex.reset();
  btVector3 v = hulls.b_in_a.getOrigin();
  btScalar square = BT_LARGE_FLOAT;  // of the distance found so far
  for (int k = 0; k < known_; ++k) {
    const Corners& ends = corners_[static_cast<std::size_t>(k)];
    const btVector3 there = hulls.b_in_a * ends.second;
    simplex.addVertex(ends.first - there, ends.first, there);
  }
  if (known_ > 0 && simplex.closest(v)) {
    square = v.length2();
  } else {
    simplex.reset();
    v = direction_.fuzzyZero() ? -hulls.b_in_a.getOrigin() : -direction_;
  }
  known_ = 0;
  for (int round = 0; round < kMostRounds; ++round) {
    const btScalar length2 = v.length2();
    if (!(length2 > kTooNear * kTooNear)) return Outcome::kUnclear;
    const Corners ends = hulls.corners(v);
    const btVector3 there = hulls.b_in_a * ends.second, w = ends.first - there;
    const btScalar along = v.dot(w);  // lower bound on the distance, along `v`
    if (along > 0 && along * along > length2 * reach_ * reach_) {
      direction_ = -v / btSqrt(length2);
      beyond = along / btSqrt(length2) - reach_;
      return Outcome::kApart;
    }
    if (square - along <= kNearEnough * square || simplex.inSimplex(w)) {
      btVector3 on_first, on_second;
      simplex.compute_points(on_first, on_second);
      const btScalar length = btSqrt(length2);
      contact.normal = v / length;
      contact.distance = length - hulls.a.getMarginNonVirtual() - hulls.b.getMarginNonVirtual();
      contact.on_second = on_second + hulls.b.getMarginNonVirtual() * contact.normal;
      direction_ = -contact.normal;
      const int count = simplex.numVertices();
      if (count > static_cast<int>(corners_.size())) return Outcome::kUnclear;
      for (int k = 0; k < count; ++k)
        corners_[static_cast<std::size_t>(k)] = {simplex.m_simplexPointsP[k],
                                                 hulls.b_in_a.invXform(simplex.m_simplexPointsQ[k])};
      known_ = count;
      return Outcome::kNear;
    }
    simplex.addVertex(w, ends.first, there);
    if (!simplex.closest(v) || simplex.fullSimplex()) return Outcome::kUnclear;
    const btScalar now = v.length2();
    if (!(now < square)) return Outcome::kUnclear;
    square = now;
  }
  return Outcome::kUnclear;
}

/// Bullet's result from scratch, which also handles overlap.
bool HullPair::asked_of_bullet(const Hulls& hulls, Contact& contact) const {
  btVoronoiSimplexSolver simplex;
  btGjkPairDetector detector(&hulls.a, &hulls.b, &simplex, &depths_);
  btGjkPairDetector::ClosestPointInput input;
  input.m_transformA.setIdentity();
  input.m_transformB = hulls.b_in_a;
  input.m_maximumDistanceSquared = reach_ * reach_;
  struct Found final : btDiscreteCollisionDetectorInterface::Result {
    explicit Found(Contact& c) : contact(c) {}
    void setShapeIdentifiersA(int, int) override {}
    void setShapeIdentifiersB(int, int) override {}
    void addContactPoint(const btVector3& normal, const btVector3& on_second, btScalar distance) override {
      contact = {normal, on_second, distance};
      any = true;
    }
    Contact& contact;
    bool any = false;
  } found(contact);
  detector.getClosestPoints(input, found, nullptr);
  return found.any;
}

btScalar HullPair::collide(const btCollisionObjectWrapper& first, const btCollisionObjectWrapper& second,
                           btManifoldResult& result) {
  const Hulls hulls{*static_cast<const btConvexShape*>(first.getCollisionShape()),
                    *static_cast<const btConvexShape*>(second.getCollisionShape()),
                    first.getWorldTransform().inverseTimes(second.getWorldTransform())};
  const btScalar margins = hulls.a.getMarginNonVirtual() + hulls.b.getMarginNonVirtual();
  if (reach_ < 0)
    reach_ = margins + btMin(first.getCollisionObject()->getCollisionShape()->getContactBreakingThreshold(
                                 gContactBreakingThreshold),
                             second.getCollisionObject()->getCollisionShape()->getContactBreakingThreshold(
                                 gContactBreakingThreshold));
  // Bullet decides whether to keep or drop contacts of the last step.
  const bool touched = manifold_ != nullptr && manifold_->getNumContacts() > 0;
  if (!touched)
    if (const btScalar beyond = gap(hulls); beyond > 0) return beyond;
  Contact contact{};
  btScalar beyond = 0;
  const Outcome outcome = nearest(hulls, contact, beyond);
  const bool found =
      outcome == Outcome::kNear || (outcome == Outcome::kUnclear && asked_of_bullet(hulls, contact));
  if (found && contact.distance + margins <= reach_) {
    if (manifold_ == nullptr)
      manifold_ = m_dispatcher->getNewManifold(first.getCollisionObject(), second.getCollisionObject());
    result.setPersistentManifold(manifold_);
    result.addContactPoint(first.getWorldTransform().getBasis() * contact.normal,
                           first.getWorldTransform() * contact.on_second, contact.distance);
  }
  if (manifold_ == nullptr) return beyond;
  result.setPersistentManifold(manifold_);
  result.refreshContactPoints();
  return manifold_->getNumContacts() > 0 ? 0 : beyond;
}

void HullPair::processCollision(const btCollisionObjectWrapper* first, const btCollisionObjectWrapper* second,
                                const btDispatcherInfo&, btManifoldResult* result) {
  if (steadiness_.holds(*first, *second))
    refresh_contacts(*this, manifolds_);
  else
    steadiness_.part(collide(*first, *second, *result));
}

btCollisionAlgorithm* HullPair::CreateFunc::CreateCollisionAlgorithm(
    btCollisionAlgorithmConstructionInfo& info, const btCollisionObjectWrapper*,
    const btCollisionObjectWrapper*) {
  void* memory = info.m_dispatcher1->allocateCollisionAlgorithm(sizeof(HullPair));
  return new (memory) HullPair(info, depths);
}

}  // namespace fracture::world
