#include "client/world/compound_pairs.hpp"

#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>
#include <LinearMath/btAabbUtil2.h>

#include <algorithm>
#include <utility>

namespace fracture::world {
namespace {

/// Minimum number of hulls for which a body's tree is used to find near hulls.
constexpr int kMany = 8;
/// Metres around a hull's box in which the tree is searched. Hulls that it does not find are at least this
/// far away.
constexpr btScalar kAround = 0.02;

struct Box {
  btVector3 low, high;
};

/// Distance in metres along the axis that separates the two most. Negative: they overlap.
btScalar between(const Box& a, const Box& b) {
  btScalar most = -SIMD_INFINITY;
  for (int axis = 0; axis < 3; ++axis)
    most = btMax(most, btMax(b.low[axis] - a.high[axis], a.low[axis] - b.high[axis]));
  return most;
}

Box seen_from(const btTransform& frame, const Box& box) {
  Box seen;
  btTransformAabb(box.low, box.high, 0, frame, seen.low, seen.high);
  return seen;
}

/// The hulls of a body: one or more.
class Hulls {
 public:
  explicit Hulls(const btCollisionObjectWrapper& body) : body_(body) {
    if (body.getCollisionShape()->isCompound())
      compound_ = static_cast<const btCompoundShape*>(body.getCollisionShape());
    else
      body.getCollisionShape()->getAabb(btTransform::getIdentity(), only_.low, only_.high);
  }
  int count() const { return compound_ != nullptr ? compound_->getNumChildShapes() : 1; }
  const btDbvt* tree() const { return compound_ != nullptr ? compound_->getDynamicAabbTree() : nullptr; }
  Box box(int k) const {
    if (compound_ == nullptr) return only_;
    // Bullet gives the list only to callers that may change it.
    const btDbvtNode* node = const_cast<btCompoundShape*>(compound_)->getChildList()[k].m_node;
    if (node != nullptr) return {node->volume.Mins(), node->volume.Maxs()};
    Box box;
    compound_->getChildShape(k)->getAabb(compound_->getChildTransform(k), box.low, box.high);
    return box;
  }
  const btCollisionShape* shape(int k) const {
    return compound_ != nullptr ? compound_->getChildShape(k) : body_.getCollisionShape();
  }
  btTransform place(int k) const {
    return compound_ != nullptr ? body_.getWorldTransform() * compound_->getChildTransform(k)
                                : body_.getWorldTransform();
  }
  int index(int k) const { return compound_ != nullptr ? k : -1; }
  const btCollisionObjectWrapper& body() const { return body_; }

