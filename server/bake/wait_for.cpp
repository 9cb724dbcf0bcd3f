#include "server/bake/wait_for.hpp"

#include <poll.h>

#include <cerrno>

namespace fracture::bake {

bool wait_for(int fd, short events, const std::stop_token& stop) {
  constexpr int kPollMilliseconds = 50;
  pollfd waits{fd, events, 0};
  do {
    if (stop.stop_requested()) {
      errno = ECANCELED;
      return false;
    }
  } while (::poll(&waits, 1, kPollMilliseconds) == 0);
  return true;
}

}  // namespace fracture::bake
