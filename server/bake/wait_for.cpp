#include "server/bake/wait_for.hpp"

#include <cerrno>
#include <chrono>

#include "common/base/wait_for.hpp"

namespace fracture::bake {

bool wait_for(int fd, short events, const std::stop_token& stop) {
  constexpr std::chrono::milliseconds kBetweenLooks(50);
  for (;;) {
    if (stop.stop_requested()) {
      errno = ECANCELED;
      return false;
    }
    if (fracture::wait_for(fd, events, std::chrono::steady_clock::now() + kBetweenLooks) != 0) return true;
    if (errno != ETIMEDOUT) return true;  // the next call on `fd` reports the failure
  }
}

}  // namespace fracture::bake
