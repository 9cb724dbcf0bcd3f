// A token bucket (Turner 1986, "New directions in communications"). It limits the average rate, but allows the unused amount
// of the last seconds to be used at once.
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>

namespace fracture::tenants {

/// Not thread-safe. Starts full. The level may fall below zero, because some amounts are known only afterwards.
class Bucket {
 public:
  using Clock = std::chrono::steady_clock;

  /// Refills the bucket up to `now`. A new rate or capacity applies from then on.
  void advance(double rate, double capacity, Clock::time_point now) {
    if (begun_ && now > last_) level_ += rate * std::chrono::duration<double>(now - last_).count();
    level_ = begun_ ? std::min(level_, capacity) : capacity;
    if (!begun_ || now > last_) last_ = now;
    begun_ = true;
  }
  double level() const { return level_; }
  void take(double amount) { level_ -= amount; }
  /// Returns how long it takes until the level is `wanted`.
  std::chrono::duration<double> until(double wanted, double rate) const {
    return std::chrono::duration<double>(std::max(0.0, wanted - level_) / rate);
  }

 private:
  double level_ = 0;
  Clock::time_point last_{};
  bool begun_ = false;
};

}  // namespace fracture::tenants
