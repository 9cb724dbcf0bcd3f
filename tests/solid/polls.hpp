// What lies between the polls of a computation, and how many there are: loops poll once in some thousand
// steps, so that the number of polls counts the work.
#pragma once

#include <time.h>

#include <algorithm>
#include <cstdint>

#include "common/base/execution.hpp"

namespace fracture::test {

class PollWatch {
 public:
  PollWatch() {
    execution.watch = [this] { look(), ++polls; };
  }
  PollWatch(const PollWatch&) = delete;

  /// Milliseconds of the thread's own processor time between two polls, at most; since construction or
  /// restart(), and up to this call.
  double largest_gap() {
    look();
    return 1e3 * largest_;
  }
  void restart() {
    last_ = now();
    largest_ = 0;
    polls = 0;
  }

  Execution execution;
  std::uint64_t polls = 0;

 private:
  static double now() {
    timespec time;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
  }
  void look() {
    const double time = now();
    largest_ = std::max(largest_, time - last_);
    last_ = time;
  }
  double last_ = now(), largest_ = 0;
};

/// An interruption takes effect within this many milliseconds of the thread's own processor time.
#ifdef FRACTURE_SANITIZED
inline constexpr double kLongestGap = 1000;
#elif !defined(NDEBUG)
inline constexpr double kLongestGap = 500;
#else
inline constexpr double kLongestGap = 50;
#endif

}  // namespace fracture::test
