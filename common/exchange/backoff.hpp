// How long to wait before a request is sent again: truncated exponential backoff. It has no jitter, because
// one process has few callers, and a busy server sends Retry-After.
#pragma once

#include <algorithm>

#include "common/exchange/exchange.hpp"

namespace fracture::protocol {

class Backoff {
 public:
  Backoff(Milliseconds first, Milliseconds longest) : pause_(first), longest_(longest) {}

  /// The wait before the next try.
  Milliseconds pause() const { return pause_; }
  /// To be called after a pause: the next one is twice as long, up to the longest.
  void lengthen() { pause_ = std::min(2 * pause_, longest_); }

 private:
  Milliseconds pause_;
  const Milliseconds longest_;
};

}  // namespace fracture::protocol
