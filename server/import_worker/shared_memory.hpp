// Memory that two processes see, by descriptor: a memfd, or where the kernel has none an unlinked file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/descriptor.hpp"

namespace fracture {

/// Empty shared memory. Throws std::system_error.
Descriptor make_shared_memory(const char* name);

/// Nobody can change or resize it any more. False where somebody may still write through a mapping, or where
/// the kernel has no seals.
bool seal(int fd);

/// The first `size` bytes, read-only: mapped where nobody can change them any more (the memory is sealed,
/// which fails while somebody else may still write through a mapping), else copied, as it is where there is no room for a
/// mapping: so what was checked is what is used. Nothing where the memory is shorter.
class SealedBytes {
 public:
  static SealedBytes take(int fd, std::uint64_t size);
  SealedBytes() = default;
  SealedBytes(SealedBytes&& other) noexcept;
  SealedBytes& operator=(SealedBytes&&) = delete;
  ~SealedBytes();

  bool good() const { return good_; }
  std::span<const std::byte> view() const { return view_; }

 private:
  bool good_ = false;
  void* mapping_ = nullptr;
  std::vector<std::byte> copy_;
  std::span<const std::byte> view_;
};

}  // namespace fracture
