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

bool AtomicFile::open(const std::string& path) {
  const fs::path target(path);
  path_ = path;
  temporary_ = (target.parent_path() / ("." + target.filename().string() + ".part")).string();
  fd_ = ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, 0666);
  return fd_ >= 0;
}

bool AtomicFile::append(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::write(fd_, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(n));
  }
  return true;
}

bool AtomicFile::commit() {
  bool good = ::fsync(fd_) == 0;
  good = ::close(fd_) == 0 && good;
  good = good && std::rename(temporary_.c_str(), path_.c_str()) == 0;
  fd_ = -1;
  if (!good) discard();
  return good;
}

void AtomicFile::discard() {
  const int reason = errno;
  ::unlink(temporary_.c_str());
  errno = reason;
}

AtomicFile::~AtomicFile() {
  if (fd_ < 0) return;
  const int reason = errno;
  ::close(fd_);
  errno = reason;
  discard();
}

bool write_file(const std::string& path, std::span<const std::byte> bytes) {
  AtomicFile file;
  return file.open(path) && file.append(bytes) && file.commit();
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
