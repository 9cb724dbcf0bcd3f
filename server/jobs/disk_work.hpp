// What blocks on a disk, on a few threads of its own. Each client has a line of calls, which are made one after the other
// in the order in which they were asked for. Whose disk has been used least goes next (service/fair_queue.hpp), and a
// client has one thread at most: what it writes keeps others from a thread only if as many clients write at once as
// there may be threads.
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

/// Thread-safe. Starts threads when they are needed. What throws is logged, and the next call is made.
class DiskWork {
 public:
  /// Disks do little more at the same time.
  static constexpr std::size_t kMostThreads = 8;

  DiskWork() = default;
  /// Does all that was asked for.
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
      calls_.push(kClass, {next_, 0, {.name = client}, std::chrono::steady_clock::now(), std::move(call)});
      unfinished_.insert(next_++);
      if (calls_.candidates(may_begin).size() > free_) start_thread();
    }
    changed_.notify_all();
  }
  /// Returns when all that was asked for before is done.
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
  static constexpr Priority kClass = Priority::kBatch;  // there is one

  static bool may_begin(const Queue::Client& client, Priority) { return client.running == 0; }
  void start_thread() {
    if (threads_.size() == kMostThreads) return;
    try {
      threads_.emplace_back([this] { work(); });
      ++free_;
    } catch (const std::exception&) {  // those that there are do it
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
        spdlog::error("work for the disk was given up: {}", e.what());
      }
      call.call = nullptr;  // what it held is freed without the lock
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
