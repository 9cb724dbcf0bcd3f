#include "common/base/atomic_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>

#include "common/base/descriptor.hpp"
#include "common/base/paced_write.hpp"

namespace fracture {

bool AtomicFile::open(const std::string& path, const AtomicFileOptions& options) {
  const std::filesystem::path target(path);
  path_ = path;
  temporary_ = options.temporary.empty()
                   ? (target.parent_path() / ("." + target.filename().string() + ".part")).string()
                   : options.temporary;
  flushed_ = options.flushed;
  fd_ = ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, options.mode);
  return fd_ >= 0;
}

bool AtomicFile::append(std::span<const std::byte> bytes) { return write_all(fd_, bytes); }

bool AtomicFile::append_paced(std::span<const std::byte> bytes) { return write_paced(fd_, bytes); }

bool AtomicFile::commit() {
  bool good = !flushed_ || ::fsync(fd_) == 0;
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

bool write_atomically(const std::string& path, std::span<const std::byte> bytes,
                      const AtomicFileOptions& options) {
  AtomicFile file;
  return file.open(path, options) && file.append(bytes) && file.commit();
}

}  // namespace fracture
