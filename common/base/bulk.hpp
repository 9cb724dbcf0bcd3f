// Counts operations on large blocks of bytes, to find threads that perform them but must not.
//
// A thread that serves many clients (an io thread of the server) keeps all of them waiting while it works for
// one. Code that hashes, inflates, compresses, parses or sorts reports here how many bytes it processes. If
// such a thread has a limit, its turns that exceed the limit are counted. Each of them is a bug in the
// program, whatever the client has sent.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

namespace fracture {

/// Maximum work in one turn of a thread. Shared by the threads that it applies to; must outlive them.
struct BulkLimit {
  explicit BulkLimit(std::size_t bytes) : most(bytes) {}
  const std::size_t most;                  ///< bytes in one turn
  std::atomic<std::uint64_t> exceeded{0};  ///< number of turns that did more
};

namespace base_detail {
struct BulkOfThread {
  BulkLimit* limit = nullptr;
  std::size_t bytes = 0;
};
inline thread_local BulkOfThread bulk_of_this_thread;
}  // namespace base_detail

/// Applies the limit to the calling thread from now on; null removes it.
inline void limit_bulk(BulkLimit* limit) { base_detail::bulk_of_this_thread = {limit, 0}; }
/// Starts a new turn of the calling thread.
inline void begin_bulk_turn() { base_detail::bulk_of_this_thread.bytes = 0; }

/// Counts bytes that the calling thread processes, or work that takes as long as hashing this many bytes.
inline void count_bulk(std::size_t bytes) {
  base_detail::BulkOfThread& mine = base_detail::bulk_of_this_thread;
  if (!mine.limit) return;
  const bool within = mine.bytes <= mine.limit->most;
  mine.bytes += bytes;
  if (within && mine.bytes > mine.limit->most) mine.limit->exceeded.fetch_add(1);
}

}  // namespace fracture
