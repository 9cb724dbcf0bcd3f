// Stops calls to a service that does not answer. After a few failures in a row, all calls are refused for a pause; then one
// call is allowed as a test. Each further failure doubles the pause (Nygard, "Release It!", 2007).
#pragma once

#include <algorithm>
#include <chrono>
#include <mutex>

namespace fracture {

/// Thread-safe.
class CircuitBreaker {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr int kFailures = 3;
  static constexpr std::chrono::milliseconds kShortest{1'000}, kLongest{30'000};

  /// Returns whether a call may be made now. After true, the caller must report success() or failure().
  bool allows(Clock::time_point now = Clock::now()) {
    const std::lock_guard lock(mutex_);
    if (failures_ < kFailures) return true;
    if (now < closed_until_) return false;
    closed_until_ = now + pause_;  // one caller tries, and the others keep waiting
    return true;
  }
  void success() {
    const std::lock_guard lock(mutex_);
    failures_ = 0;
    pause_ = kShortest;
  }
  void failure(Clock::time_point now = Clock::now()) {
    const std::lock_guard lock(mutex_);
    if (++failures_ < kFailures) return;
    if (failures_ > kFailures) pause_ = std::min(2 * pause_, kLongest);
    closed_until_ = now + pause_;
  }
  bool open() const {
    const std::lock_guard lock(mutex_);
    return failures_ >= kFailures;
  }

 private:
  mutable std::mutex mutex_;
  int failures_ = 0;
  std::chrono::milliseconds pause_{kShortest};
  Clock::time_point closed_until_{};
};

}  // namespace fracture
