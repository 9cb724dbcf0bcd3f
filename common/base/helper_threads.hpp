// Threads that wait for work between parallel loops. Starting a thread costs more than many loops take, and a
// thread that stays keeps its scratch memory warm.
#pragma once

#include <cstddef>
#include <functional>

namespace fracture::base_detail {

/// Calls `work` on this thread and on up to `helpers` more threads, and returns when every call has ended.
/// The number of helpers is not guaranteed: if a helper is not free before this thread finishes, it is not
/// waited for. `work` must not throw, and may itself call this function. The threads belong to the process
/// and are started when they are first needed.
void run_with_helpers(std::size_t helpers, const std::function<void()>& work);

/// Makes the helpers trim their scratch (scratch.hpp) when they are idle. Does nothing if no helper has much.
void trim_helpers();
/// Trims the scratch of the calling thread.
void trim_own_scratch();

}  // namespace fracture::base_detail
