// Bytes that requests may hold at the same time: without it, the limit of one body times the limit of
// connections is what a few clients can make the process allocate.
#pragma once

#include <atomic>
#include <cstdint>
#include <utility>

namespace fracture {

/// Thread-safe. The sum of all reservations is at most the capacity.
class MemoryBudget {
 public:
  explicit MemoryBudget(std::uint64_t capacity) : capacity_(capacity) {}

  /// A share of the budget, given back by its destructor.
  class Reservation {
   public:
    Reservation() = default;
    explicit Reservation(MemoryBudget& budget) : budget_(&budget) {}
    Reservation(Reservation&& other) noexcept
        : budget_(std::exchange(other.budget_, nullptr)), bytes_(std::exchange(other.bytes_, 0)) {}
    Reservation& operator=(Reservation&& other) noexcept {
      std::swap(budget_, other.budget_);
      std::swap(bytes_, other.bytes_);
      return *this;
    }
    ~Reservation() {
      if (budget_) budget_->used_.fetch_sub(bytes_);
    }

    std::uint64_t bytes() const { return bytes_; }
    /// Makes it at least `bytes`; false, and nothing changes, when the budget has not that much left.
    bool grow_to(std::uint64_t bytes) {
      if (bytes <= bytes_) return true;
      const std::uint64_t more = bytes - bytes_;
      std::uint64_t used = budget_->used_.load();
      do {
        if (more > budget_->capacity_ - used) return false;
      } while (!budget_->used_.compare_exchange_weak(used, used + more));
      bytes_ = bytes;
      return true;
    }

   private:
    MemoryBudget* budget_ = nullptr;
    std::uint64_t bytes_ = 0;
  };

  std::uint64_t used() const { return used_; }
  std::uint64_t capacity() const { return capacity_; }

 private:
  const std::uint64_t capacity_;
  std::atomic<std::uint64_t> used_{0};
};

}  // namespace fracture
