// One thread that does what blocks on a disk, in the order in which it was asked to.
#pragma once

#include <spdlog/spdlog.h>

#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <future>
#include <mutex>
#include <thread>
#include <utility>

namespace fracture {

/// Thread-safe. Starts its thread with the first call. What throws is logged, and the next call is made.
class DiskThread {
 public:
  DiskThread() = default;
  /// Does all that was asked for.
  ~DiskThread() {
    {
      const std::lock_guard lock(mutex_);
      stopping_ = true;
    }
    wake_.notify_all();
    if (thread_.joinable()) thread_.join();
  }
  DiskThread(const DiskThread&) = delete;
  DiskThread& operator=(const DiskThread&) = delete;

  void run(std::function<void()> call) {
    {
      const std::lock_guard lock(mutex_);
      if (!thread_.joinable()) thread_ = std::thread([this] { work(); });
      calls_.push_back(std::move(call));
    }
    wake_.notify_all();
  }
  /// Returns when all that was asked for before is done.
  void flush() {
    std::promise<void> done;
    run([&done] { done.set_value(); });
    done.get_future().wait();
  }

 private:
  void work() {
    std::unique_lock lock(mutex_);
    for (;;) {
      wake_.wait(lock, [this] { return stopping_ || !calls_.empty(); });
      if (calls_.empty()) return;
      std::function<void()> call = std::move(calls_.front());
      calls_.pop_front();
      lock.unlock();
      try {
        call();
      } catch (const std::exception& e) {
        spdlog::error("work for the disk was given up: {}", e.what());
      }
      call = nullptr;  // what it held is freed without the lock
      lock.lock();
    }
  }

  std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<std::function<void()>> calls_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace fracture
