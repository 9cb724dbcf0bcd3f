// Background computations that hold memory. They may use more than half of the working memory (MemoryBudget::Use). If a
// client then waits for a computation that lacks memory, some background computations are given up. The client that holds
// the most memory loses its latest computation first.
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
class BackgroundMemory {
 public:
  struct Holder {
    std::string client;
    std::uint64_t bytes = 0;  ///< estimated
    /// Asks the computation to end soon. Returns false if it cannot be given up because a client waits for it by now.
    std::function<bool()> give_up;
    bool given_up = false;
    std::uint64_t number = 0;  ///< consecutive, in the order of add()
  };
  using Id = std::list<Holder>::iterator;

  Id add(Holder holder) {
    const std::lock_guard lock(mutex_);
    holder.number = next_++;
    return holders_.insert(holders_.end(), std::move(holder));
  }
  /// Call it after the holder's memory was released.
  void remove(Id holder) noexcept {
    {
      const std::lock_guard lock(mutex_);
      holders_.erase(holder);
    }
    removed_.notify_all();
  }

  /// Makes other clients than this one give up `missing` bytes. Computations that are already ending count. Returns false if
  /// nothing can be given up.
  bool give_up(const std::string& client, std::uint64_t missing) {
    const std::lock_guard lock(mutex_);
    std::uint64_t given_up = 0;
    std::map<std::string, std::uint64_t> held;
    for (Holder& holder : holders_) {
      holder.given_up = holder.given_up && holder.give_up();  // it may have become urgent in the meantime
      (holder.given_up ? given_up : held[holder.client]) += holder.bytes;
    }
    held.erase(client);
    while (given_up < missing && !held.empty()) {
      const auto most = std::max_element(held.begin(), held.end(),
                                         [](const auto& a, const auto& b) { return a.second < b.second; });
      const auto latest = std::find_if(holders_.rbegin(), holders_.rend(), [&](Holder& holder) {
        return !holder.given_up && holder.client == most->first && holder.give_up();
      });
      if (latest == holders_.rend()) {
        held.erase(most);
        continue;
      }
      latest->given_up = true;
      given_up += latest->bytes;
      most->second -= latest->bytes;
    }
    return given_up > 0;
  }
  /// Blocks until all computations that were given up have released their memory. Ignores computations that begin during the
  /// wait. Returns false on a timeout.
  bool wait(std::chrono::steady_clock::time_point longest) {
    std::unique_lock lock(mutex_);
    return removed_.wait_until(lock, longest, [this, end = next_] {
      return std::none_of(holders_.begin(), holders_.end(),
                          [end](const Holder& h) { return h.given_up && h.number < end; });
    });
  }

 private:
  std::mutex mutex_;
  std::condition_variable removed_;
  std::list<Holder> holders_;  // in the order of add()
  std::uint64_t next_ = 0;
};

}  // namespace fracture
