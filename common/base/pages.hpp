// Tells the system that allocated memory has no useful contents any more, or that all of it will soon be
// written.
#pragma once

#include <cstddef>

namespace fracture {

/// Lets the system reclaim the whole pages within these bytes. Their contents are lost: reading them gives
/// zeros or the old contents. The memory stays allocated. Affects performance only, and does nothing if the
/// system does not support it.
void forget_pages(void* memory, std::size_t bytes);

/// Forgets memory behind a reader that reads it once from beginning to end. Works in pieces, as in
/// forget_pages(), and only if there are 32 MiB or more. The memory is borrowed.
class PagesBehind {
 public:
  PagesBehind(void* memory, std::size_t bytes) : memory_(static_cast<char*>(memory)), bytes_(bytes) {}
  /// Forgets the first `read` bytes, or all bytes if there are fewer.
  void through(std::size_t read);

 private:
  char* memory_;
  std::size_t bytes_, forgotten_ = 0;
};

/// Minimum size at which malloc always returns fresh memory from the system. glibc maps such blocks
/// separately (it is the largest possible M_MMAP_THRESHOLD), and jemalloc returns them when they are freed
/// (oversize_threshold, common/allocator).
inline constexpr std::size_t kAlwaysFresh = std::size_t{32} << 20;

/// Asks the system to provide the whole pages of these bytes now, all at once. This takes half as long as one
/// page fault per page at the first write. For fresh memory that will be used; its contents do not change.
/// Like forget_pages(), affects performance only.
void populate_pages(void* memory, std::size_t bytes);

}  // namespace fracture
