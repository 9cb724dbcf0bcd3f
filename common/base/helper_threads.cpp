#include "common/base/helper_threads.hpp"

#include <time.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <system_error>
#include <thread>

#include "common/base/processor_time.hpp"
#include "common/base/scratch.hpp"

namespace fracture::base_detail {
namespace {

/// A parallel loop of a caller; it is on the caller's stack.
struct Loop {
  const std::function<void()>& work;
  std::size_t wanted;                  ///< helpers that may still join
  std::atomic<std::size_t> active{0};  ///< helpers inside the loop: changed under the lock, read without it
  double seconds = 0;                  ///< processor time that helpers have spent in the loop
  std::condition_variable done{};
};

/// Time that a thread spins before it blocks, both for a loop to begin and for a loop to end. The loops of
/// one fracture follow each other closely, and waking a blocked thread takes as long as a small loop runs.
constexpr std::chrono::microseconds kPatience{200};

/// Spins until is_so() or until kPatience is over.
template <class Condition>
void stay_awake(const Condition& is_so) {
  const auto end = std::chrono::steady_clock::now() + kPatience;
  while (!is_so() && std::chrono::steady_clock::now() < end) std::this_thread::yield();
}

/// Processor time that helpers have spent in the loops of this thread.
thread_local double helped_seconds = 0;

/// Whether some helper keeps more scratch than it may keep after a computation.
std::atomic<bool> some_scratch_is_large{false};

class HelperThreads {
 public:
  void run(std::size_t helpers, const std::function<void()>& work) {
    Loop loop{work, helpers};
    {
      const std::lock_guard lock(mutex_);
      loops_.push_back(&loop);
      wanted_ += helpers;
      any_ = true;
      start_missing();
    }
    if (helpers == 1)
      work_is_there_.notify_one();
    else
      work_is_there_.notify_all();
    work();
    std::unique_lock lock(mutex_);
    if (loop.wanted > 0) {
      wanted_ -= loop.wanted;
      loops_.erase(std::find(loops_.begin(), loops_.end(), &loop));
      any_ = !loops_.empty();
    }
    if (loop.active > 0) {
      lock.unlock();
      stay_awake([&] { return loop.active.load(std::memory_order_relaxed) == 0; });
      lock.lock();
    }
    loop.done.wait(lock, [&] { return loop.active == 0; });
    helped_seconds += loop.seconds;
  }

  /// Idle helpers trim their scratch immediately, and the others when they become idle.
  void trim() {
    const std::lock_guard lock(mutex_);
    ++trims_;
    work_is_there_.notify_all();
  }

 private:
  /// Starts helpers until as many are idle as are wanted. If the system refuses a thread, loops are only
  /// slower.
  void start_missing() {
    while (idle_ < wanted_ && threads_ < kMost) {
      try {
        std::thread([this] { help(); }).detach();
      } catch (const std::system_error&) {
        return;
      }
      ++threads_;
      ++idle_;
    }
  }

  [[noreturn]] void help() {
    std::uint64_t trims = 0;  // number of trims that this thread has done
    std::unique_lock lock(mutex_);
    for (;;) {
      if (loops_.empty() && trims != trims_) {
        trims = trims_;
        lock.unlock();
        trim_own_scratch();
        lock.lock();
        continue;
      }
      if (loops_.empty()) {
        lock.unlock();
        stay_awake([&] { return any_.load(std::memory_order_relaxed); });
        lock.lock();
      }
      work_is_there_.wait(lock, [&] { return !loops_.empty() || trims != trims_; });
      if (loops_.empty()) continue;
      Loop& loop = *loops_.front();
      --wanted_;
      if (--loop.wanted == 0) loops_.pop_front();
      any_ = !loops_.empty();
      ++loop.active;
      --idle_;
      lock.unlock();
      const double before = processor_seconds_of_this_thread();
      loop.work();
      const double spent = processor_seconds_of_this_thread() - before;
      if (scratch_of_this_thread() > kScratchPerThread) some_scratch_is_large = true;
      lock.lock();
      ++idle_;
      loop.seconds += spent;
      if (--loop.active == 0) loop.done.notify_one();
    }
  }

  static constexpr std::size_t kMost = 512;

  std::mutex mutex_;
  std::condition_variable work_is_there_;
  std::deque<Loop*> loops_;  ///< loops that want more helpers, oldest first
  std::size_t wanted_ = 0;   ///< helpers wanted by all loops together
  std::size_t idle_ = 0, threads_ = 0;
  std::uint64_t trims_ = 0;       ///< number of trims requested so far
  std::atomic<bool> any_{false};  ///< loops_ is not empty; spinning helpers read it without the lock
};

HelperThreads& helper_threads() {
  // Never destroyed, because its threads use it until the process ends.
  static HelperThreads& threads = *new HelperThreads;
  return threads;
}

}  // namespace

void run_with_helpers(std::size_t helpers, const std::function<void()>& work) {
  if (helpers == 0) return work();
  helper_threads().run(helpers, work);
}

void trim_helpers() {
  if (some_scratch_is_large.exchange(false)) helper_threads().trim();
}

}  // namespace fracture::base_detail

namespace fracture {

double processor_seconds_of_this_thread() {
  timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec) +
         base_detail::helped_seconds;
}

}  // namespace fracture
