// Bullet's dispatcher of pairs of bodies, using several threads. Private to this folder.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "client/world/bullet.hpp"
#include "client/world/crew.hpp"

namespace fracture::world {

/// Finds the contacts of all pairs whose boxes overlap. Each pair has its own algorithm and contacts, so
/// pairs can be processed in any order. They share only the list of all contacts, and the solver depends on
/// its order. So pairs are sorted and cut into chunks of fixed size, and each chunk notes its additions to
/// the list and removals from it. These are applied afterwards in chunk order, so the list is the same with
/// any number of threads. (Box2D 3 treats its islands the same way: Catto, "Determinism", 2024.) In Bullet's
/// own threaded dispatcher, the order is random.
class PairDispatcher final : public btCollisionDispatcher {
 public:
  /// `threads`: including the caller's. They are started when first needed.
  PairDispatcher(btCollisionConfiguration* configuration, std::size_t threads);
  void dispatchAllCollisionPairs(btOverlappingPairCache* cache, const btDispatcherInfo& info,
                                 btDispatcher* dispatcher) override;
  // Bullet's pools are not thread-safe.
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

  static thread_local Chunk* chunk_;  ///< the chunk that this thread processes; null: none
  std::size_t threads_;
  std::unique_ptr<Crew> crew_;
  std::vector<Work> work_;
  std::vector<Chunk> chunks_;
};

}  // namespace fracture::world
