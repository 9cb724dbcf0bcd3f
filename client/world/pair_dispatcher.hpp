// Bullet's dispatcher of pairs of bodies, on several threads. Private to this folder.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "client/world/bullet.hpp"
#include "client/world/crew.hpp"

namespace fracture::world {

/// Finds the contacts of all pairs whose boxes overlap. Each pair has its own algorithm and contacts, so that pairs can be
/// looked at in any order; what pairs share is the list of all contacts, whose order the solver goes by. Pairs are sorted
/// and cut into chunks of a fixed size, each chunk notes what it adds to the list and takes from it, and afterwards that is
/// done in the order of the chunks: the list is the same with any number of threads (Box2D 3 does so with its islands:
/// Catto, "Determinism", 2024). Bullet's own dispatcher
/// for threads leaves the order to chance.
class PairDispatcher final : public btCollisionDispatcher {
 public:
  /// `threads`: with the caller's; they are started when they are needed for the first time.
  PairDispatcher(btCollisionConfiguration* configuration, std::size_t threads);
  void dispatchAllCollisionPairs(btOverlappingPairCache* cache, const btDispatcherInfo& info,
                                 btDispatcher* dispatcher) override;
  // Bullet's pools are for one thread.
  btPersistentManifold* getNewManifold(const btCollisionObject* first,
                                       const btCollisionObject* second) override;
  void releaseManifold(btPersistentManifold* manifold) override;
  void* allocateCollisionAlgorithm(int size) override;
  void freeCollisionAlgorithm(void* algorithm) override;

 private:
  struct Work {
    std::uint64_t order;
    btBroadphasePair* pair;
  };
  struct Chunk {
    std::vector<btPersistentManifold*> made, released;
  };
  void look_at(btBroadphasePair& pair, const btDispatcherInfo& info);
  void add(btPersistentManifold* manifold);

  static thread_local Chunk* chunk_;  ///< that this thread is at; null: none
  std::size_t threads_;
  std::unique_ptr<Crew> crew_;
  std::vector<Work> work_;
  std::vector<Chunk> chunks_;
};

}  // namespace fracture::world
