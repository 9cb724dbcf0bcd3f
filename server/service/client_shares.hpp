// Memory that the requests of all clients hold together, of which no client (an address, or a name) may hold
// more than its share.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <unordered_map>

#include "server/service/memory_budget.hpp"

namespace fracture {

/// Thread-safe. Outlives its reservations.
class ClientShares {
 public:
  /// `share` is what one address may hold (of no meaning where it is the whole), `small_share` of the small
  /// ones; a lone reservation of an address may exceed it.
  ClientShares(std::uint64_t capacity, std::uint64_t share, MemoryBudget::SmallPool small,
               std::uint64_t small_share)
      : whole_(capacity, small), share_(share), make_share_([share, small_share, small] {
          return new MemoryBudget(share, {small_share, small.largest}, MemoryBudget::Alone::kMayExceed);
        }) {}
  /// The same of one pool with headroom for small reservations: of an address these may have `small_share` beside
  /// what its large ones hold.
  ClientShares(const MemoryBudget::Divided& whole, std::uint64_t share, std::uint64_t small_share)
      : whole_(whole), share_(share), make_share_([whole, share, small_share] {
          return new MemoryBudget({share + small_share, small_share, whole.largest_small},
                                  MemoryBudget::Alone::kMayExceed);
        }) {}

  /// Of nothing yet. Nobody in particular ("") has no share.
  MemoryBudget::Reservation begin(const std::string& address) {
    if (share_ >= whole_.capacity() || address.empty()) return MemoryBudget::Reservation(whole_);
    return {whole_, of(address)};
  }

  MemoryBudget& whole() { return whole_; }
  const MemoryBudget& whole() const { return whole_; }
  std::uint64_t share() const { return share_; }

 private:
  std::shared_ptr<MemoryBudget> of(const std::string& address) {
    const auto alive = [&] {
      const auto at = by_address_.find(address);
      return at == by_address_.end() ? nullptr : at->second.lock();
    };
    {
      const std::lock_guard lock(mutex_);
      if (auto known = alive()) return known;
    }
    // Forgotten with its last reservation, for which the lock must be free: also where there is no memory to
    // make it.
    std::shared_ptr<MemoryBudget> fresh(make_share_(), [this, address](MemoryBudget* gone) {
      delete gone;
      const std::lock_guard forgetting(mutex_);
      const auto at = by_address_.find(address);
      if (at != by_address_.end() && at->second.expired()) by_address_.erase(at);
    });
    const std::lock_guard lock(mutex_);
    if (auto known = alive()) return known;
    by_address_[address] = fresh;
    return fresh;
  }

  MemoryBudget whole_;
  const std::uint64_t share_;
  const std::function<MemoryBudget*()> make_share_;
  std::mutex mutex_;
  std::unordered_map<std::string, std::weak_ptr<MemoryBudget>> by_address_;
};

}  // namespace fracture
