#include "server/bake/atomic_file.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <filesystem>

#include "server/bake/wait_for.hpp"

namespace fracture::bake {

namespace fs = std::filesystem;

namespace {

/// A pipe that takes anything takes so much without waiting (POSIX: PIPE_BUF).
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

bool write_file(const std::string& path, std::span<const std::byte> bytes) {
  const fs::path target(path);
  const std::string temporary =
      (target.parent_path() / ("." + target.filename().string() + ".part")).string();
  const int fd = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, 0666);
  if (fd < 0) return false;
  std::size_t written = 0;
  bool good = true;
  while (good && written < bytes.size()) {
    const ssize_t n = ::write(fd, bytes.data() + written, bytes.size() - written);
    if (n < 0 && errno == EINTR) continue;
    good = n > 0;
    if (good) written += static_cast<std::size_t>(n);
  }
  good = good && ::fsync(fd) == 0;
  good = ::close(fd) == 0 && good;
  good = good && std::rename(temporary.c_str(), path.c_str()) == 0;
  if (!good) {
    const int reason = errno;
    ::unlink(temporary.c_str());
    errno = reason;
  }
  return good;
}

bool make_folders_of(const std::string& path) {
  std::error_code error;
  const fs::path folder = fs::path(path).parent_path();
  if (folder.empty()) return true;
  fs::create_directories(folder, error);
  if (error) errno = error.value();
  return !error;
}

}  // namespace fracture::bake
