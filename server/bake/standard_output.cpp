#include "server/bake/standard_output.hpp"

#include <poll.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

#include "server/bake/wait_for.hpp"

namespace fracture::bake {

namespace {

/// A pipe that polls as writable accepts this many bytes without blocking (POSIX: PIPE_BUF).
constexpr std::size_t kPipeBlock = 4096;

bool write_with_polls(int fd, std::span<const std::byte> bytes, const std::stop_token& stop) {
  while (!bytes.empty()) {
    if (!wait_for(fd, POLLOUT, stop)) return false;
    const ssize_t n = ::write(fd, bytes.data(), std::min(bytes.size(), kPipeBlock));
    if (n < 0 && (errno == EINTR || errno == EAGAIN)) continue;
    if (n <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(n));
  }
  return true;
}

}  // namespace

bool write_standard_output(std::span<const std::byte> bytes, const std::stop_token& stop) {
  struct sigaction ignore {
  }, before{};
  ignore.sa_handler = SIG_IGN;
  ::sigaction(SIGPIPE, &ignore, &before);
  const bool good = write_with_polls(STDOUT_FILENO, bytes, stop);
  const int reason = errno;
  ::sigaction(SIGPIPE, &before, nullptr);
  errno = reason;
  return good;
}

}  // namespace fracture::bake
