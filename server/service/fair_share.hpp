// The part of a room that all share which one client may hold. It goes by what nobody holds, like the dynamic thresholds of
// Choudhury and Hahne (1998, "Dynamic queue length thresholds for shared-memory packet switches"), and by how many hold
// something, because nothing that is held here has to be given back soon.
//
// With the factor a = share / (capacity - share), a client besides m others may hold free / (1/a + m). Alone it comes to its
// share. When n clients, one after the other, have taken all that they may, capacity / (1 + n a) is left, for whoever comes
// next. So that a newcomer finds a use for it, the first thing of a client counts no more than kMostOthers others.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace fracture {

struct FairShare {
  std::uint64_t capacity;
  std::uint64_t share;  ///< of a client that is the only one; all of the capacity: clients have no shares

  static constexpr std::size_t kMostOthers = 30;

  /// May a client hold `own`, if all together hold `used`, this included, and so many `others` hold something? `alone`: it
  /// is one thing, and all that the client holds. Such a one may be larger than its part, while the others hold no more
  /// than the capacity without a share.
  bool allows(std::uint64_t own, std::uint64_t used, std::size_t others, bool alone) const {
    if (used > capacity) return false;
    if (share >= capacity) return true;
    const auto whole = static_cast<double>(share), rest = static_cast<double>(capacity - share),
               held = static_cast<double>(own), free = static_cast<double>(capacity - used),
               counted = static_cast<double>(alone ? std::min(others, kMostOthers) : others);
    if (held * (rest + whole * counted) <= whole * free) return true;
    return alone && used - own <= capacity - share;
  }
};

}  // namespace fracture
