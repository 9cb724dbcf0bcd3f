#include "server/jobs/durable_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>

#include "common/base/descriptor.hpp"
#include "common/base/paced_write.hpp"

namespace fracture {
namespace {

Descriptor opened(const std::string& path, int flags) {
  return Descriptor(::open(path.c_str(), flags | O_CLOEXEC, 0644));
}

bool write_flushed(const std::string& path, std::string_view head,
                   std::span<const std::span<const std::byte>> parts) {
  const Descriptor file = opened(path, O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW);
  if (!file || !write_all(file.get(), std::as_bytes(std::span(head)))) return false;
  for (const std::span<const std::byte> part : parts)
    if (!write_paced(file.get(), part)) return false;
  return ::fsync(file.get()) == 0;
}

/// Flushes the folder. Without this, the new name of a renamed file may be lost on a power failure.
bool flush_folder_of(const std::string& path) {
  const Descriptor folder = opened(path.substr(0, path.rfind('/')), O_RDONLY | O_DIRECTORY);
  return folder && ::fsync(folder.get()) == 0;
}

}  // namespace

bool write_durably(const std::string& temporary, const std::string& path, std::string_view head,
                   std::span<const std::span<const std::byte>> parts) {
  bool good = write_flushed(temporary, head, parts);
  good = good && std::rename(temporary.c_str(), path.c_str()) == 0 && flush_folder_of(path);
  if (!good) {
    const int reason = errno;
    ::unlink(temporary.c_str());
    errno = reason;
  }
  return good;
}

std::optional<std::vector<std::uint8_t>> read_whole(const std::string& path, std::uint64_t most) {
  const Descriptor file = opened(path, O_RDONLY | O_NOFOLLOW);
  struct stat status {};
  if (!file || ::fstat(file.get(), &status) != 0) return std::nullopt;
  if (!S_ISREG(status.st_mode) || static_cast<std::uint64_t>(status.st_size) > most) {
    errno = EFBIG;
    return std::nullopt;
  }
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(status.st_size));
  for (std::size_t at = 0; at < bytes.size();) {
    const ssize_t n = ::read(file.get(), bytes.data() + at, bytes.size() - at);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return std::nullopt;
    if (n == 0) bytes.resize(at);
    at += static_cast<std::size_t>(n);
  }
  return bytes;
}

}  // namespace fracture
