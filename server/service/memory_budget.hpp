// Bytes that requests may hold at the same time: without it, the limit of one body times the limit of
// connections is what a few clients can make the process allocate.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <utility>

#include "server/service/fair_share.hpp"

namespace fracture {

/// Thread-safe. The sum of all reservations is at most the capacity. Small reservations may have a pool of
/// their own, so that they never wait for large ones.
class MemoryBudget {
 public:
  struct SmallPool {
    std::uint64_t capacity;
    std::uint64_t largest;  ///< bytes of a reservation that is still small
  };

  /// One pool, of which only small reservations may take all: large ones leave them their headroom.
  struct Divided {
    std::uint64_t capacity;
    std::uint64_t headroom;
    std::uint64_t largest_small;  ///< bytes of a reservation that is still small
  };

  /// What one client may hold when it is the only one (FairShare), of each size for itself.
  struct Shares {
    std::uint64_t large, small;
  };
  static constexpr Shares kNoShares{UINT64_MAX, UINT64_MAX};
  /// The bytes that one client holds. Guarded by the budget.
  struct Client {
    std::uint64_t large = 0, small = 0;
  };

  explicit MemoryBudget(std::uint64_t capacity) : MemoryBudget(capacity, {0, 0}) {}
  explicit MemoryBudget(const Divided& divided) : MemoryBudget(divided, kNoShares) {}
  MemoryBudget(const Divided& divided, const Shares& shares)
      : large_{divided.capacity},
        small_{0},
        largest_small_(divided.largest_small),
        headroom_(divided.headroom),
        shares_(shares) {}
  MemoryBudget(std::uint64_t capacity, SmallPool small) : MemoryBudget(capacity, small, kNoShares) {}
  MemoryBudget(std::uint64_t capacity, SmallPool small, const Shares& shares)
      : large_{capacity}, small_{small.capacity}, largest_small_(small.largest), shares_(shares) {}

  /// A part of the budget, given back by its destructor.
  class Reservation {
   public:
    Reservation() = default;
    explicit Reservation(MemoryBudget& budget) : budget_(&budget) {}
    /// Counted as the client's, too; `budget` outlives the reservation.
    Reservation(MemoryBudget& budget, std::shared_ptr<Client> client)
        : budget_(&budget), client_(std::move(client)) {}
    Reservation(Reservation&& other) noexcept
        : budget_(std::exchange(other.budget_, nullptr)),
          client_(std::move(other.client_)),
          bytes_(std::exchange(other.bytes_, 0)),
          over_share_(other.over_share_) {}
    Reservation& operator=(Reservation&& other) noexcept {
      std::swap(budget_, other.budget_);
      std::swap(client_, other.client_);
      std::swap(bytes_, other.bytes_);
      std::swap(over_share_, other.over_share_);
      return *this;
    }
    ~Reservation() {
      if (budget_) budget_->change(client_.get(), bytes_, 0);
    }

    std::uint64_t bytes() const { return bytes_; }
    /// Makes it at least `bytes`; false, and nothing changes, when the budget has not that much left for this client.
    bool grow_to(std::uint64_t bytes) {
      if (bytes <= bytes_) return true;
      const Verdict verdict = budget_->grow(client_.get(), bytes_, bytes);
      over_share_ = verdict == Verdict::kOverShare;
      if (verdict != Verdict::kFits) return false;
      bytes_ = bytes;
      return true;
    }
    /// Makes it at most `bytes`. One that is no longer small stays as large as the first that is not: what it
    /// leaves is not to be missing where it would go.
    void shrink_to(std::uint64_t bytes) {
      if (budget_) bytes = budget_->shrunk(bytes_, bytes);
      if (!budget_ || bytes >= bytes_) return;
      budget_->change(client_.get(), bytes_, bytes);
      bytes_ = bytes;
    }
    /// The last grow_to() failed because of what the same client holds besides.
    bool over_share() const { return over_share_; }

   private:
    MemoryBudget* budget_ = nullptr;
    std::shared_ptr<Client> client_;
    std::uint64_t bytes_ = 0;
    bool over_share_ = false;
  };

