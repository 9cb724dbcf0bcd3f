// Background computations that hold memory. If they hold more than their half (MemoryBudget::Use) and a computation that a
// client waits for lacks it, some are given up: those of the client that holds most, the latest first.
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
    std::uint64_t bytes = 0;  ///< by estimate
    /// It ends soon. False: it does not, because it does not run, or because somebody waits for it by now.
    std::function<bool()> give_up;
    bool given_up = false;
    std::uint64_t number = 0;  ///< grows from one to the next
  };
  using Id = std::list<Holder>::iterator;

  Id add(Holder holder) {
    const std::lock_guard lock(mutex_);
    holder.number = next_++;
    return holders_.insert(holders_.end(), std::move(holder));
  }
  /// Its memory is free.
  void remove(Id holder) noexcept {
    {
      const std::lock_guard lock(mutex_);
      holders_.erase(holder);
    }
    removed_.notify_all();
  }

  /// Other clients than this one give up so many bytes, computations that end already included. False: none can be given up.
  bool give_up(const std::string& client, std::uint64_t missing) {
    const std::lock_guard lock(mutex_);
    std::uint64_t given_up = 0;
    std::map<std::string, std::uint64_t> held;
    for (Holder& holder : holders_) {
      holder.given_up = holder.given_up && holder.give_up();  // it may have become urgent meanwhile
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
  /// Returns when what was given up is free, whatever began meanwhile; false: it is not at that time.
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
  std::list<Holder> holders_;  // in the order in which they began
  std::uint64_t next_ = 0;
};

}  // namespace fracture
