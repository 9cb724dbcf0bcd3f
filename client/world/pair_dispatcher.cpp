#include "client/world/pair_dispatcher.hpp"

#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>

#include <algorithm>
#include <functional>

namespace fracture::world {
namespace {

constexpr std::size_t kChunk = 16;  ///< pairs: some tens of microseconds of work
constexpr std::size_t kFew = 96;    ///< pairs that are processed before a helper is woken

btCollisionObject* object_of(const btBroadphaseProxy* proxy) {
  return static_cast<btCollisionObject*>(proxy->m_clientObject);
}

}  // namespace

thread_local PairDispatcher::Chunk* PairDispatcher::chunk_ = nullptr;

PairDispatcher::PairDispatcher(btCollisionConfiguration* configuration, std::size_t threads)
    : btCollisionDispatcher(configuration), threads_(threads) {}

void PairDispatcher::look_at(btBroadphasePair& pair, const btDispatcherInfo& info) {
  btCollisionObject &first = *object_of(pair.m_pProxy0), &second = *object_of(pair.m_pProxy1);
  const btCollisionObjectWrapper a(nullptr, first.getCollisionShape(), &first, first.getWorldTransform(), -1,
                                   -1),
      b(nullptr, second.getCollisionShape(), &second, second.getWorldTransform(), -1, -1);
  if (pair.m_algorithm == nullptr)
    pair.m_algorithm = findAlgorithm(&a, &b, nullptr, BT_CONTACT_POINT_ALGORITHMS);
  btManifoldResult result(&a, &b);
  pair.m_algorithm->processCollision(&a, &b, info, &result);
}

void PairDispatcher::dispatchAllCollisionPairs(btOverlappingPairCache* cache, const btDispatcherInfo& info,
                                               btDispatcher*) {
  work_.clear();
  btBroadphasePair* pairs = cache->getOverlappingPairArrayPtr();
  for (int k = 0; k < cache->getNumOverlappingPairs(); ++k) {
    const btBroadphaseProxy &first = *pairs[k].m_pProxy0, &second = *pairs[k].m_pProxy1;
    if (!needsCollision(object_of(&first), object_of(&second))) continue;
    const auto a = static_cast<std::uint32_t>(first.m_uniqueId),
               b = static_cast<std::uint32_t>(second.m_uniqueId);
    work_.push_back({std::uint64_t{a} << 32 | b, &pairs[k]});
  }
  std::sort(work_.begin(), work_.end(), [](const Work& a, const Work& b) { return a.order < b.order; });
  const std::size_t count = (work_.size() + kChunk - 1) / kChunk;
  if (chunks_.size() < count) chunks_.resize(count);
  std::atomic<std::size_t> next = 0;
  const auto help = [&] {
    for (std::size_t c = next++; c < count; c = next++) {
      chunk_ = &chunks_[c];
      for (std::size_t k = c * kChunk; k < std::min(work_.size(), (c + 1) * kChunk); ++k)
        look_at(*work_[k].pair, info);
      chunk_ = nullptr;
    }
  };
  if (threads_ > 1 && work_.size() > kFew) {
    if (!crew_) crew_ = std::make_unique<Crew>(threads_ - 1);
    crew_->run(help);
  } else {
    help();
  }
  for (std::size_t c = 0; c < count; ++c) {
    for (btPersistentManifold* manifold : chunks_[c].made) add(manifold);
    for (btPersistentManifold* manifold : chunks_[c].released)
      btCollisionDispatcher::releaseManifold(manifold);
    chunks_[c].made.clear();
    chunks_[c].released.clear();
  }
}

void PairDispatcher::add(btPersistentManifold* manifold) {
  manifold->m_index1a = m_manifoldsPtr.size();
  m_manifoldsPtr.push_back(manifold);
}

btPersistentManifold* PairDispatcher::getNewManifold(const btCollisionObject* first,
                                                     const btCollisionObject* second) {
  const btScalar breaks =
      btMin(first->getCollisionShape()->getContactBreakingThreshold(gContactBreakingThreshold),
            second->getCollisionShape()->getContactBreakingThreshold(gContactBreakingThreshold));
  const btScalar counts =
      btMin(first->getContactProcessingThreshold(), second->getContactProcessingThreshold());
  auto* manifold = new (btAlignedAlloc(sizeof(btPersistentManifold), 16))
      btPersistentManifold(first, second, 0, breaks, counts);
  if (chunk_ != nullptr)
    chunk_->made.push_back(manifold);
  else
    add(manifold);
  return manifold;
}

void PairDispatcher::releaseManifold(btPersistentManifold* manifold) {
  if (chunk_ != nullptr)
    chunk_->released.push_back(manifold);
  else
    btCollisionDispatcher::releaseManifold(manifold);
}

void* PairDispatcher::allocateCollisionAlgorithm(int size) {
  return btAlignedAlloc(static_cast<std::size_t>(size), 16);
}

void PairDispatcher::freeCollisionAlgorithm(void* algorithm) { btAlignedFree(algorithm); }

}  // namespace fracture::world
