// Waits with a limit. A test asks repeatedly whether an event has happened. If it has not happened within the
// limit, the test fails and names it.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

namespace fracture::test {

/// The default limit: at least ten times what a busy machine takes for any of our steps.
inline constexpr std::chrono::seconds kPatience{120};

/// Calls predicate() until it is true. At first it calls without a pause, so that a test which waits for a quick
/// event continues at once. Then it calls every few milliseconds. It calls at least once, and once more after
/// the limit, so that a test does not fail only because its process was stopped for long. A failure states the
/// event and the waiting time: `what` completes "waited ... for".
///
///     EXPECT_TRUE(eventually(kPatience, "the first answer", [&] { return answered > 0; }));
template <class Predicate>
testing::AssertionResult eventually(std::chrono::milliseconds limit, const std::string& what,
                                    Predicate&& predicate) {
  const auto begin = std::chrono::steady_clock::now();
  for (;;) {
    const auto waited = std::chrono::steady_clock::now() - begin;
    if (predicate()) return testing::AssertionSuccess();
    if (waited >= limit)
      return testing::AssertionFailure()
             << "waited " << std::chrono::duration<double>(waited).count() << " s for " << what;
    if (waited < std::chrono::milliseconds(1))
      std::this_thread::yield();
    else
      std::this_thread::sleep_for(std::chrono::milliseconds(waited < std::chrono::milliseconds(100) ? 1 : 5));
  }
}

/// The same for helpers of a test that cannot continue without the event: throws std::runtime_error.
template <class Predicate>
void require_eventually(std::chrono::milliseconds limit, const std::string& what, Predicate&& predicate) {
  if (const testing::AssertionResult happened = eventually(limit, what, std::forward<Predicate>(predicate));
      !happened)
    throw std::runtime_error(happened.message());
}

}  // namespace fracture::test
