// Waits on pipes, which may block forever, until they are ready or a stop is requested.
#pragma once

#include <stop_token>

namespace fracture::bake {

/// Waits until `fd` is ready for one of `events` (POLLIN, POLLOUT) or has failed, which the next call on it
/// reports. Returns false and sets errno to ECANCELED within 50 ms after a stop is requested.
bool wait_for(int fd, short events, const std::stop_token& stop);

}  // namespace fracture::bake
