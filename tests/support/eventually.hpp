// Waits that end: a test asks again and again whether something has happened, and fails by name when it has
// not happened within a limit.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

namespace fracture::test {

/// The limit where a test needs no other: at least ten times what a busy machine takes for any step of ours.
inline constexpr std::chrono::seconds kPatience{120};

/// Calls predicate() until it is true: at first without a pause, so that a test which waits for something
/// quick goes on at once, then every few milliseconds. It is called at least once, and once more after
/// the limit, so that a test whose process was stopped for long does not fail for that alone. A failure says
/// what was waited for and for how long: `what` completes "waited ... for".
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

/// The same for helpers of a test that cannot go on without it: throws std::runtime_error.
template <class Predicate>
void require_eventually(std::chrono::milliseconds limit, const std::string& what, Predicate&& predicate) {
  if (const testing::AssertionResult happened = eventually(limit, what, std::forward<Predicate>(predicate));
      !happened)
    throw std::runtime_error(happened.message());
}

}  // namespace fracture::test
