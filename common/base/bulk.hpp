// Work on many bytes at once, and threads that must not do it.
//
// A thread that serves many clients (an io thread of the server) keeps all of them waiting while it works for one.
// Whatever hashes, inflates, compresses, parses or sorts says here how much it does. If such a thread has a limit, its
// turns that do more are counted: each of them is a fault of the program, whatever the client has sent.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

namespace fracture {

/// What a thread may do in one turn; shared by the threads that it holds for, and outlives them.
struct BulkLimit {
  explicit BulkLimit(std::size_t bytes) : most(bytes) {}
  const std::size_t most;                  ///< bytes in one turn
  std::atomic<std::uint64_t> exceeded{0};  ///< turns that did more
};

namespace base_detail {
struct BulkOfThread {
  BulkLimit* limit = nullptr;
  std::size_t bytes = 0;
};
inline thread_local BulkOfThread bulk_of_this_thread;
}  // namespace base_detail

/// From now on the limit holds for the calling thread; null: none does.
inline void limit_bulk(BulkLimit* limit) { base_detail::bulk_of_this_thread = {limit, 0}; }
/// The calling thread turns to something else.
inline void begin_bulk_turn() { base_detail::bulk_of_this_thread.bytes = 0; }

/// So many bytes are worked on; or what takes as long as hashing so many.
inline void count_bulk(std::size_t bytes) {
  base_detail::BulkOfThread& mine = base_detail::bulk_of_this_thread;
  if (!mine.limit) return;
  const bool within = mine.bytes <= mine.limit->most;
  mine.bytes += bytes;
  if (within && mine.bytes > mine.limit->most) mine.limit->exceeded.fetch_add(1);
}

}  // namespace fracture
