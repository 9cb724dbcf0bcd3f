// A thread that calls functions at given times, for deadlines of waiting requests and for the expiry of stored data.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <future>
#include <map>
#include <mutex>
#include <thread>
#include <utility>

namespace fracture {

/// Thread-safe. Functions must be quick and must not throw. The destructor drops pending calls.
class Timer {
 public:
  using Clock = std::chrono::steady_clock;
  using Id = std::pair<Clock::time_point, std::uint64_t>;

  Timer() : thread_([this] { run(); }) {}
  ~Timer() {
    {
      const std::lock_guard lock(mutex_);
      stopping_ = true;
    }
    wake_.notify_one();
    thread_.join();
  }
  Timer(const Timer&) = delete;
  Timer& operator=(const Timer&) = delete;

  Id at(Clock::time_point when, std::function<void()> call) {
    Id id;
    bool earliest;
    {
      const std::lock_guard lock(mutex_);
      id = {when, next_++};
      earliest = calls_.empty() || id < calls_.begin()->first;
      calls_.emplace(id, std::move(call));
    }
    if (earliest) wake_.notify_one();
    return id;
  }

  /// Cancels a call, unless it has already begun.
  void cancel(const Id& id) {
    std::function<void()> dropped;
    const std::lock_guard lock(mutex_);
    const auto found = calls_.find(id);
    if (found == calls_.end()) return;
    dropped = std::move(found->second);
    calls_.erase(found);
  }

  /// Drops every pending call.
  void clear() {
    std::map<Id, std::function<void()>> dropped;
    const std::lock_guard lock(mutex_);
    dropped.swap(calls_);
  }

  /// Waits until all calls that have already begun are over.
  void flush() {
    std::promise<void> done;
    at(Clock::time_point::min(), [&done] { done.set_value(); });
    done.get_future().wait();
  }

 private:
  void run() {
    std::unique_lock lock(mutex_);
    while (!stopping_) {
      if (calls_.empty()) {
        wake_.wait(lock);
      } else if (const Clock::time_point when = calls_.begin()->first.first; Clock::now() < when) {
        wake_.wait_until(lock, when);
      } else {
        std::function<void()> call = std::move(calls_.begin()->second);
        calls_.erase(calls_.begin());
        lock.unlock();
        try {
          call();
        } catch (...) {
          // The client was already told (Api::answering), or there was not even enough memory to do so. Other deadlines
          // must still be kept.
        }
        call = nullptr;
        lock.lock();
      }
    }
  }

  std::mutex mutex_;
  std::condition_variable wake_;
  std::map<Id, std::function<void()>> calls_;
  std::uint64_t next_ = 0;
  bool stopping_ = false;
  std::thread thread_;  // last: it uses everything above
};

}  // namespace fracture
