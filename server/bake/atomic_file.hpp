// Files that are written completely or not at all.
#pragma once

#include <cstddef>
#include <span>
#include <stop_token>
#include <string>

namespace fracture::bake {

/// Writes a file that appears at its path only when it is complete. The bytes go to a temporary file next to
/// the target (".<name>.part", overwritten by the next attempt), which is flushed to the disk and then
/// renamed over the target. Without commit(), the temporary file is deleted. All functions return false and
/// set errno on failure.
class AtomicFile {
 public:
  bool open(const std::string& path);
  bool append(std::span<const std::byte> bytes);
  bool commit();

  AtomicFile() = default;
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

 private:
  void discard();

  std::string path_, temporary_;
  int fd_ = -1;
};

/// Writes a file with AtomicFile from bytes in memory. Returns false and sets errno on failure.
bool write_file(const std::string& path, std::span<const std::byte> bytes);

/// Writes all bytes; returns false and sets errno on failure. errno is EPIPE if the reader has closed the
/// pipe (SIGPIPE is ignored here), and ECANCELED if a stop was requested while waiting for the reader.
bool write_standard_output(std::span<const std::byte> bytes, const std::stop_token& stop);

/// Creates the parent folders of a path. Returns false and sets errno on failure.
bool make_folders_of(const std::string& path);

}  // namespace fracture::bake
