// How long to wait before a request is sent again: truncated exponential backoff, without jitter, since the callers of
// one process are few and a busy server says by Retry-After when to come back.
#pragma once

#include <algorithm>

#include "common/exchange/exchange.hpp"

namespace fracture::protocol {

class Backoff {
 public:
  Backoff(Milliseconds first, Milliseconds longest) : pause_(first), longest_(longest) {}

  /// Before the next try.
  Milliseconds pause() const { return pause_; }
  /// After a pause: the next one is twice as long, up to the longest.
  void lengthen() { pause_ = std::min(2 * pause_, longest_); }

 private:
  Milliseconds pause_;
  const Milliseconds longest_;
};

}  // namespace fracture::protocol
