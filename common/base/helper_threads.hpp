// Threads that wait for work between two parallel loops: starting one costs more than many a loop takes, and
// a thread that stays keeps what the stages hold per thread (scratch memory) warm.
#pragma once

#include <cstddef>
#include <functional>

namespace fracture::base_detail {

/// Calls `work` on this thread and on up to `helpers` more, and returns when all that began it have ended.
/// How many helpers come is not promised: one that is not free by the time this thread is through is not
/// waited for. `work` must not throw, and may itself run others. The threads are the process's, and are
/// started as they are first needed.
void run_with_helpers(std::size_t helpers, const std::function<void()>& work);

/// Makes the helpers trim their scratch (scratch.hpp) when they are idle; nothing where none has much.
void trim_helpers();
/// Of the calling thread.
void trim_own_scratch();

}  // namespace fracture::base_detail
