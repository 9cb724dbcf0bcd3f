// How this process's allocator treats small blocks.
#pragma once

namespace fracture {

/// For the first line of main(): a small block goes back to its neighbours when it is freed. By default glibc
/// puts blocks up to 128 bytes aside ("fast bins") until something large is allocated or freed, and then
/// works off all of them at once: 70 ms after two million nodes, in the middle of whatever asked for the
/// large one, where nothing polls.
void join_small_blocks_when_freed();

}  // namespace fracture
