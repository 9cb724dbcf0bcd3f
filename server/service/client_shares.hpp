// Memory that the requests of all clients share. No client (an address, or a name) may hold more than its share.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <unordered_map>

#include "server/service/memory_budget.hpp"

namespace fracture {

/// Thread-safe. Must outlive its reservations.
class ClientShares {
 public:
  /// `share`: bytes that a client may hold if it is the only one; if it equals the capacity, clients have no shares.
  /// `small_share`: the limit for small reservations. If others hold much, a client may hold less (FairShare).
  ClientShares(std::uint64_t capacity, std::uint64_t share, MemoryBudget::SmallPool small,
               std::uint64_t small_share)
      : whole_(capacity, small, {share, small_share}), share_(share) {}
  /// As above, but with a single pool that keeps headroom for small reservations.
  ClientShares(const MemoryBudget::Divided& whole, std::uint64_t share)
      : whole_(whole, {share, share}), share_(share) {}

  /// Returns an empty reservation for this client. An unnamed client ("") has no share; only the capacity limits it.
  MemoryBudget::Reservation begin(const std::string& client,
                                  MemoryBudget::Use use = MemoryBudget::Use::kWaitedFor) {
    if (!has_share(client)) return MemoryBudget::Reservation(whole_, use);
    return {whole_, of(client), use};
  }
  /// Returns the verdict that a new reservation of this size would get now.
  MemoryBudget::Verdict judge(const std::string& client, std::uint64_t bytes,
                              MemoryBudget::Use use = MemoryBudget::Use::kWaitedFor,
                              MemoryBudget::Limit limit = MemoryBudget::Limit::kUsual) {
    return whole_.judge(has_share(client) ? of(client).get() : nullptr, bytes, use, limit);
  }

  /// Returns whether this client has a share and holds none of it now, apart from small reservations.
  bool is_newcomer(const std::string& client) {
    return has_share(client) && whole_.held_by(*of(client)) == 0;
  }

  /// Returns the bytes that this client holds in large reservations.
  std::uint64_t held_by(const std::string& client) {
    return has_share(client) ? whole_.held_by(*of(client)) : 0;
  }
  /// Returns this client's even part of the memory for large reservations (MemoryBudget::even_part).
  std::uint64_t even_part(const std::string& client) { return whole_.even_part(*of(client)); }

  MemoryBudget& whole() { return whole_; }
  const MemoryBudget& whole() const { return whole_; }
  std::uint64_t share() const { return share_; }
  /// The most that a prediction may reserve. Work that needs more grows while it runs. So an uncertain prediction always leaves
  /// some memory to other clients.
  std::uint64_t most_at_once() const { return std::min(share_, whole_.capacity()); }

 private:
  using Client = MemoryBudget::Client;

  bool has_share(const std::string& client) const { return share_ < whole_.capacity() && !client.empty(); }
  std::shared_ptr<Client> of(const std::string& name) {
    const auto alive = [&] {
      const auto at = clients_.find(name);
      return at == clients_.end() ? nullptr : at->second.lock();
    };
    {
      const std::lock_guard lock(mutex_);
      if (auto known = alive()) return known;
    }
    // The deleter forgets the client together with its last reservation. It takes the lock, so the lock must not be held
    // here: if the allocation fails, the deleter runs at once.
    std::shared_ptr<Client> fresh(new Client, [this, name](Client* gone) {
      delete gone;
      const std::lock_guard forgetting(mutex_);
      const auto at = clients_.find(name);
      if (at != clients_.end() && at->second.expired()) clients_.erase(at);
    });
    const std::lock_guard lock(mutex_);
    if (auto known = alive()) return known;
    clients_[name] = fresh;
    return fresh;
  }

  MemoryBudget whole_;
  const std::uint64_t share_;
  std::mutex mutex_;
  std::unordered_map<std::string, std::weak_ptr<Client>> clients_;
};

}  // namespace fracture
