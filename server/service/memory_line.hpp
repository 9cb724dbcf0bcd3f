// Work whose turn has come and for which there is no memory: it leaves its thread to others and goes on when somebody
// has given back enough. So queued work holds none of the memory that computing takes.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <list>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "server/service/client_shares.hpp"

namespace fracture {

/// Thread-safe. For work that nothing waits for which holds memory itself. So, while somebody waits, something runs that
/// holds memory, and calls given_back() when it has given that back: nobody waits for ever.
class MemoryLine {
 public:
  explicit MemoryLine(ClientShares& memory) : memory_(memory) {}

  struct Waits {
    std::string client;
    std::uint64_t bytes = 0;
    MemoryBudget::Use use = MemoryBudget::Use::kWaitedFor;
    std::function<bool()> given_up;                        ///< nobody wants it any more
    std::function<void(MemoryBudget::Reservation)> go_on;  ///< called once, or dropped if it was given up
  };
  /// The memory, or nothing: then `waits` is in the line.
  std::optional<MemoryBudget::Reservation> take(Waits waits) {
    waits.bytes = std::min(waits.bytes, memory_.whole().capacity());
    // Nobody else takes any between the attempt and the place in the line.
    const std::lock_guard lock(mutex_);
    MemoryBudget::Reservation reservation = memory_.begin(waits.client, waits.use);
    if (reservation.grow_to(waits.bytes)) return reservation;
    line_.push_back({std::move(waits), std::move(reservation)});
    return std::nullopt;
  }

  /// Memory was given back, or somebody who waits was given up. Whoever has waited longest is tried first; one that needs
  /// more than there is holds up none of the others. Needs no memory itself.
  void given_back() noexcept {
    std::list<Entry> over, go_on;  // let go, and called, without the lock
    {
      const std::lock_guard lock(mutex_);
      for (auto at = line_.begin(); at != line_.end();) {
        const auto next = std::next(at);
        if (at->waits.given_up())
          over.splice(over.end(), line_, at);
        else if (at->reservation.grow_to(at->waits.bytes))
          go_on.splice(go_on.end(), line_, at);
        at = next;
      }
    }
    for (Entry& entry : go_on) try {
        entry.waits.go_on(std::move(entry.reservation));
      } catch (...) {  // no memory even to say that there is none: the others go on
      }
  }

  std::size_t size() const {
    const std::lock_guard lock(mutex_);
    return line_.size();
  }

 private:
  struct Entry {
    Waits waits;
    MemoryBudget::Reservation reservation;  ///< of nothing yet
  };

  ClientShares& memory_;
  mutable std::mutex mutex_;
  std::list<Entry> line_;  // the longest waiting first
};

}  // namespace fracture
