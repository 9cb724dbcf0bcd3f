// Runs blocking disk operations on a few threads of their own. Each client has a queue of calls, which run
// one after the other in the order in which they were added. The client that has used the disk least comes
// next (service/fair_queue.hpp), and each client uses at most one thread. So one client's writes cannot
// occupy all threads.
#pragma once

#include <spdlog/spdlog.h>

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "server/service/fair_queue.hpp"

namespace fracture {

/// Thread-safe. Starts threads when they are needed. Exceptions from calls are logged, and the next call
/// runs.
class DiskWork {
 public:
  /// Disks gain little from more parallel operations.
  static constexpr std::size_t kMostThreads = 8;

  DiskWork() = default;
  /// Runs all remaining calls first.
  ~DiskWork() {
    {
      const std::lock_guard lock(mutex_);
      stopping_ = true;
    }
    changed_.notify_all();
    for (std::thread& thread : threads_) thread.join();
  }
  DiskWork(const DiskWork&) = delete;
  DiskWork& operator=(const DiskWork&) = delete;

  void run(const std::string& client, std::function<void()> call) {
    {
      const std::lock_guard lock(mutex_);
      if (threads_.empty()) start_thread();  // if this throws, nothing is queued
      const auto added = unfinished_.insert(next_).first;
      try {
        calls_.push(kClass, {next_, 0, {.name = client}, std::chrono::steady_clock::now(), std::move(call)});
      } catch (...) {
        unfinished_.erase(added);
        throw;
      }
      ++next_;
      if (calls_.candidates(may_begin).size() > free_) start_thread();
    }
    changed_.notify_all();
  }
  /// Returns when all calls that were added before have ended.
  void flush() {
    std::unique_lock lock(mutex_);
    const std::uint64_t end = next_;
    changed_.wait(lock, [&] { return unfinished_.empty() || *unfinished_.begin() >= end; });
  }

 private:
  struct Call {
    std::uint64_t id;
    double cost;
    Flow flow;
    std::chrono::steady_clock::time_point arrival;
    std::function<void()> call;
  };
  using Queue = FairQueue<Call>;
  static constexpr Priority kClass = Priority::kBatch;  // only one class is used

  static bool may_begin(const Queue::Client& client, Priority) { return client.running == 0; }
  void start_thread() {
    if (threads_.size() == kMostThreads) return;
    try {
      threads_.emplace_back([this] { work(); });
      ++free_;
    } catch (const std::exception&) {  // the existing threads do the work
      if (threads_.empty()) throw;
    }
  }
  void work() {
    std::unique_lock lock(mutex_);
    for (;;) {
      const std::vector<Queue::Next> next = calls_.candidates(may_begin);
      if (next.empty() && stopping_ && calls_.empty()) return;
      if (next.empty()) {
        changed_.wait(lock);
        continue;
      }
      Queue::Client& client = *next.front().client;
      Call call = calls_.take(next.front());
      --free_;
      lock.unlock();
      const auto begin = std::chrono::steady_clock::now();
      try {
        call.call();
      } catch (const std::exception& e) {
        spdlog::error("work for the disk failed and was abandoned: {}", e.what());
      }
      call.call = nullptr;  // destroys what the call captured, without the lock
      const std::chrono::duration<double> used = std::chrono::steady_clock::now() - begin;
      lock.lock();
      ++free_;
      calls_.charge(kClass, call.flow, used.count());
      calls_.advance(client.tag);
      calls_.end(client);
      unfinished_.erase(call.id);
      if (unfinished_.empty()) calls_.idle();
      changed_.notify_all();
    }
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  Queue calls_;
  std::set<std::uint64_t> unfinished_;
  std::uint64_t next_ = 0;
  std::size_t free_ = 0;
  bool stopping_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace fracture
