// A map from a few ids of a large id space to numbers. Its size depends on its contents, not on the id space.
// stamped_map.hpp is faster if the id space is small or the map is used often. Open addressing (Knuth, volume
// 3, 6.4).
#pragma once

#include <bit>
#include <cstdint>
#include <vector>

#include "common/base/id.hpp"
#include "common/base/random.hpp"

namespace fracture {

class IdTable {
 public:
  static constexpr std::uint32_t kEmpty = kNoIndex;

  std::size_t size() const { return count_; }
  /// The number of the id; kEmpty if it has none. kNoIndex is not a valid id.
  std::uint32_t find(std::uint32_t id) const {
    if (slots_.empty()) return kEmpty;
    const Slot& slot = slots_[place(id)];
    return slot.id == id ? slot.number : kEmpty;
  }
  /// A writable reference to the number of the id; kEmpty if the id is new. Valid until the next call.
  std::uint32_t& slot(std::uint32_t id) {
    if (2 * (count_ + 1) > slots_.size()) grow();
    Slot& slot = slots_[place(id)];
    if (slot.id != id) {
      slot = {id, kEmpty};
      ++count_;
    }
    return slot.number;
  }

 private:
  struct Slot {
    std::uint32_t id = kNoIndex, number = kEmpty;
  };
  std::size_t place(std::uint32_t id) const {
    std::size_t k = id * kGoldenGamma >> shift_;
    while (slots_[k].id != id && slots_[k].id != kNoIndex) k = (k + 1) & (slots_.size() - 1);
    return k;
  }
  void grow() {
    std::vector<Slot> before(slots_.empty() ? 64 : 2 * slots_.size());
    before.swap(slots_);
    shift_ = 64 - std::countr_zero(slots_.size());
    for (const Slot& slot : before)
      if (slot.id != kNoIndex) slots_[place(slot.id)] = slot;
  }

  std::vector<Slot> slots_;
  std::size_t count_ = 0;
  int shift_ = 64;
};

}  // namespace fracture
