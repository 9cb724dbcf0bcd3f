// Pipes that may stay silent or full for ever, and a stop that ends the wait.
#pragma once

#include <stop_token>

namespace fracture::bake {

/// Waits until `fd` is ready for one of `events` (POLLIN, POLLOUT), or is broken: the call that follows says so. False
/// with errno ECANCELED once a stop is asked for, within 50 ms.
bool wait_for(int fd, short events, const std::stop_token& stop);

}  // namespace fracture::bake
