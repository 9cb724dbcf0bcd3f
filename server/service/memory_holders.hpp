// Computations that hold working memory. If work of another client lacks memory, some of them are given up:
//
//  - If background work holds more than half of the memory (MemoryBudget::Use), background computations. The client that
//    holds the most loses its latest computation first.
//  - If clients hold more than their even part (MemoryBudget::even_part), computations of these clients, whatever their class.
//    The order is the same, but less urgent classes end first, then computations that were given up less often before.
//  - Always: computations that stand still because their client exceeds its processor rate.
#pragma once

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <mutex>
#include <string>
#include <utility>

namespace fracture {

/// Thread-safe.
class MemoryHolders {
 public:
  enum class Why : std::uint8_t { kBackground, kOverPart, kStandsStill };
  struct Holder {
    std::string client;
    std::function<std::uint64_t()> bytes;             ///< bytes that it holds now
    std::function<bool(Why)> may_give_up;             ///< whether it can be given up for this reason
    std::function<void(Why)> give_up;                 ///< asks the computation to end soon
    std::function<int()> urgency = [] { return 0; };  ///< the larger, the sooner it is given up
    int begun_again = 0;                              ///< how often it was given up before
    bool given_up = false;
    Why why = Why::kBackground;
    std::uint64_t number = 0;  ///< consecutive, in the order of add()
    std::chrono::steady_clock::time_point since = std::chrono::steady_clock::now();
  };
  using Id = std::list<Holder>::iterator;

  Id add(Holder holder) {
    const std::lock_guard lock(mutex_);
    holder.number = next_++;
    return holders_.insert(holders_.end(), std::move(holder));
  }
  /// Call it after the holder's memory was released. After that, the holder's functions are not called any more.
  void remove(Id holder) noexcept {
    {
      const std::lock_guard lock(mutex_);
      holders_.erase(holder);
    }
    removed_.notify_all();
  }

  /// Makes background work of other clients than this one give up `missing` bytes. Computations that are already ending
  /// count. Returns false if nothing can be given up.
  bool give_up_background(const std::string& client, std::uint64_t missing) {
    const std::lock_guard lock(mutex_);
    std::uint64_t given_up = ending(client);
    std::map<std::string, std::uint64_t> held;
    for (const Holder& holder : holders_)
      if (!holder.given_up && holder.client != client) held[holder.client] += holder.bytes();
    given_up += give_up_most(held, 0, missing - std::min(missing, given_up), Why::kBackground, {});
    return given_up > 0;
  }
  /// Returns how many bytes a client holds, in computations and otherwise.
  using HeldBy = std::function<std::uint64_t(const std::string& client)>;
  /// As above, but for computations of clients that hold more than `part`, until they hold no more than that. Spares
  /// computations that have held memory for less than `least_age`, because most of them end soon by themselves.
  bool give_up_over_part(const std::string& client, std::uint64_t missing, std::uint64_t part,
                         const HeldBy& held_by, std::chrono::milliseconds least_age = {}) {
    const std::lock_guard lock(mutex_);
    std::uint64_t given_up = ending(client);
    std::map<std::string, std::uint64_t> held;
    for (const Holder& holder : holders_)
      if (holder.client != client && !held.contains(holder.client))
        held[holder.client] = held_by(holder.client);
    for (const Holder& holder : holders_)
      if (const auto at = held.find(holder.client); holder.given_up && at != held.end())
        at->second -= std::min(at->second, holder.bytes());
    given_up += give_up_most(held, part, missing - std::min(missing, given_up), Why::kOverPart, least_age);
    return given_up > 0;
  }
  /// As above, but for computations of other clients that stand still because of their processor rate.
  bool give_up_standing(const std::string& client, std::uint64_t missing) {
    const std::lock_guard lock(mutex_);
    std::uint64_t given_up = ending(client);
    for (auto at = holders_.rbegin(); at != holders_.rend() && given_up < missing; ++at)
      if (!at->given_up && at->client != client && at->may_give_up(Why::kStandsStill))
        given_up += ask_to_end(*at, Why::kStandsStill);
    return given_up > 0;
  }
  /// Returns whether `missing` bytes could be given up for this client, or are being given up: by computations that stand still,
  /// and by those of clients that hold more than `part`.
  bool could_give_up(const std::string& client, std::uint64_t missing, std::uint64_t part,
                     const HeldBy& held_by) {
    const std::lock_guard lock(mutex_);
    std::uint64_t bytes = ending(client);
    for (const Holder& holder : holders_) {
      if (holder.given_up || holder.client == client) continue;
      if (holder.may_give_up(Why::kStandsStill) ||
          (holder.may_give_up(Why::kOverPart) && held_by(holder.client) > part))
        bytes += holder.bytes();
    }
    return bytes > 0 && bytes >= missing;
  }
  /// Blocks until all computations of other clients that were given up have released their memory. Ignores computations that
  /// begin during the wait. Returns false on a timeout.
  bool wait(const std::string& client, std::chrono::steady_clock::time_point longest) {
    std::unique_lock lock(mutex_);
    return removed_.wait_until(lock, longest, [this, &client, end = next_] {
      return std::none_of(holders_.begin(), holders_.end(), [&client, end](const Holder& h) {
        return h.given_up && h.number < end && h.client != client;
      });
    });
  }

 private:
  // All functions require the lock.
  /// Returns how many bytes of other clients are being given up. A background computation may have become urgent in the meantime.
  std::uint64_t ending(const std::string& client) {
    std::uint64_t bytes = 0;
    for (Holder& holder : holders_) {
      if (holder.given_up && holder.why == Why::kBackground)
        holder.given_up = holder.may_give_up(Why::kBackground);
      if (holder.given_up && holder.client != client) bytes += holder.bytes();
    }
    return bytes;
  }
  static std::uint64_t ask_to_end(Holder& holder, Why why) {
    const std::uint64_t bytes = holder.bytes();
    holder.give_up(why);
    holder.given_up = true;
    holder.why = why;
    return bytes;
  }
  /// Gives up at least `missing` bytes, as far as possible. Takes them from clients that hold more than `least`, and from
  /// computations that are at least `least_age` old. `held`: what each client holds. Returns the number of bytes.
  std::uint64_t give_up_most(std::map<std::string, std::uint64_t>& held, std::uint64_t least,
                             std::uint64_t missing, Why why, std::chrono::milliseconds least_age) {
    const auto latest_begin = std::chrono::steady_clock::now() - least_age;
    std::uint64_t given_up = 0;
    while (given_up < missing && !held.empty()) {
      const auto most = std::max_element(held.begin(), held.end(),
                                         [](const auto& a, const auto& b) { return a.second < b.second; });
      if (most->second <= least) break;
      Holder* latest = nullptr;
      std::pair<int, int> order_of_latest{};
      for (auto at = holders_.rbegin(); at != holders_.rend(); ++at) {
        if (at->given_up || at->client != most->first || at->since > latest_begin || !at->may_give_up(why))
          continue;
        const std::pair<int, int> order{-at->urgency(), at->begun_again};
        if (latest && order >= order_of_latest) continue;
        latest = &*at;
        order_of_latest = order;
      }
      if (!latest) {
        held.erase(most);
        continue;
      }
      const std::uint64_t bytes = ask_to_end(*latest, why);
      given_up += bytes;
      most->second -= std::min(most->second, bytes);
    }
    return given_up;
  }

  std::mutex mutex_;
  std::condition_variable removed_;
  std::list<Holder> holders_;  // in the order of add()
  std::uint64_t next_ = 0;
};

}  // namespace fracture
