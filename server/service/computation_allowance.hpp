// What one computation may hold of the memory that all share: begins with what it was admitted for and grows
// while there is room.
#pragma once

#include <mutex>

#include "common/base/product.hpp"
#include "server/service/memory_budget.hpp"

namespace fracture {

class ComputationAllowance {
 public:
  ComputationAllowance(MemoryBudget& budget, MemoryBudget::Reservation reservation)
      : budget_(budget),
        reservation_(std::move(reservation)),
        allowance_(
            reservation_.bytes(), budget.capacity(), [this](std::uint64_t bytes) { return grow(bytes); },
            [this](std::uint64_t bytes) { shrink(bytes); }) {}
  Allowance& allowance() { return allowance_; }

 private:
  Allowance::Answer grow(std::uint64_t bytes) {
    if (bytes > budget_.capacity()) return Allowance::Answer::kNever;
    const std::lock_guard lock(mutex_);
    if (reservation_.grow_to(bytes)) return Allowance::Answer::kGranted;
    return reservation_.over_share() ? Allowance::Answer::kOverShare : Allowance::Answer::kNotNow;
  }
  void shrink(std::uint64_t bytes) {
    const std::lock_guard lock(mutex_);
    reservation_.shrink_to(bytes);
  }

  MemoryBudget& budget_;
  std::mutex mutex_;  // of the reservation: several threads compute
  MemoryBudget::Reservation reservation_;
  Allowance allowance_;
};

}  // namespace fracture
