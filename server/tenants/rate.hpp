// A token bucket (Turner 1986, "New directions in communications"): so much a second on average, and what was
// not used of some seconds at once.
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>

namespace fracture::tenants {

/// Not thread-safe. Starts full. The level may fall below zero, where what was taken is only known
/// afterwards.
class Bucket {
 public:
  using Clock = std::chrono::steady_clock;

  /// Refills up to `now`. A new rate or capacity holds from then on.
  void advance(double rate, double capacity, Clock::time_point now) {
    if (begun_ && now > last_) level_ += rate * std::chrono::duration<double>(now - last_).count();
    level_ = begun_ ? std::min(level_, capacity) : capacity;
    if (!begun_ || now > last_) last_ = now;
    begun_ = true;
  }
  double level() const { return level_; }
  void take(double amount) { level_ -= amount; }
  /// How long until the level is `wanted`.
  std::chrono::duration<double> until(double wanted, double rate) const {
    return std::chrono::duration<double>(std::max(0.0, wanted - level_) / rate);
  }

 private:
  double level_ = 0;
  Clock::time_point last_{};
  bool begun_ = false;
};

}  // namespace fracture::tenants
