#include "server/jobs/durable_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

#include "common/base/atomic_file.hpp"
#include "common/base/descriptor.hpp"

namespace fracture {
namespace {

Descriptor opened(const std::string& path, int flags) {
  return Descriptor(::open(path.c_str(), flags | O_CLOEXEC));
}

/// Flushes the folder. Without this, the new name of a renamed file may be lost on a power failure.
bool flush_folder_of(const std::string& path) {
  const Descriptor folder = opened(path.substr(0, path.rfind('/')), O_RDONLY | O_DIRECTORY);
  return folder && ::fsync(folder.get()) == 0;
}

}  // namespace

bool write_durably(const std::string& temporary, const std::string& path, std::string_view head,
                   std::span<const std::span<const std::byte>> parts) {
  AtomicFile file;
  bool good =
      file.open(path, {.temporary = temporary, .mode = 0644}) && file.append(std::as_bytes(std::span(head)));
  for (const std::span<const std::byte> part : parts) good = good && file.append_paced(part);
  return good && file.commit() && flush_folder_of(path);
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
