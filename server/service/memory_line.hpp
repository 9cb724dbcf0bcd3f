// The line of work that waits for memory. If there is not enough memory when a piece of work gets its turn, the work leaves
// its thread to others, and continues when enough memory has been given back. So queued work holds no working memory.
//
// Other clients' work gives up memory for work that a client waits for (memory_holders.hpp). Until that work has its memory,
// no further background work begins, no client takes more than its even part, and work that was given up begins again only
// within that part.
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
  /// Makes the work of other clients give up memory, so that this client's work can have `bytes`. Does nothing if none of it has
  /// to give up memory.
  using MakeRoom = std::function<void(const std::string& client, std::uint64_t bytes)>;
  /// After each change, `make_room` is called for each entry that lacks memory and is not background work. No locks are held
  /// during these calls.
  MemoryLine(ClientShares& memory, MakeRoom make_room) : memory_(memory), make_room_(std::move(make_room)) {}

  struct Waits {
    std::string client;
    std::uint64_t bytes = 0;
    std::function<MemoryBudget::Use()> use;  ///< asked again: a client may have begun to wait for it
    std::function<bool()> given_up;          ///< true if no client wants the work any more
    std::function<void(MemoryBudget::Reservation)> go_on;  ///< called once, or dropped if given up
    /// It was given up for other clients before. It takes memory within its client's even part, or when its client holds
    /// nothing else and no other client waits. So it is not given up again for the same reason.
    bool again = false;
    /// It was given up because it stood still. It takes no memory while another client waits.
    bool stood_still = false;
    /// It gives up its memory if other clients lack their parts. So if it is all that its client holds, it may take whatever is free.
    bool gives_up = false;
  };
  /// Returns the memory. Returns nothing if there is not enough: then `waits` joins the line.
  std::optional<MemoryBudget::Reservation> take(Waits waits) {
    waits.bytes = std::min(waits.bytes, memory_.whole().capacity());
    const Use use = waits.use();
    {
      // The lock covers both steps, so that no memory is given back unnoticed between the attempt and joining the line.
      const std::lock_guard lock(mutex_);
      MemoryBudget::Reservation reservation = memory_.begin(waits.client, use);
      if (take(waits, use, first(), reservation)) return reservation;
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
      for (auto at = line_.begin(); at != line_.end();) {
        const auto next = std::next(at);
        if (at->waits.given_up())
          over.splice(over.end(), line_, at);
        else if (const Use now = at->waits.use(); now != at->reservation.use())
          at->reservation = memory_.begin(at->waits.client, now);
        at = next;
      }
      for (const Use use : {Use::kWaitedFor, Use::kBackground}) {
        const First goes_first = first();  // all other work was tried before background work
        for (auto at = line_.begin(); at != line_.end();) {
          const auto next = std::next(at);
          if (at->reservation.use() == use && take(at->waits, use, goes_first, at->reservation))
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
        if (entry.reservation.use() != Use::kBackground &&
            (!entry.waits.again || memory_.is_newcomer(entry.waits.client)))
          lacking.emplace_back(entry.waits.client, entry.waits.bytes);
    }
    for (const auto& [client, bytes] : lacking) make_room_(client, bytes);
  } catch (...) {  // no memory to ask for room: the next change asks again
  }
  /// A set of clients.
  struct Clients {
    void add(const std::string& client) {
      several = includes_other_than(client);
      one = &client;
    }
    bool includes_other_than(const std::string& client) const { return several || (one && *one != client); }
    const std::string* one = nullptr;
    bool several = false;
  };
  /// The work in the line that goes first.
  struct First {
    Clients waiting;             ///< for work that was not given up
    Clients lacking;             ///< memory that others hold beyond their parts
    bool in_background = false;  ///< some work lacks memory that background work holds
    bool again = false;          ///< some work was given up before
  };
  /// Requires the lock.
  First first() const {
    First all;
    all.in_background = claims_ > 0;
    for (const Entry& entry : line_) {
      const MemoryBudget::Verdict verdict = entry.reservation.verdict();
      if (verdict == MemoryBudget::Verdict::kHeldInBackground) all.in_background = true;
      all.again = all.again || entry.waits.again;
      if (entry.waits.again || entry.reservation.use() == Use::kBackground) continue;
      all.waiting.add(entry.waits.client);
      if (verdict == MemoryBudget::Verdict::kHeldOverPart) all.lacking.add(entry.waits.client);
    }
    return all;
  }
  /// Returns whether some of this client's work was given up and waits. Requires the lock.
  bool waits_again(const std::string& client) const {
    return std::any_of(line_.begin(), line_.end(),
                       [&](const Entry& entry) { return entry.waits.again && entry.waits.client == client; });
  }
  /// Takes the memory if it is there and no other work must have it first. Requires the lock.
  bool take(const Waits& waits, Use use, const First& first, MemoryBudget::Reservation& memory) const {
    using Limit = MemoryBudget::Limit;
    if (waits.gives_up) memory.may_take_all_free();
    if (use == Use::kBackground && (first.in_background || first.lacking.one)) return false;
    // Two clients that both lack their parts may each have all of it.
    const bool others_lack = memory.verdict() != MemoryBudget::Verdict::kHeldOverPart &&
                             first.lacking.includes_other_than(waits.client);
    const Limit within_part = others_lack ? Limit::kEvenPart : Limit::kOwnPart;
    if (waits.again) {
      const bool others_wait = first.waiting.includes_other_than(waits.client);
      return (!(others_wait && waits.stood_still) && memory.grow_to(waits.bytes, within_part)) ||
             (!others_wait && memory.grow_to(waits.bytes, Limit::kOnlyOne));
    }
    if (others_lack) return memory.grow_to(waits.bytes, within_part);
    // A client's new work must not keep its work that was given up from beginning again. If the client holds nothing, the
    // latter waits for other clients: if the new work waited for it, too, all work might wait.
    if (use != Use::kBackground && first.again && waits_again(waits.client))
      return memory.grow_to(waits.bytes, within_part) || memory.grow_to(waits.bytes, Limit::kOnlyOne);
    return memory.grow_to(waits.bytes);
  }

  ClientShares& memory_;
  const MakeRoom make_room_;
  mutable std::mutex mutex_;
  std::list<Entry> line_;  // longest waiting first
  std::size_t claims_ = 0;
};

}  // namespace fracture
