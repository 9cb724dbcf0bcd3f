// How much of a shared capacity one client may hold. The limit depends on how much is free, like the dynamic thresholds of
// Choudhury and Hahne (1998, "Dynamic queue length thresholds for shared-memory packet switches"). It also depends on how
// many clients hold something, because clients may keep what they hold for a long time.
//
// With the factor a = share / (capacity - share), a client next to m others may hold free / (1/a + m). If it is alone, this
// is its share. After n clients, one after the other, have taken all that they may, capacity / (1 + n a) is left for the
// next client. To leave a newcomer a usable amount, a client's first reservation counts at most kMostOthers others.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace fracture {

struct FairShare {
  std::uint64_t capacity;
  std::uint64_t share;  ///< limit of a lone client; if it is the capacity, clients have no shares

  static constexpr std::size_t kMostOthers = 30;

  /// Returns whether a client may hold `own`. `used`: the amount that all clients hold, with `own` included. `others`: how
  /// many other clients hold something. `alone`: `own` is a single reservation, the only one of this client. A single
  /// reservation may exceed the client's limit if the others hold at most capacity - share.
  bool allows(std::uint64_t own, std::uint64_t used, std::size_t others, bool alone) const {
    if (used > capacity) return false;
    if (share >= capacity) return true;
    const auto whole = static_cast<double>(share), rest = static_cast<double>(capacity - share),
               held = static_cast<double>(own), free = static_cast<double>(capacity - used),
               counted = static_cast<double>(alone ? std::min(others, kMostOthers) : others);
    if (held * (rest + whole * counted) <= whole * free) return true;
    return alone && used - own <= capacity - share;
  }

  /// Returns how much a client that holds nothing may take, without the exception for a single reservation. `used`: the
  /// amount that all clients hold. `others`: how many clients hold something.
  std::uint64_t first(std::uint64_t used, std::size_t others) const {
    const std::uint64_t free = capacity - std::min(used, capacity);
    if (share >= capacity) return free;
    const auto whole = static_cast<double>(share), rest = static_cast<double>(capacity - share),
               counted = static_cast<double>(std::min(others, kMostOthers));
    return static_cast<std::uint64_t>(whole * static_cast<double>(free) / (rest + whole * (counted + 1)));
  }
};

}  // namespace fracture