  std::uint64_t used() const {
    const std::lock_guard lock(mutex_);
    return large_.used + small_.used;
  }
  std::uint64_t small_used() const {
    const std::lock_guard lock(mutex_);
    return small_.used;
  }
  /// What a single reservation may have.
  std::uint64_t capacity() const { return large_.capacity - headroom_; }

  enum class Verdict {
    kFits,
    kFull,
    kOverShare,  ///< because of what the same client holds besides
  };
  /// What a new reservation of so many bytes would be told. `client` is null for nobody in particular.
  Verdict judge(const Client* client, std::uint64_t bytes) const {
    const std::lock_guard lock(mutex_);
    const std::uint64_t own = client ? held(*client, bytes) : 0;
    return judge(client != nullptr, bytes, own + bytes, pool(bytes).used + bytes,
                 clients(bytes) - (own > 0 ? 1 : 0));
  }

 private:
  struct Pool {
    const std::uint64_t capacity;
    std::uint64_t used = 0;
  };

  bool is_small(std::uint64_t bytes) const { return bytes <= largest_small_; }
  /// By a client, in reservations as small or large as these bytes; and how many clients hold such.
  std::uint64_t held(const Client& client, std::uint64_t bytes) const {
    return is_small(bytes) ? client.small : client.large;
  }
  std::size_t clients(std::uint64_t bytes) const { return is_small(bytes) ? small_clients_ : large_clients_; }
  bool has_small_pool() const { return small_.capacity > 0; }
  const Pool& pool(std::uint64_t bytes) const {
    return is_small(bytes) && has_small_pool() ? small_ : large_;
  }
  std::uint64_t shrunk(std::uint64_t from, std::uint64_t to) const {
    return has_small_pool() && !is_small(from) ? std::max(to, largest_small_ + 1) : to;
  }
  /// `own` and `used` with the reservation of so many bytes.
  Verdict judge(bool has_share, std::uint64_t bytes, std::uint64_t own, std::uint64_t used,
                std::size_t others) const {
    const std::uint64_t most = pool(bytes).capacity - (is_small(bytes) ? 0 : headroom_);
    if (!has_share) return used <= most ? Verdict::kFits : Verdict::kFull;
    const FairShare fair{most, is_small(bytes) ? shares_.small : shares_.large};
    const bool alone = own == bytes;
    if (fair.allows(own, used, others, alone)) return Verdict::kFits;
    return !alone && (used <= most || own > fair.share) ? Verdict::kOverShare : Verdict::kFull;
  }
  Verdict grow(Client* client, std::uint64_t from, std::uint64_t to) {
    const std::lock_guard lock(mutex_);
    move(client, from, to);
    const Verdict verdict = client ? judge(true, to, held(*client, to), pool(to).used, clients(to) - 1)
                                   : judge(false, to, to, pool(to).used, 0);
    if (verdict != Verdict::kFits) move(client, to, from);
    return verdict;
  }
  void change(Client* client, std::uint64_t from, std::uint64_t to) {
    const std::lock_guard lock(mutex_);
    move(client, from, to);
  }
  /// With the lock. One that is no longer small moves as a whole.
  void move(Client* client, std::uint64_t from, std::uint64_t to) {
    Pool& after = is_small(to) && has_small_pool() ? small_ : large_;
    Pool& before = is_small(from) && has_small_pool() ? small_ : large_;
    after.used += to;
    before.used -= from;
    if (!client) return;
    small_clients_ -= client->small > 0;
    large_clients_ -= client->large > 0;
    (is_small(to) ? client->small : client->large) += to;
    (is_small(from) ? client->small : client->large) -= from;
    small_clients_ += client->small > 0;
    large_clients_ += client->large > 0;
  }

  mutable std::mutex mutex_;
  Pool large_, small_;
  std::size_t small_clients_ = 0, large_clients_ = 0;
  const std::uint64_t largest_small_, headroom_ = 0;
  const Shares shares_;
};

}  // namespace fracture
