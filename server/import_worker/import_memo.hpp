// Remembers files that could not be read. If such a file comes again, it is refused without starting a process.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>

#include "common/base/error.hpp"

namespace fracture {

/// Remembers the latest kMost files, for an hour, because a reader may also fail for a temporary reason. Thread-safe.
class ImportMemo {
 public:
  using Clock = std::chrono::steady_clock;

  static constexpr std::uint64_t kAnyMemory = UINT64_MAX;

  struct Known {
    std::optional<Error> error;    ///< the file killed its reader, or exceeded an import's limits
    std::uint64_t with_bytes = 0;  ///< `error` applies to imports with at most this much memory
    /// The file was read for this long, and reading did not finish.
    Clock::duration needs_more_than{0};
  };

  /// Remembers an error. `with_bytes`: the error applies to imports with at most this much memory.
  void add(const std::string& input, const Error& error, std::uint64_t with_bytes = kAnyMemory,
           Clock::time_point now = Clock::now()) {
    const std::lock_guard lock(mutex_);
    Known& known = entry(input, now);
    if (known.error && known.with_bytes >= with_bytes) return;
    known.error = error;
    known.with_bytes = with_bytes;
  }
  void add(const std::string& input, Clock::duration given, Clock::time_point now = Clock::now()) {
    const std::lock_guard lock(mutex_);
    Known& known = entry(input, now);
    known.needs_more_than = std::max(known.needs_more_than, given);
  }
  std::optional<Known> find(const std::string& input, Clock::time_point now = Clock::now()) const {
    const std::lock_guard lock(mutex_);
    const auto at = known_.find(input);
    if (at == known_.end() || at->second.second + kTimeToLive <= now) return std::nullopt;
    return at->second.first;
  }

  static constexpr std::size_t kMost = 512;
  static constexpr std::chrono::hours kTimeToLive{1};

 private:
  /// Returns the entry of this input. Replaces it with a new one if it has expired.
  Known& entry(const std::string& input, Clock::time_point now) {
    const auto [at, created] = known_.try_emplace(input, Known{}, now);
    if (!created && at->second.second + kTimeToLive <= now) at->second = {Known{}, now};
    if (created) {
      order_.push_back(input);
      if (order_.size() > kMost) {
        known_.erase(order_.front());
        order_.pop_front();
      }
    }
    return known_.find(input)->second.first;
  }

  mutable std::mutex mutex_;
  std::unordered_map<std::string, std::pair<Known, Clock::time_point>> known_;  // never iterated
  std::deque<std::string> order_;                                               // oldest first
};

}  // namespace fracture
