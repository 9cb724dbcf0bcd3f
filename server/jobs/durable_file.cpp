#include "server/jobs/durable_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>

#include "common/base/atomic_file.hpp"
#include "common/base/descriptor.hpp"
#include "server/cache/stored_file.hpp"

namespace fracture {
namespace {

/// Flushes the folder. Without this, the new name of a renamed file may be lost on a power failure.
bool flush_folder_of(const std::string& path) {
  const std::string name = path.substr(0, path.rfind('/'));
  const Descriptor folder(::open(name.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  return folder && ::fsync(folder.get()) == 0;
}

}  // namespace

bool write_durably(const std::string& temporary, const std::string& path, std::string_view head,
                   std::span<const std::span<const std::byte>> parts) {
  AtomicFile file;
  bool good =
      file.open(path, {.temporary = temporary, .mode = 0600}) && file.append(std::as_bytes(std::span(head)));
  for (const std::span<const std::byte> part : parts) good = good && file.append_paced(part);
  return good && file.commit() && flush_folder_of(path);
}

std::optional<std::vector<std::uint8_t>> read_whole(const std::string& path, std::uint64_t most) {
  const std::optional<StoredFile> stored = open_stored(path);
  if (!stored) return std::nullopt;
  if (stored->size > most) {
    errno = EFBIG;
    return std::nullopt;
  }
  return read_bytes(*stored, stored->size);
}

}  // namespace fracture
