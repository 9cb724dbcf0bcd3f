// Writing large files so that other writers of the same disk do not wait for them (Linux).
#pragma once

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <span>

#include "common/base/descriptor.hpp"

namespace fracture {

/// A file system that commits its journal first writes all new data of all files (ext4 in its default mode).
/// So the fsync of a small file waits for at most this much of a large one.
inline constexpr std::size_t kWritePieceBytes = std::size_t{2} << 20;

/// Writes all bytes from the current position on. After each piece of kWritePieceBytes, waits until the disk has it. Metadata may
/// still be in memory: call fsync at the end. Returns false on an error (no space, for example).
inline bool write_paced(int fd, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const std::span<const std::byte> piece = bytes.first(std::min(bytes.size(), kWritePieceBytes));
    if (!write_all(fd, piece)) return false;
    bytes = bytes.subspan(piece.size());
    if (piece.size() < kWritePieceBytes) break;  // the fsync at the end writes it
    const off_t end = ::lseek(fd, 0, SEEK_CUR);
    if (end < 0) continue;  // a pipe
    const int failed =
        ::sync_file_range(fd, end - static_cast<off_t>(piece.size()), static_cast<off_t>(piece.size()),
                          SYNC_FILE_RANGE_WAIT_BEFORE | SYNC_FILE_RANGE_WRITE | SYNC_FILE_RANGE_WAIT_AFTER);
    // The kernel reports a failed write only once, so the fsync at the end would miss it. If the file system does not have this
    // call, the fsync writes everything.
    if (failed != 0 && errno != ENOSYS && errno != EINVAL && errno != ESPIPE && errno != EOPNOTSUPP)
      return false;
  }
  return true;
}

}  // namespace fracture
