// Memory that two processes share by a descriptor: a memfd, or an unlinked file if memfd is not available.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/descriptor.hpp"
#include "common/base/execution.hpp"

namespace fracture {

/// Creates empty shared memory. Throws std::system_error.
Descriptor make_shared_memory(const char* name);

/// Makes the memory immutable, for all processes. Returns false if a process may still write through a mapping, or if the
/// memory does not support seals.
bool seal(int fd);

/// The first `size` bytes of shared memory, read-only, which no process can change after they were checked. The memory is
/// sealed and mapped. If it cannot be sealed (because a process may still write through a mapping) or mapped, the bytes are
/// copied, with polls. good() is false if the memory is shorter. Throws Interrupted.
class SealedBytes {
 public:
  static SealedBytes take(int fd, std::uint64_t size, const Execution& execution = kUninterrupted);
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
