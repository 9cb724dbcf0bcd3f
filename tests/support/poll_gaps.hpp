// How long a computation goes on without a poll: what an interruption may have to wait for.
#pragma once

#include <time.h>

#include <algorithm>
#include <cstdint>

#include "common/base/execution.hpp"

namespace fracture::test {

/// Measures one thread's own processor time between the polls of an Execution, and from the last one to
/// longest_ms(). The computation must run in the thread that made this.
class PollGaps {
 public:
  PollGaps() : last_(now_ms()) {
    execution_.watch = [this] {
      meet();
      ++polls_;
    };
  }
  PollGaps(const PollGaps&) = delete;
  PollGaps& operator=(const PollGaps&) = delete;

  const Execution& execution() const { return execution_; }
  /// Forgets everything: what was made ready until here is not part of the computation.
  void start() {
    last_ = now_ms();
    longest_ = 0;
    polls_ = 0;
  }
  double longest_ms() {
    meet();
    return longest_;
  }
  std::uint64_t polls() const { return polls_; }

 private:
  static double now_ms() {
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
  }
  void meet() {
    const double now = now_ms();
    longest_ = std::max(longest_, now - last_);
    last_ = now;
  }

  Execution execution_;
  double last_, longest_ = 0;
  std::uint64_t polls_ = 0;
};

/// What is promised of an optimized build. The others are slower by about as much.
#if defined(FRACTURE_SANITIZED)
inline constexpr double kMostPollGapMs = 50 * 20;
#elif !defined(NDEBUG)
inline constexpr double kMostPollGapMs = 50 * 10;
#else
inline constexpr double kMostPollGapMs = 50;
#endif

}  // namespace fracture::test
