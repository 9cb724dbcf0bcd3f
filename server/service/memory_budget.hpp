// A budget of bytes that requests may hold at the same time. Without it, a few clients could make the process allocate the
// body limit times the connection limit.
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

  /// One pool with headroom that only small reservations may use.
  struct Divided {
    std::uint64_t capacity;
    std::uint64_t headroom;
    std::uint64_t largest_small;  ///< bytes of a reservation that is still small
    /// Whether clients give up what they hold beyond their even part if others need it. If so, a client may always hold its
    /// even part.
    bool even_parts = false;
  };

  /// The bytes that a client may hold if it is the only one (FairShare). Large and small reservations count separately.
  struct Shares {
    std::uint64_t large, small;
  };
  static constexpr Shares kNoShares{UINT64_MAX, UINT64_MAX};
  /// Background work holds its large reservations for a long time. A reservation that a client waits for is judged as if the
  /// background work of other clients held at most half of the pool. Background work beyond that is ended to free the memory.
  enum class Use { kWaitedFor, kBackground };
  /// The bytes that one client holds. Guarded by the budget.
  struct Client {
    std::uint64_t large = 0, small = 0;
    std::uint64_t background = 0;  ///< part of `large`
  };

  enum class Verdict {
    kFits,
    kFull,
    kOverShare,         ///< other reservations of the same client use up its share
    kHeldInBackground,  ///< it would fit if other clients' background work held no more than half of the pool
    kHeldOverPart,      ///< it would fit if other clients held no more than their even parts
  };
  /// How much a large reservation may take.
  enum class Limit {
    kUsual,      ///< what FairShare allows, or the client's even part (Divided::even_parts)
    kFairShare,  ///< what FairShare allows: for memory that cannot be given up
    kEvenPart,  ///< at most the client's even part with one more client, because another client waits for its own
    kOwnPart,  ///< at most the client's even part
    kOnlyOne,  ///< as usual, but only if the client has no other large reservation
    /// As usual, and a client's only large reservation may take all that is free: for memory that can be given up. Background work
    /// stays within FairShare, because it can last for minutes.
    kAllFree,
  };

  explicit MemoryBudget(std::uint64_t capacity) : MemoryBudget(capacity, {0, 0}) {}
  explicit MemoryBudget(const Divided& divided) : MemoryBudget(divided, kNoShares) {}
  MemoryBudget(const Divided& divided, const Shares& shares)
      : large_{divided.capacity},
        small_{0},
        largest_small_(divided.largest_small),
        headroom_(divided.headroom),
        even_parts_(divided.even_parts),
        shares_(shares) {}
  MemoryBudget(std::uint64_t capacity, SmallPool small) : MemoryBudget(capacity, small, kNoShares) {}
  MemoryBudget(std::uint64_t capacity, SmallPool small, const Shares& shares)
      : large_{capacity}, small_{small.capacity}, largest_small_(small.largest), shares_(shares) {}

  /// A part of the budget, given back by its destructor.
  class Reservation {
   public:
    Reservation() = default;
    explicit Reservation(MemoryBudget& budget, Use use = Use::kWaitedFor) : budget_(&budget), use_(use) {}
    /// Also counts towards the client. `budget` must outlive the reservation.
    Reservation(MemoryBudget& budget, std::shared_ptr<Client> client, Use use = Use::kWaitedFor)
        : budget_(&budget), client_(std::move(client)), use_(use) {}
    Reservation(Reservation&& other) noexcept
        : budget_(std::exchange(other.budget_, nullptr)),
          client_(std::move(other.client_)),
          use_(other.use_),
          usual_(other.usual_),
          bytes_(std::exchange(other.bytes_, 0)),
          verdict_(other.verdict_) {}
    Reservation& operator=(Reservation&& other) noexcept {
      std::swap(budget_, other.budget_);
      std::swap(client_, other.client_);
      std::swap(use_, other.use_);
      std::swap(usual_, other.usual_);
      std::swap(bytes_, other.bytes_);
      std::swap(verdict_, other.verdict_);
      return *this;
    }
    ~Reservation() {
      if (budget_) budget_->change(client_.get(), use_, bytes_, 0);
    }

    std::uint64_t bytes() const { return bytes_; }
    Use use() const { return use_; }
    /// Grows the reservation to at least `bytes`. Returns false and changes nothing if the budget does not have that much left
    /// for this client.
    bool grow_to(std::uint64_t bytes) { return grow_to(bytes, usual_); }
    bool grow_to(std::uint64_t bytes, Limit limit) {
      if (bytes <= bytes_) return true;
      verdict_ = budget_->grow(client_.get(), use_, bytes_, bytes, limit);
      if (verdict_ != Verdict::kFits) return false;
      bytes_ = bytes;
      return true;
    }
    /// From now on, kAllFree is the limit if grow_to() gets none.
    void may_take_all_free() { usual_ = Limit::kAllFree; }
    /// Shrinks the reservation to at most `bytes`. If there is a pool for small reservations, a large one stays just above
    /// their limit. It never moves back, because the small pool may have no room for it.
    void shrink_to(std::uint64_t bytes) {
      if (budget_) bytes = budget_->shrunk(bytes_, bytes);
      if (!budget_ || bytes >= bytes_) return;
      budget_->change(client_.get(), use_, bytes_, bytes);
      bytes_ = bytes;
    }
    /// Returns the result of the last grow_to() that asked for more.
    Verdict verdict() const { return verdict_; }
    bool over_share() const { return verdict_ == Verdict::kOverShare; }

   private:
    MemoryBudget* budget_ = nullptr;
    std::shared_ptr<Client> client_;
    Use use_ = Use::kWaitedFor;
    Limit usual_ = Limit::kUsual;
    std::uint64_t bytes_ = 0;
    Verdict verdict_ = Verdict::kFits;
  };

  std::uint64_t used() const {
    const std::lock_guard lock(mutex_);
    return large_.used + small_.used;
  }
  std::uint64_t small_used() const {
    const std::lock_guard lock(mutex_);
    return small_.used;
  }
  /// The largest size of a single reservation, in bytes.
  std::uint64_t capacity() const { return large_.capacity - headroom_; }
  /// The largest size of a reservation that is still small, in bytes.
  std::uint64_t largest_small() const { return largest_small_; }

  /// Returns the verdict that a new reservation of this size would get. `client` is null if no share applies.
  Verdict judge(const Client* client, std::uint64_t bytes, Use use = Use::kWaitedFor,
                Limit limit = Limit::kUsual) const {
    const std::lock_guard lock(mutex_);
    const std::uint64_t own = client ? held(*client, bytes) : 0;
    const bool is_known = client && counts(*client, bytes, use);
    return judge({client, use, bytes, own + bytes, pool(bytes).used + bytes,
                  clients(bytes, use) - (is_known ? 1 : 0), sharing(client), limit});
  }
  /// Returns the bytes that a client holds in large reservations.
  std::uint64_t held_by(const Client& client) const {
    const std::lock_guard lock(mutex_);
    return client.large;
  }
  /// Returns the part of this client if all clients with large reservations, and this one, divide the memory evenly. A client
  /// that is alone has no part of its own (FairShare limits it); then returns half.
  std::uint64_t even_part(const Client& client) const {
    const std::lock_guard lock(mutex_);
    return capacity() / std::max<std::size_t>(sharing(&client), 2);
  }
  bool is_small(std::uint64_t bytes) const { return bytes <= largest_small_; }
  /// Returns how many bytes are missing if a large reservation grows by `more` bytes. Ignores shares.
  std::uint64_t missing(std::uint64_t more) const {
    const std::lock_guard lock(mutex_);
    return large_.used + more - std::min(large_.used + more, capacity());
  }

 private:
  struct Pool {
    const std::uint64_t capacity;
    std::uint64_t used = 0;
  };

  /// Returns the bytes that a client holds in its small or its large reservations, whichever kind `bytes` belongs to.
  std::uint64_t held(const Client& client, std::uint64_t bytes) const {
    return is_small(bytes) ? client.small : client.large;
  }
  /// Returns whether the client is among those that share the pool with a reservation of this size and use.
  bool counts(const Client& client, std::uint64_t bytes, Use use) const {
    if (is_small(bytes)) return client.small > 0;
    return use == Use::kBackground ? client.large > 0 : client.large > client.background;
  }
  std::size_t clients(std::uint64_t bytes, Use use) const {
    if (is_small(bytes)) return small_clients_;
    return use == Use::kBackground ? large_clients_ : waited_for_clients_;
  }
  /// Returns how many clients share the memory for large reservations, with this one.
  std::size_t sharing(const Client* client) const {
    return large_clients_ + (client && client->large > 0 ? 0 : 1);
  }
  bool has_small_pool() const { return small_.capacity > 0; }
  const Pool& pool(std::uint64_t bytes) const {
    return is_small(bytes) && has_small_pool() ? small_ : large_;
  }
  std::uint64_t shrunk(std::uint64_t from, std::uint64_t to) const {
    return has_small_pool() && !is_small(from) ? std::max(to, largest_small_ + 1) : to;
  }
  /// A reservation to judge. `own` and `used` are what the client and all clients would hold together with it.
  struct Asked {
    const Client* client;  ///< null: it has no share
    Use use;
    std::uint64_t bytes, own, used;
    std::size_t others;   ///< number of other clients that share the pool
    std::size_t sharing;  ///< number of clients that divide the pool evenly
    Limit limit;
  };
  /// Returns whether the client would hold at most its even part of the pool, divided among this many.
  bool is_within_part(const Asked& asked, std::size_t parts) const { return asked.own <= capacity() / parts; }
  Verdict judge(const Asked& asked) const {
    const bool small = is_small(asked.bytes);
    FairShare fair{pool(asked.bytes).capacity - (small ? 0 : headroom_),
                   small ? shares_.small : shares_.large};
    std::uint64_t used = asked.used;
    const bool is_there = used <= fair.capacity;
    if (!small && asked.client) {
      const bool too_much =
          (asked.limit == Limit::kEvenPart && !is_within_part(asked, asked.sharing + 1)) ||
          (asked.limit == Limit::kOwnPart && !is_within_part(asked, std::max<std::size_t>(asked.sharing, 2)));
      if (too_much || (asked.limit == Limit::kOnlyOne && asked.own > asked.bytes)) return Verdict::kFull;
    }
    if (!small && asked.use == Use::kWaitedFor) {
      const std::uint64_t theirs = background_ - (asked.client ? asked.client->background : 0);
      const double left = 1 - static_cast<double>(std::min(theirs, fair.capacity / 2)) /
                                  static_cast<double>(std::max<std::uint64_t>(fair.capacity, 1));
      if (theirs > 0 && fair.share < fair.capacity)
        fair.share = static_cast<std::uint64_t>(left * static_cast<double>(fair.share));
      fair.capacity -= std::min(theirs, fair.capacity / 2);
      used -= theirs;
    }
    const bool alone = asked.own == asked.bytes;
    if (asked.client ? fair.allows(asked.own, used, asked.others, alone) : used <= fair.capacity)
      return is_there ? Verdict::kFits : Verdict::kHeldInBackground;
    if (!asked.client) return Verdict::kFull;
    if (even_parts_ && asked.use == Use::kWaitedFor && asked.limit == Limit::kAllFree && alone && is_there)
      return Verdict::kFits;
    if (even_parts_ && !small && asked.use == Use::kWaitedFor && asked.limit != Limit::kFairShare &&
        asked.sharing > 1 && is_within_part(asked, asked.sharing))
      return is_there ? Verdict::kFits : Verdict::kHeldOverPart;
    return !alone && (used <= fair.capacity || asked.own > fair.share) ? Verdict::kOverShare : Verdict::kFull;
  }
  Verdict grow(Client* client, Use use, std::uint64_t from, std::uint64_t to, Limit limit) {
    const std::lock_guard lock(mutex_);
    move(client, use, from, to);
    const Verdict verdict = judge({client, use, to, client ? held(*client, to) : to, pool(to).used,
                                   client ? clients(to, use) - 1 : 0, sharing(client), limit});
    if (verdict != Verdict::kFits) move(client, use, to, from);
    return verdict;
  }
  void change(Client* client, Use use, std::uint64_t from, std::uint64_t to) {
    const std::lock_guard lock(mutex_);
    move(client, use, from, to);
  }
  /// Changes the size of a reservation. If it becomes large, all of it moves to the large pool. Requires the lock.
  void move(Client* client, Use use, std::uint64_t from, std::uint64_t to) {
    Pool& after = is_small(to) && has_small_pool() ? small_ : large_;
    Pool& before = is_small(from) && has_small_pool() ? small_ : large_;
    after.used += to;
    before.used -= from;
    const auto in_background = [&](std::uint64_t bytes) {
      return use == Use::kBackground && !is_small(bytes) ? bytes : 0;
    };
    background_ += in_background(to);
    background_ -= in_background(from);
    if (!client) return;
    count(*client, -1);
    (is_small(to) ? client->small : client->large) += to;
    (is_small(from) ? client->small : client->large) -= from;
    client->background += in_background(to);
    client->background -= in_background(from);
    count(*client, 1);
  }
  void count(const Client& client, int more) {
    const auto add = [more](std::size_t& clients, bool counts) {
      if (counts) clients += static_cast<std::size_t>(more);
    };
    add(small_clients_, client.small > 0);
    add(large_clients_, client.large > 0);
    add(waited_for_clients_, client.large > client.background);
  }

  mutable std::mutex mutex_;
  Pool large_, small_;
  std::uint64_t background_ = 0;  ///< bytes of large reservations for background work
  std::size_t small_clients_ = 0, large_clients_ = 0;
  std::size_t waited_for_clients_ = 0;  ///< clients with large reservations that are not background work
  const std::uint64_t largest_small_, headroom_ = 0;
  const bool even_parts_ = false;
  const Shares shares_;
};

}  // namespace fracture
