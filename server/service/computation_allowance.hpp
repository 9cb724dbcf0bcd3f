// The part of the shared memory that one computation may hold. It begins with the amount that the computation was admitted
// for, and grows while there is room.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <mutex>
#include <utility>

#include "common/base/product.hpp"
#include "server/service/memory_budget.hpp"

namespace fracture {

class ComputationAllowance {
 public:
  /// Called if a reservation could not grow to `bytes`. Makes room and grows the reservation. Returns false if that is
  /// impossible.
  using MakeRoom = std::function<bool(MemoryBudget::Reservation&, std::uint64_t bytes)>;
  /// `held`: a counter to set to the bytes that the computation holds, after each change. May be null. Must outlive this.
  ComputationAllowance(MemoryBudget& budget, MemoryBudget::Reservation reservation, MakeRoom make_room,
                       std::atomic<std::uint64_t>* held = nullptr)
      : budget_(budget),
        reservation_(std::move(reservation)),
        make_room_(std::move(make_room)),
        held_(held),
        allowance_(
            reservation_.bytes(), budget.capacity(), [this](std::uint64_t bytes) { return grow(bytes); },
            [this](std::uint64_t bytes) { shrink(bytes); }) {
    tell();
  }
  Allowance& allowance() { return allowance_; }

 private:
  Allowance::Answer grow(std::uint64_t bytes) {
    if (bytes > budget_.capacity()) return Allowance::Answer::kNever;
    const std::lock_guard lock(mutex_);
    // Other work gives up memory only for products that exist, not for what Allowance::grow asks for ahead of need.
    if (!reservation_.grow_to(bytes) && (bytes > allowance_.bytes() || !make_room_(reservation_, bytes)))
      return refused();
    tell();
    return Allowance::Answer::kGranted;
  }
  Allowance::Answer refused() const {
    return reservation_.over_share() ? Allowance::Answer::kOverShare : Allowance::Answer::kNotNow;
  }
  void shrink(std::uint64_t bytes) {
    const std::lock_guard lock(mutex_);
    reservation_.shrink_to(bytes);
    tell();
  }
  void tell() const {
    if (held_) *held_ = reservation_.bytes();
  }

  MemoryBudget& budget_;
  std::mutex mutex_;  // guards the reservation, because several threads compute
  MemoryBudget::Reservation reservation_;
  const MakeRoom make_room_;
  std::atomic<std::uint64_t>* const held_;
  Allowance allowance_;
};

}  // namespace fracture
