#include "common/base/execution.hpp"

#include <algorithm>
#include <exception>
#include <mutex>

#include "common/base/helper_threads.hpp"

namespace fracture {

void parallel_for(const Execution& execution, std::size_t count, std::size_t grain,
                  const std::function<void(std::size_t, std::size_t)>& body) {
  if (count == 0) return;
  grain = std::max<std::size_t>(1, grain);
  const std::size_t blocks = (count + grain - 1) / grain;
  const std::size_t workers = std::min<std::size_t>(std::max(1, execution.threads), blocks);

  StageProgress::Loop progress(execution.within, blocks);
  std::atomic<std::size_t> next{0};
  std::atomic<bool> failed{false};
  std::mutex mutex;
  std::exception_ptr first;
  const auto work = [&] {
    try {
      for (std::size_t b; !failed.load(std::memory_order_relaxed) && (b = next.fetch_add(1)) < blocks;) {
        execution.poll();
        progress.at(b);
        body(b * grain, std::min(count, (b + 1) * grain));
      }
    } catch (...) {
      failed = true;
      const std::lock_guard lock(mutex);
      if (!first) first = std::current_exception();
    }
  };
  base_detail::run_with_helpers(workers - 1, work);
  if (first) std::rethrow_exception(first);
}

}  // namespace fracture
