// What the system should know of memory in use: that nobody reads its content any more, or that all of it will be written.
#pragma once

#include <cstddef>

namespace fracture {

/// The system may take the whole pages of these bytes back: what they hold is lost, and reading them gives zeros or what
/// was there. The memory stays allocated. A function of performance alone: where the system offers no such thing,
/// nothing happens.
void forget_pages(void* memory, std::size_t bytes);

/// For who reads memory once from the beginning to the end: what is behind the reader goes as forget_pages() has it, piece by
/// piece, where there are 32 MiB or more. Borrowed.
class PagesBehind {
 public:
  PagesBehind(void* memory, std::size_t bytes) : memory_(static_cast<char*>(memory)), bytes_(bytes) {}
  /// The first `read` bytes are not needed any more; what is beyond the end is not there.
  void through(std::size_t read);

 private:
  char* memory_;
  std::size_t bytes_, forgotten_ = 0;
};

/// What malloc gives is fresh from the system each time where it is at least so large: glibc maps it by itself (the largest
/// M_MMAP_THRESHOLD there is), jemalloc gives it back when it is freed (oversize_threshold, common/allocator).
inline constexpr std::size_t kAlwaysFresh = std::size_t{32} << 20;

/// The system hands out the whole pages of these bytes now, all at once, which takes half as long as a fault for each when
/// it is first written. For memory that is fresh and will be used; what it holds stays. A function of performance alone, as
/// forget_pages().
void populate_pages(void* memory, std::size_t bytes);

}  // namespace fracture
