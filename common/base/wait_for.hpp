// Waiting for a descriptor up to a deadline (POSIX).
#pragma once

#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdint>

namespace fracture {

/// Waits until `fd` is ready for one of `events` (POLLIN, POLLOUT), has failed or was closed at the other end. Returns what poll()
/// reports, which may also contain POLLHUP, POLLERR and POLLNVAL. Returns 0 and sets errno if the deadline has passed (ETIMEDOUT)
/// or if poll() fails. A signal does not end the wait.
inline short wait_for(int fd, short events, std::chrono::steady_clock::time_point deadline) {
  constexpr std::int64_t kLongest = 3'600'000;  // ms, which an int can hold
  for (;;) {
    const std::int64_t left =
        std::chrono::ceil<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now()).count();
    if (left <= 0) {
      errno = ETIMEDOUT;
      return 0;
    }
    pollfd waits{fd, events, 0};
    const int ready = ::poll(&waits, 1, static_cast<int>(std::min(left, kLongest)));
    if (ready > 0) return waits.revents;
    if (ready < 0 && errno != EINTR) return 0;
  }
}

}  // namespace fracture
