// What the system should know of memory in use: that nobody reads its content any more, or that all of it will be written.
#pragma once

#include <cstddef>

namespace fracture {

/// The system may take the whole pages of these bytes back: what they hold is lost, and reading them gives zeros or what
/// was there. The memory stays allocated. A function of performance alone: where the system offers no such thing,
/// nothing happens.
void forget_pages(void* memory, std::size_t bytes);

/// What malloc gives is fresh from the system each time where it is at least so large: glibc maps it by itself (the largest
/// M_MMAP_THRESHOLD there is), jemalloc gives back what had 8 MiB when it is freed.
inline constexpr std::size_t kAlwaysFresh = std::size_t{32} << 20;

/// The system hands out the whole pages of these bytes now, all at once, which takes half as long as a fault for each when
/// it is first written. For memory that is fresh and will be used; what it holds stays. A function of performance alone, as
/// forget_pages().
void populate_pages(void* memory, std::size_t bytes);

}  // namespace fracture
