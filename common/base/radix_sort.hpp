// Least-significant-digit radix sort (Knuth, The Art of Computer Programming 3, 5.2.5) of 64-bit keys.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "common/base/pacer.hpp"

namespace fracture {

/// An element to sort; `index` identifies its owner.
struct Keyed {
  std::uint64_t key;
  std::uint32_t index;
};

/// Sorts stably by bits [low, high) of the key. Throws Interrupted.
inline void radix_sort(std::span<Keyed> items, int low, int high, Pacer& pacer) {
  std::vector<Keyed> copy(items.begin(), items.end());
  std::span<Keyed> from = items, to = copy;
  for (int shift = low; shift < high; shift += 11) {
    std::array<std::uint32_t, 2048> start{};
    for (const Keyed& k : from) ++start[k.key >> shift & 2047];
    std::uint32_t sum = 0;
    for (std::uint32_t& s : start) sum += std::exchange(s, sum);
    for (const Keyed& k : from) {
      to[start[k.key >> shift & 2047]++] = k;
      pacer.step();
    }
    std::swap(from, to);
  }
  if (from.data() != items.data()) std::copy(from.begin(), from.end(), items.begin());
}

}  // namespace fracture
