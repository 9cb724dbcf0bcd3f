// The line of work that waits for memory. If there is not enough memory when a piece of work gets its turn, the work leaves
// its thread to others, and continues when enough memory has been given back. So queued work holds no working memory.
//
// Background work gives up memory for work that a client waits for. No further background work begins until that work has
// its memory.
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

/// Thread-safe. Work must not wait here if other work that holds memory waits for it. This guarantees progress: while the
/// line is not empty, something that holds memory is running, and it calls given_back() when it releases that memory.
class MemoryLine {
 public:
  /// Makes the background work of other clients give up memory, so that this client's work can have `bytes`.
  using MakeRoom = std::function<void(const std::string& client, std::uint64_t bytes)>;
  /// After each change, `make_room` is called for each entry that lacks memory held by background work. No locks are held
  /// during these calls.
  MemoryLine(ClientShares& memory, MakeRoom make_room) : memory_(memory), make_room_(std::move(make_room)) {}

  struct Waits {
    std::string client;
    std::uint64_t bytes = 0;
    std::function<MemoryBudget::Use()> use;  ///< asked again: a client may have begun to wait for it
    std::function<bool()> given_up;          ///< true if no client wants the work any more
    std::function<void(MemoryBudget::Reservation)> go_on;  ///< called once, or dropped if given up
  };
  /// Returns the memory. Returns nothing if there is not enough: then `waits` joins the line.
  std::optional<MemoryBudget::Reservation> take(Waits waits) {
    waits.bytes = std::min(waits.bytes, memory_.whole().capacity());
    const Use use = waits.use();
    {
      // The lock covers both steps, so that no memory is given back unnoticed between the attempt and joining the line.
      const std::lock_guard lock(mutex_);
      MemoryBudget::Reservation reservation = memory_.begin(waits.client, use);
      if (may_take(use) && reservation.grow_to(waits.bytes)) return reservation;
      line_.push_back({std::move(waits), std::move(reservation)});
    }
    make_room();
    return std::nullopt;
  }

  /// Held by a running computation that needs memory which background work is giving up. While it lives, no background work
  /// gets memory.
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

  /// Call it after memory was given back or waiting work was abandoned. Work that a client waits for is tried before
  /// background work, and the longest waiting first. Work that needs more than is free does not block the rest. Letting work
  /// continue allocates nothing here, so it succeeds even if memory is exhausted.
  void given_back() noexcept {
    std::list<Entry> over, go_on;  // destroyed and called without the lock
    {
      const std::lock_guard lock(mutex_);
      for (const Use use : {Use::kWaitedFor, Use::kBackground}) {
        const bool may = may_take(use);  // all other work was tried before background work
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
      } catch (...) {  // no memory even to report the lack of memory; the other entries go on
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
    MemoryBudget::Reservation reservation;  ///< still empty
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
  /// Returns whether work of this kind may take memory. Background work must not while other work waits for memory that
  /// background work holds beyond its half. Requires the lock.
  bool may_take(Use use) const {
    if (use != Use::kBackground) return true;
    return claims_ == 0 && std::none_of(line_.begin(), line_.end(), [](const Entry& entry) {
             return entry.reservation.verdict() == MemoryBudget::Verdict::kHeldInBackground;
           });
  }

  ClientShares& memory_;
  const MakeRoom make_room_;
  mutable std::mutex mutex_;
  std::list<Entry> line_;  // longest waiting first
  std::size_t claims_ = 0;
};

}  // namespace fracture
