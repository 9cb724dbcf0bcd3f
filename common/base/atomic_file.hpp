// Files that are written completely or not at all (POSIX).
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <span>
#include <string>

namespace fracture {

struct AtomicFileOptions {
  std::string temporary{};  ///< path on the same file system; empty: ".<name>.part" next to the file
  mode_t mode = 0666;       ///< permissions of a new file, from which the umask takes some away
  /// Whether commit() waits until the disk has the bytes. Without this, a power failure may leave an empty file.
  bool flushed = true;
};

/// Writes a file that appears at its path only when it is complete. The bytes go to a temporary file (overwritten
/// by the next attempt), which is then renamed over the target. Without commit(), the temporary file is deleted. All
/// functions return false and set errno on failure.
class AtomicFile {
 public:
  bool open(const std::string& path, const AtomicFileOptions& options = {});
  bool append(std::span<const std::byte> bytes);
  /// For large files: other writers of the same disk do not wait for them (paced_write.hpp).
  bool append_paced(std::span<const std::byte> bytes);
  bool commit();

  AtomicFile() = default;
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

 private:
  void discard();

  std::string path_, temporary_;
  bool flushed_ = true;
  int fd_ = -1;
};

/// Writes a file with AtomicFile from bytes in memory. Returns false and sets errno on failure.
bool write_atomically(const std::string& path, std::span<const std::byte> bytes,
                      const AtomicFileOptions& options = {});

}  // namespace fracture
