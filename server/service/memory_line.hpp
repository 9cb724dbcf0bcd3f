// Work whose turn has come and for which there is no memory: it leaves its thread to others and goes on when somebody
// has given back enough. So queued work holds none of the memory that computing takes.
//
// Background work gives up memory for work that a client waits for. Until that work has it, no further background work begins.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <list>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/service/client_shares.hpp"

namespace fracture {

/// Thread-safe. For work that nothing waits for which holds memory itself. So, while somebody waits, something runs that
/// holds memory, and calls given_back() when it has given that back: nobody waits for ever.
class MemoryLine {
 public:
  /// Has background work of other clients give up memory, so that a client's work may have so many bytes.
  using MakeRoom = std::function<void(const std::string& client, std::uint64_t bytes)>;
  /// `make_room` is called without locks, again after each change, for each entry that lacks what background work holds.
  MemoryLine(ClientShares& memory, MakeRoom make_room) : memory_(memory), make_room_(std::move(make_room)) {}

  struct Waits {
    std::string client;
    std::uint64_t bytes = 0;
    std::function<MemoryBudget::Use()> use;  ///< asked again: a client may have begun to wait for it
    std::function<bool()> given_up;          ///< true if no client wants the work any more
    std::function<void(MemoryBudget::Reservation)> go_on;  ///< called once, or dropped if it was given up
  };
  /// The memory, or nothing: then `waits` is in the line.
  std::optional<MemoryBudget::Reservation> take(Waits waits) {
    waits.bytes = std::min(waits.bytes, memory_.whole().capacity());
    const Use use = waits.use();
    {
      // Nobody else takes any between the attempt and the place in the line.
      const std::lock_guard lock(mutex_);
      MemoryBudget::Reservation reservation = memory_.begin(waits.client, use);
      if (may_take(use) && reservation.grow_to(waits.bytes)) return reservation;
      line_.push_back({std::move(waits), std::move(reservation)});
    }
    make_room();
    return std::nullopt;
  }

  /// Somebody who computes needs memory that background work is giving up. No background work takes any while this lives.
  class Claim {
   public:
    explicit Claim(MemoryLine& line) : line_(line) {
      const std::lock_guard lock(line_.mutex_);
      ++line_.claims_;
    }
    ~Claim() {
      {
        const std::lock_guard lock(line_.mutex_);
        --line_.claims_;
      }
      line_.given_back();
    }
    Claim(const Claim&) = delete;
    Claim& operator=(const Claim&) = delete;

   private:
    MemoryLine& line_;
  };

  /// Call it when memory was given back, or when waiting work was abandoned. Background work comes last. Among the others the
  /// longest waiting is tried first. Work that needs more than is free does not block the rest. Needs no memory itself.
  void given_back() noexcept {
    std::list<Entry> over, go_on;  // let go, and called, without the lock
    {
      const std::lock_guard lock(mutex_);
      for (const Use use : {Use::kWaitedFor, Use::kBackground}) {
        const bool may = may_take(use);  // those who wait for clients were tried again by then
        for (auto at = line_.begin(); at != line_.end();) {
          const auto next = std::next(at);
          if (at->waits.given_up()) {
            over.splice(over.end(), line_, at);
            at = next;
            continue;
          }
          if (const Use now = at->waits.use(); now != at->reservation.use())
            at->reservation = memory_.begin(at->waits.client, now);
          if (may && at->reservation.use() == use && at->reservation.grow_to(at->waits.bytes))
            go_on.splice(go_on.end(), line_, at);
          at = next;
        }
      }
    }
    for (Entry& entry : go_on) try {
        entry.waits.go_on(std::move(entry.reservation));
      } catch (...) {  // no memory even to say that there is none: the others go on
      }
    make_room();
  }

  std::size_t size() const {
    const std::lock_guard lock(mutex_);
    return line_.size();
  }

 private:
  using Use = MemoryBudget::Use;
  struct Entry {
    Waits waits;
    MemoryBudget::Reservation reservation;  ///< of nothing yet
  };

  void make_room() noexcept try {
    std::vector<std::pair<std::string, std::uint64_t>> lacking;
    {
      const std::lock_guard lock(mutex_);
      for (const Entry& entry : line_)
        if (entry.reservation.verdict() == MemoryBudget::Verdict::kHeldInBackground)
          lacking.emplace_back(entry.waits.client, entry.waits.bytes);
    }
    for (const auto& [client, bytes] : lacking) make_room_(client, bytes);
  } catch (...) {  // no memory to ask for room: the next change asks again
  }
  /// With the lock. Background work does not, while others wait for what background work holds beyond its half.
  bool may_take(Use use) const {
    if (use != Use::kBackground) return true;
    return claims_ == 0 && std::none_of(line_.begin(), line_.end(), [](const Entry& entry) {
             return entry.reservation.verdict() == MemoryBudget::Verdict::kHeldInBackground;
           });
  }

  ClientShares& memory_;
  const MakeRoom make_room_;
  mutable std::mutex mutex_;
  std::list<Entry> line_;  // the longest waiting first
  std::size_t claims_ = 0;
};

}  // namespace fracture
