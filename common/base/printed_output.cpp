#include "common/base/printed_output.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <iostream>

#include "common/base/exit_codes.hpp"

namespace fracture {
namespace {

std::atomic<int> first_loss{0};

void remember_loss(int reason) {
  int none = 0;
  first_loss.compare_exchange_strong(none, reason != 0 ? reason : EIO);
}

}  // namespace

void occupy_standard_streams() {
  for (int stream = STDIN_FILENO; stream <= STDERR_FILENO; ++stream) {
    if (::fcntl(stream, F_GETFD) >= 0 || errno != EBADF) continue;
    // open() returns the lowest free number, so it returns `stream`. Its text must not vanish without an error, so the file is
    // opened for the wrong direction.
    if (::open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY) < 0) return;
  }
}

int flush_printed() {
  const int before = errno;
  const bool lost = !std::cout || std::ferror(stdout) != 0;
  errno = 0;
  std::cout.flush();
  const bool flushed = std::fflush(stdout) == 0 && (lost || std::cout);
  if (lost || !flushed) remember_loss(!flushed && errno != 0 ? errno : before);
  return first_loss;
}

int finish_printed(const char* program, int exit_code) {
  flush_printed();
  const int copy = ::fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 0);
  if (copy >= 0 && ::close(copy) != 0) remember_loss(errno);
  if (first_loss == 0) return exit_code;
  std::fprintf(stderr, "%s: cannot write to standard output: %s\n", program, std::strerror(first_loss));
  return kExitSystem;
}

}  // namespace fracture