 private:
  const btCollisionObjectWrapper& body_;
  const btCompoundShape* compound_ = nullptr;
  Box only_{};
};

/// Calls `found` for each leaf that a query of the tree returns.
template <class Found>
struct Leaves : btDbvt::ICollide {
  explicit Leaves(Found f) : found(std::move(f)) {}
  void Process(const btDbvtNode* leaf) override { found(leaf->dataAsInt); }
  Found found;
};

}  // namespace

/// Arguments of a check of two bodies.
struct CompoundPair::Look {
  const Hulls &first, &second;
  btManifoldResult& result;
};

CompoundPair::~CompoundPair() {
  for (const Meeting& meeting : meetings_) free(meeting);
}

void CompoundPair::free(const Meeting& meeting) {
  meeting.pair->~HullPair();
  m_dispatcher->freeCollisionAlgorithm(meeting.pair);
}

void CompoundPair::getAllContactManifolds(btManifoldArray& manifolds) {
  for (const Meeting& meeting : meetings_) meeting.pair->getAllContactManifolds(manifolds);
}

void CompoundPair::meet(const Look& look, int first, int second, btScalar& gap) {
  // Bullet's wrappers only refer to the transforms, so these must stay alive.
  const btTransform place_of_first = look.first.place(first), place_of_second = look.second.place(second);
  const btCollisionObjectWrapper a(&look.first.body(), look.first.shape(first),
                                   look.first.body().getCollisionObject(), place_of_first, -1,
                                   look.first.index(first)),
      b(&look.second.body(), look.second.shape(second), look.second.body().getCollisionObject(),
        place_of_second, -1, look.second.index(second));
  auto at = std::lower_bound(meetings_.begin(), meetings_.end(), std::pair(first, second),
                             [](const Meeting& meeting, const std::pair<int, int>& key) {
                               return std::pair(meeting.first, meeting.second) < key;
                             });
  if (at == meetings_.end() || at->first != first || at->second != second) {
    btCollisionAlgorithmConstructionInfo info;
    info.m_dispatcher1 = m_dispatcher;
    auto* pair = static_cast<HullPair*>(hulls_.CreateCollisionAlgorithm(info, &a, &b));
    at = meetings_.insert(at, {first, second, pair, true});
  }
  at->seen = true;
  btManifoldResult& result = look.result;
  const btCollisionObjectWrapper *const of_first = result.getBody0Wrap(), *const of_second =
                                                                              result.getBody1Wrap();
  result.setBody0Wrap(&a);
  result.setBody1Wrap(&b);
  result.setShapeIdentifiersA(-1, look.first.index(first));
  result.setShapeIdentifiersB(-1, look.second.index(second));
  gap = btMin(gap, at->pair->collide(a, b, result));
  result.setBody0Wrap(of_first);
  result.setBody1Wrap(of_second);
}

void CompoundPair::processCollision(const btCollisionObjectWrapper* first,
                                    const btCollisionObjectWrapper* second, const btDispatcherInfo&,
                                    btManifoldResult* result) {
  if (steadiness_.holds(*first, *second)) {
    if (!meetings_.empty()) refresh_contacts(*this, manifolds_);
    return;
  }
  const Hulls a(*first), b(*second);
  const Look look{a, b, *result};
  for (Meeting& meeting : meetings_) meeting.seen = false;
  // Compares each hull of the body that has fewer hulls with all hulls of the other body.
  const bool first_has_more = a.count() >= b.count();
  const Hulls &many = first_has_more ? a : b, &few = first_has_more ? b : a;
  const btTransform few_in_many =
                        many.body().getWorldTransform().inverseTimes(few.body().getWorldTransform()),
                    many_in_few = few_in_many.inverse();
  const bool ask_tree = many.count() >= kMany && many.tree() != nullptr;
  btScalar gap = ask_tree ? kAround : SIMD_INFINITY;
  for (int k = 0; k < few.count(); ++k) {
    const Box mine = few.box(k), seen = seen_from(few_in_many, mine);
    const auto compare = [&](int other) {
      const Box its = many.box(other);
      btScalar apart = between(its, seen);
      if (!(apart > 0)) apart = between(mine, seen_from(many_in_few, its));
      if (apart > 0)
        gap = btMin(gap, apart);
      else
        meet(look, first_has_more ? other : k, first_has_more ? k : other, gap);
    };
    if (ask_tree) {
      const btVector3 around(kAround, kAround, kAround);
      Leaves leaves(compare);
      many.tree()->collideTV(many.tree()->m_root, btDbvtVolume::FromMM(seen.low - around, seen.high + around),
                             leaves);
    } else {
      for (int other = 0; other < many.count(); ++other) compare(other);
    }
  }
  std::erase_if(meetings_, [&](const Meeting& meeting) {
    if (!meeting.seen) free(meeting);
    return !meeting.seen;
  });
  steadiness_.part(gap);
}

btCollisionAlgorithm* CompoundPair::CreateFunc::CreateCollisionAlgorithm(
    btCollisionAlgorithmConstructionInfo& info, const btCollisionObjectWrapper*,
    const btCollisionObjectWrapper*) {
  void* memory = info.m_dispatcher1->allocateCollisionAlgorithm(sizeof(CompoundPair));
  return new (memory) CompoundPair(info, hulls);
}

}  // namespace fracture::world
