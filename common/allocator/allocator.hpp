// The programs' memory allocator: jemalloc (J. Evans, A Scalable Concurrent malloc(3) Implementation for
// FreeBSD, BSDCan 2006), with large pages (DECISION.md). Linking fracture::allocator selects it. Only
// programs do so; libraries leave the choice to the program. Under a sanitizer, the sanitizer's allocator is
// used, and these functions do nothing.
#pragma once

#include <cstdint>

namespace fracture {

/// Bytes of freed memory that this process keeps for reuse.
std::uint64_t free_memory();

/// Returns all freed memory to the system, except for the few small blocks that each thread keeps.
void return_free_memory();

/// Returns memory that was freed seconds ago and not reused. Cheap. An idle process must call it, because
/// jemalloc only does this during other calls.
void return_old_free_memory();

}  // namespace fracture
