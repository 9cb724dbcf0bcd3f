#include "server/import_worker/shared_memory.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

#include "common/base/pacer.hpp"

namespace fracture {

Descriptor make_shared_memory(const char* name) {
  int fd = ::memfd_create(name, MFD_CLOEXEC | MFD_ALLOW_SEALING);
  if (fd < 0 && (errno == ENOSYS || errno == EPERM || errno == EACCES))  // a container may forbid it
    for (const char* folder : {"/dev/shm", "/tmp"})
      if ((fd = ::open(folder, O_TMPFILE | O_RDWR | O_CLOEXEC, 0600)) >= 0) break;
  if (fd < 0)
    throw std::system_error(errno, std::generic_category(),
                            "cannot create shared memory for an import worker");
  return Descriptor(fd);
}

bool seal(int fd) { return ::fcntl(fd, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_WRITE) == 0; }

SealedBytes SealedBytes::take(int fd, std::uint64_t size, const Execution& execution) {
  SealedBytes bytes;
  const bool sealed = seal(fd);
  struct stat status {};
  if (::fstat(fd, &status) != 0 || size > static_cast<std::uint64_t>(status.st_size)) return bytes;
  void* const mapping = sealed && size > 0 ? ::mmap(nullptr, size, PROT_READ, MAP_SHARED, fd, 0) : MAP_FAILED;
  if (mapping != MAP_FAILED) {
    bytes.mapping_ = mapping;
    bytes.view_ = {static_cast<const std::byte*>(mapping), static_cast<std::size_t>(size)};
  } else {
    resize_with_polls(execution, bytes.copy_, size);
    for (std::size_t at = 0; at < size;) {
      execution.poll();
      const std::size_t piece = std::min<std::uint64_t>(size - at, kBytesBetweenPolls);
      const ssize_t n = ::pread(fd, bytes.copy_.data() + at, piece, static_cast<off_t>(at));
      if (n < 0 && errno == EINTR) continue;
      if (n <= 0) return bytes;  // it was shortened in the meantime
      at += static_cast<std::size_t>(n);
    }
    bytes.view_ = bytes.copy_;
  }
  bytes.good_ = true;
  return bytes;
}

SealedBytes::SealedBytes(SealedBytes&& other) noexcept
    : good_(std::exchange(other.good_, false)),
      mapping_(std::exchange(other.mapping_, nullptr)),
      copy_(std::move(other.copy_)),
      view_(std::exchange(other.view_, {})) {}

SealedBytes::~SealedBytes() {
  if (mapping_ != nullptr) ::munmap(mapping_, view_.size());
}

}  // namespace fracture
