// Files that are there whole or not at all.
#pragma once

#include <cstddef>
#include <span>
#include <stop_token>
#include <string>

namespace fracture::bake {

/// A file that grows unseen and then is there at once: a temporary one beside the target (".<name>.part", used again by
/// the next try), flushed to the disk, then renamed over it. Gone, if it was not committed. All of them are false with
/// errno set.
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

/// The same of bytes that are there. False with errno set.
bool write_file(const std::string& path, std::span<const std::byte> bytes);

/// All of it, or false with errno set: EPIPE where nobody reads any more, which is no signal here; ECANCELED
/// where the stop came while nobody read.
bool write_standard_output(std::span<const std::byte> bytes, const std::stop_token& stop);

/// Makes the folders that the path lies in. False with errno set.
bool make_folders_of(const std::string& path);

}  // namespace fracture::bake
