// Where a program's memory comes from: jemalloc (J. Evans, A Scalable Concurrent malloc(3) Implementation for FreeBSD,
// BSDCan 2006), in large pages (DECISION.md). For programs: to link fracture::allocator is to use it. The other folders are
// libraries and leave the choice to whoever links them. Under a sanitizer the allocator is the sanitizer's, and these
// functions do nothing.
#pragma once

#include <cstdint>

namespace fracture {

/// Bytes that were freed and that this process keeps for what comes next.
std::uint64_t free_memory();

/// Gives all of that back to the system, but for the few small blocks that each thread keeps at hand.
void return_free_memory();

/// Gives back what nobody has asked for again within seconds. Cheap; in a process that waits nobody else does it.
void return_old_free_memory();

}  // namespace fracture
