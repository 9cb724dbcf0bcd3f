#include "server/cache/stored_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>

#include "common/base/pacer.hpp"

namespace fracture {

std::optional<StoredFile> open_stored(const std::string& path) {
  // O_NONBLOCK: otherwise open() would wait for a writer of a FIFO.
  StoredFile stored{Descriptor(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK))};
  if (!stored.file) {
    if (errno == ELOOP || errno == ENXIO) errno = EINVAL;  // a link; a socket
    return std::nullopt;
  }
  struct stat status {};
  if (::fstat(stored.file.get(), &status) != 0) return std::nullopt;
  if (!S_ISREG(status.st_mode)) {
    stored.file.reset();
    errno = EINVAL;
    return std::nullopt;
  }
  stored.size = static_cast<std::uint64_t>(status.st_size);
  return stored;
}

std::optional<std::vector<std::uint8_t>> read_bytes(const StoredFile& stored, std::uint64_t size,
                                                    const Execution& execution) {
  std::vector<std::uint8_t> bytes;
  resize_with_polls(execution, bytes, static_cast<std::size_t>(size));
  for (std::size_t at = 0; at < bytes.size();) {
    execution.poll();
    const std::size_t piece = std::min(bytes.size() - at, kBytesBetweenPolls);
    const ssize_t n = ::read(stored.file.get(), bytes.data() + at, piece);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return std::nullopt;
    if (n == 0) bytes.resize(at);
    at += static_cast<std::size_t>(n);
  }
  return bytes;
}

}  // namespace fracture
