// Bytes that requests may hold at the same time: without it, the limit of one body times the limit of
// connections is what a few clients can make the process allocate.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <memory>
#include <utility>

namespace fracture {

/// Thread-safe. The sum of all reservations is at most the capacity. Small reservations may have a pool of
/// their own, so that they never wait for large ones.
class MemoryBudget {
 public:
  struct SmallPool {
    std::uint64_t capacity;
    std::uint64_t largest;  ///< bytes of a reservation that is still small
  };
  enum class Alone {
    kWithin,     ///< a reservation over the capacity is refused
    kMayExceed,  ///< it counts as the capacity: a share is to divide, not to forbid
  };

  /// One pool, of which only small reservations may take all: large ones leave them their headroom.
  struct Divided {
    std::uint64_t capacity;
    std::uint64_t headroom;
    std::uint64_t largest_small;  ///< bytes of a reservation that is still small
  };

  explicit MemoryBudget(std::uint64_t capacity) : MemoryBudget(capacity, {0, 0}) {}
  explicit MemoryBudget(const Divided& divided, Alone alone = Alone::kWithin)
      : large_{divided.capacity},
        small_{0},
        largest_small_(0),
        headroom_(divided.headroom),
        largest_with_headroom_(divided.largest_small),
        alone_(alone) {}
  MemoryBudget(std::uint64_t capacity, SmallPool small, Alone alone = Alone::kWithin)
      : large_{capacity}, small_{small.capacity}, largest_small_(small.largest), alone_(alone) {}

  /// A share of the budget, given back by its destructor.
  class Reservation {
   public:
    Reservation() = default;
    explicit Reservation(MemoryBudget& budget) : budget_(&budget) {}
    /// Counted in both; `budget` outlives the reservation.
    Reservation(MemoryBudget& budget, std::shared_ptr<MemoryBudget> share)
        : budget_(&budget), share_(std::move(share)) {}
    Reservation(Reservation&& other) noexcept
        : budget_(std::exchange(other.budget_, nullptr)),
          share_(std::move(other.share_)),
          bytes_(std::exchange(other.bytes_, 0)),
          over_share_(other.over_share_) {}
    Reservation& operator=(Reservation&& other) noexcept {
      std::swap(budget_, other.budget_);
      std::swap(share_, other.share_);
      std::swap(bytes_, other.bytes_);
      std::swap(over_share_, other.over_share_);
      return *this;
    }
    ~Reservation() {
      if (budget_) budget_->give_back(bytes_);
      if (share_) share_->give_back(bytes_);
    }

    std::uint64_t bytes() const { return bytes_; }
    /// Makes it at least `bytes`; false, and nothing changes, when the budget has not that much left.
    bool grow_to(std::uint64_t bytes) {
      if (bytes <= bytes_) return true;
      over_share_ = share_ && !share_->change(bytes_, bytes);
      if (over_share_) return false;
      if (budget_->change(bytes_, bytes)) {
        bytes_ = bytes;
        return true;
      }
      if (share_) share_->undo(bytes_, bytes);
      return false;
    }
    /// Makes it at most `bytes`. One that is no longer small stays as large as the first that is not: what it
    /// leaves is not to be missing where it would go.
    void shrink_to(std::uint64_t bytes) {
      if (budget_) bytes = budget_->shrunk(bytes_, bytes);
      if (!budget_ || bytes >= bytes_) return;
      budget_->shrink(bytes_, bytes);
      if (share_) share_->shrink(bytes_, bytes);
      bytes_ = bytes;
    }
    /// The last grow_to() failed because of the share and not because of the whole.
    bool over_share() const { return over_share_; }

   private:
    MemoryBudget* budget_ = nullptr;
    std::shared_ptr<MemoryBudget> share_;
    std::uint64_t bytes_ = 0;
    bool over_share_ = false;
  };

  std::uint64_t used() const { return large_.used + small_.used; }
  /// What a single reservation may have.
  std::uint64_t capacity() const { return large_.capacity - headroom_; }
  std::uint64_t small_used() const { return small_.used; }

 private:
  struct Pool {
    const std::uint64_t capacity;
    std::atomic<std::uint64_t> used{0};

    /// Within `most` of it.
    bool take(std::uint64_t more, std::uint64_t most) {
      std::uint64_t before = used.load();
      do {
        if (before > most || more > most - before) return false;
      } while (!used.compare_exchange_weak(before, before + more));
      return true;
    }
  };

  Pool& pool(std::uint64_t bytes) { return bytes <= largest_small_ ? small_ : large_; }
  /// A reservation grows; one that is no longer small moves as a whole.
  bool change(std::uint64_t from, std::uint64_t to) {
    Pool &before = pool(from), &after = pool(to);
    if (&before == &after) {
      if (counted(to) > counted(from)) return after.take(counted(to) - counted(from), most(to));
      shrink(from, to);  // its last bytes were the headroom's
      return true;
    }
    if (!after.take(counted(to), most(to))) return false;
    before.used.fetch_sub(counted(from));
    return true;
  }
  /// What reservations of this size may hold together.
  std::uint64_t most(std::uint64_t bytes) {
    return pool(bytes).capacity - (bytes > largest_with_headroom_ ? headroom_ : 0);
  }
  std::uint64_t counted(std::uint64_t bytes) {
    return alone_ == Alone::kMayExceed ? std::min(bytes, most(bytes)) : bytes;
  }
  /// Both sizes are of one pool.
  void shrink(std::uint64_t from, std::uint64_t to) { pool(to).used.fetch_sub(counted(from) - counted(to)); }

  std::uint64_t shrunk(std::uint64_t from, std::uint64_t to) const {
    return from > largest_small_ ? std::max(to, largest_small_ + 1) : to;
  }
  void undo(std::uint64_t from, std::uint64_t to) {
    pool(to).used.fetch_sub(counted(to));
    pool(from).used.fetch_add(counted(from));
  }
  void give_back(std::uint64_t bytes) { pool(bytes).used.fetch_sub(counted(bytes)); }

  Pool large_, small_;
  const std::uint64_t largest_small_, headroom_ = 0, largest_with_headroom_ = 0;
  const Alone alone_;
};

}  // namespace fracture
