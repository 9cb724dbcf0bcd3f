// The time that a computation runs without a poll: an interruption may have to wait that long.
#pragma once

#include <sys/mman.h>
#include <sys/resource.h>
#include <time.h>

#include <algorithm>
#include <cstdint>

#include "common/base/execution.hpp"

namespace fracture::test {

/// The processor time of the thread that made the clock, without the time that the system takes to hand out
/// memory. That time does not depend on the code: a page took 15 to 45 µs on a virtual machine, and 0.3 µs
/// elsewhere.
class WorkClock {
 public:
  WorkClock() : page_ms_(kMostPageCost * cost_of_page_ms()) {}
  double ms() const {
    const Moment here = now();
    return here.cpu_ms - page_ms_ * here.pages;
  }

 private:
  /// The cost of a page varies by this factor.
  static constexpr double kMostPageCost = 1.5;

  struct Moment {
    double cpu_ms;
    double pages;  ///< pages that the system gave to this thread so far
  };
  static Moment now() {
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    rusage used{};
    getrusage(RUSAGE_THREAD, &used);
    return {1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec),
            static_cast<double>(used.ru_minflt)};
  }
  static double cost_of_page_ms() {
    constexpr std::size_t kBytes = 1 << 20, kLeastPage = 4096;
    void* const memory = mmap(nullptr, kBytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) return 0;
    const Moment before = now();
    for (std::size_t k = 0; k < kBytes; k += kLeastPage) static_cast<volatile char*>(memory)[k] = 1;
    const Moment after = now();
    munmap(memory, kBytes);
    return (after.cpu_ms - before.cpu_ms) / std::max(1.0, after.pages - before.pages);
  }

  double page_ms_;
};

/// Measures the work of one thread between the polls of an Execution, and from the last poll to longest_ms().
/// The computation must run in the thread that made this object.
class PollGaps {
 public:
  PollGaps() : last_(clock_.ms()) {
    execution_.watch = [this] {
      meet();
      ++polls_;
    };
  }
  PollGaps(const PollGaps&) = delete;
  PollGaps& operator=(const PollGaps&) = delete;

  const Execution& execution() const { return execution_; }
  /// Starts anew: work done so far is preparation and not part of the computation.
  void start() {
    last_ = clock_.ms();
    longest_ = 0;
    polls_ = 0;
  }
  double longest_ms() {
    meet();
    return longest_;
  }
  std::uint64_t polls() const { return polls_; }

 private:
  void meet() {
    const double here = clock_.ms();
    longest_ = std::max(longest_, here - last_);
    last_ = here;
  }

  Execution execution_;
  WorkClock clock_;
  double last_, longest_ = 0;
  std::uint64_t polls_ = 0;
};

/// The limit promised for an optimized build. The other builds are slower by about these factors.
#if defined(FRACTURE_SANITIZED)
inline constexpr double kMostPollGapMs = 50 * 20;
#elif !defined(NDEBUG)
inline constexpr double kMostPollGapMs = 50 * 10;
#else
inline constexpr double kMostPollGapMs = 50;
#endif

/// The longest gap of `run(execution)`, and the number of polls. If a gap is too long, the run is repeated a
/// few times: a busy machine pauses at another place each time, but the code does not. The computation must
/// not depend on how often it runs.
struct Polled {
  double longest_ms = 0;
  std::uint64_t polls = 0;
};
template <class Run>
Polled polled(const Run& run) {
  constexpr int kTries = 4;
  Polled least;
  for (int k = 0; k < kTries; ++k) {
    PollGaps gaps;
    run(gaps.execution());
    const double longest = gaps.longest_ms();
    if (k == 0 || longest < least.longest_ms) least = {longest, gaps.polls()};
    if (longest < kMostPollGapMs) break;
  }
  return least;
}

}  // namespace fracture::test
