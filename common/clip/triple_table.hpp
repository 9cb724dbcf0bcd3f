// A map from three ids to one: open addressing; it keeps its memory and is cleared in O(1). For data shared
// by the polygons of one triangle, if it is too large for a linear search.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/random.hpp"

namespace fracture {

class TripleTable {
 public:
  static constexpr std::uint32_t kNone = 0xffffffffu;

  /// Clears the table.
  void clear() {
    used_ = 0;
    if (++epoch_ != 0) return;
    for (Entry& e : entries_) e.epoch = 0;
    epoch_ = 1;
  }
  /// The value stored for the triple, or kNone.
  std::uint32_t find(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
    if (used_ == 0) return kNone;
    const Entry& e = entries_[place(a, b, c)];
    return e.epoch == epoch_ ? e.value : kNone;
  }
  /// Stores `value` for a triple that has no value yet.
  void insert(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t value) {
    if (entries_.size() < 2 * (used_ + 1)) grow();
    entries_[place(a, b, c)] = {a, b, c, value, epoch_};
    ++used_;
  }

 private:
  struct Entry {
    std::uint32_t a, b, c, value, epoch;
  };
  std::size_t place(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
    std::uint64_t h = (static_cast<std::uint64_t>(a) << 32 | b) * kGoldenGamma;
    h = (h ^ h >> 32 ^ c) * 0xd6e8feb86659fd93ull;
    h ^= h >> 29;
    const std::size_t mask = entries_.size() - 1;
    for (std::size_t k = h & mask;; k = (k + 1) & mask) {
      const Entry& e = entries_[k];
      if (e.epoch != epoch_ || (e.a == a && e.b == b && e.c == c)) return k;
    }
  }
  void grow() {
    std::vector<Entry> old(entries_.empty() ? 64 : 2 * entries_.size());
    old.swap(entries_);
    for (const Entry& e : old)
      if (e.epoch == epoch_) entries_[place(e.a, e.b, e.c)] = e;
  }

  std::vector<Entry> entries_;
  std::size_t used_ = 0;
  std::uint32_t epoch_ = 1;
};

}  // namespace fracture
