// The pool's worker processes. One thread starts them before they are needed, replaces them and ends them.
#include <unistd.h>

#include <algorithm>
#include <climits>
#include <iterator>
#include <stdexcept>
#include <utility>

#include "server/import_worker/import_pool.hpp"

namespace fracture {

ImportPool::ImportPool(ImportPoolConfig config)
    : config_(std::move(config)), thread_([this] { supervise(); }) {
  std::unique_lock lock(mutex_);
  free_.wait(lock, [this] { return !idle_.empty() || failed_starts_ > 0; });
  if (!idle_.empty()) return;
  stopping_ = true;
  supervisor_.notify_all();
  lock.unlock();
  thread_.join();
  throw std::runtime_error(start_error_);
}

ImportPool::~ImportPool() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  supervisor_.notify_all();
  thread_.join();
}

/// Runs on the supervisor's thread, the only one that starts and ends processes.
void ImportPool::supervise() {
  std::unique_lock lock(mutex_);
  for (;;) {
    supervisor_.wait(lock, [this] { return stopping_ || to_start_ > 0 || !retired_.empty(); });
    std::vector<std::unique_ptr<WorkerProcess>> dead = std::move(retired_);
    retired_.clear();
    if (stopping_) {
      std::move(idle_.begin(), idle_.end(), std::back_inserter(dead));
      idle_.clear();
      counters_.workers = 0;
      zygote_pid_ = -1;
      lock.unlock();
      zygote_.reset();
      return;  // the destructor of `dead` ends the processes
    }
    const bool start = to_start_ > 0;
    to_start_ -= start;
    starting_ += start;
    lock.unlock();
    std::unique_ptr<WorkerProcess> born;
    std::string error;
    if (start) {
      try {
        born = fork_worker();
      } catch (const std::exception& e) {
        error = e.what();
      }
    }
    dead.clear();
    lock.lock();
    starting_ -= start;
    if (born) {
      if (counters_.started++ == 0) hello_ = born->hello();
      ++counters_.workers;
      idle_.push_back(std::move(born));
    } else if (start) {
      ++failed_starts_;
      start_error_ = error;
    }
    if (start) free_.notify_all();
  }
}

/// Forks a worker. If that fails because the zygote has ended (the system was short of memory), starts a new zygote.
std::unique_ptr<WorkerProcess> ImportPool::fork_worker() {
  bool renew = false;
  {
    const std::lock_guard lock(mutex_);
    renew = std::exchange(renew_zygote_, false);
  }
  if (zygote_ && (renew || zygote_->forks() >= config_.max_forks)) zygote_.reset();
  if (zygote_) {
    try {
      return std::make_unique<WorkerProcess>(*zygote_, config_.worker);
    } catch (const std::exception&) {
      zygote_.reset();
    }
  }
  try {
    return first_worker_of_a_new_zygote();
  } catch (const std::exception&) {
    // If the system is short of memory, it ends these processes first, possibly while they start. So this tries once more.
    return first_worker_of_a_new_zygote();
  }
}

std::unique_ptr<WorkerProcess> ImportPool::first_worker_of_a_new_zygote() {
  zygote_.reset();
  zygote_ = std::make_unique<ZygoteProcess>(config_.worker);
  {
    const std::lock_guard lock(mutex_);
    ++counters_.zygotes;
    zygote_pid_ = zygote_->pid();
    zygote_hello_ = zygote_->hello();
  }
  return std::make_unique<WorkerProcess>(*zygote_, config_.worker);
}

/// Requests a spare worker, so that the next import need not wait for a fork. Requires the lock.
void ImportPool::want_a_spare() {
  if (!idle_.empty() || starting_ + to_start_ > 0 || reading_or_starting() >= config_.workers) return;
  ++to_start_;
  supervisor_.notify_one();
}

int ImportPool::reading_or_starting() const {
  return counters_.workers - counters_.standing + starting_ + to_start_;
}

/// Keeps a worker for the next file.
void ImportPool::keep(std::unique_ptr<WorkerProcess> worker) {
  const std::lock_guard lock(mutex_);
  --counters_.busy;
  idle_.push_back(std::move(worker));
  free_.notify_all();
}

/// Retires a worker that has read its file. The supervisor ends it and replaces it at once.
void ImportPool::bury(std::unique_ptr<WorkerProcess> worker) {
  const std::lock_guard lock(mutex_);
  --counters_.busy;
  --counters_.workers;
  renew_zygote_ = renew_zygote_ || worker->death() == WorkerDeath::kCrash;
  retired_.push_back(std::move(worker));
  want_a_spare();
  supervisor_.notify_one();
  free_.notify_all();
}

ImportCounters ImportPool::counters() const {
  const std::lock_guard lock(mutex_);
  ImportCounters now = counters_;
  now.starting = starting_ + to_start_;
  return now;
}

pid_t ImportPool::zygote_pid() const {
  const std::lock_guard lock(mutex_);
  return zygote_pid_;
}

ZygoteHello ImportPool::zygote_hello() const {
  const std::lock_guard lock(mutex_);
  return zygote_hello_;
}

WorkerHello ImportPool::hello() const {
  const std::lock_guard lock(mutex_);
  return hello_;
}

std::vector<pid_t> ImportPool::pids() const {
  const std::lock_guard lock(mutex_);
  std::vector<pid_t> pids = busy_;
  for (const auto& worker : idle_) pids.push_back(worker->pid());
  return pids;
}

std::string import_worker_beside_this_program() {
  char path[PATH_MAX];
  const ssize_t length = ::readlink("/proc/self/exe", path, sizeof path - 1);
  std::string program(path, static_cast<std::size_t>(std::max<ssize_t>(length, 0)));
  program.replace(program.rfind('/') + 1, std::string::npos, "fracture-import");
  if (::access(program.c_str(), X_OK) != 0)
    throw std::runtime_error("the program " + program +
                             ", which reads mesh files, is missing: install it with this program");
  return program;
}

}  // namespace fracture
