#include "server/import_worker/import_pool.hpp"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <climits>
#include <iterator>
#include <stdexcept>
#include <utility>

namespace fracture {

using std::chrono::milliseconds;

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

/// The only thread that starts and ends processes.
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
      lock.unlock();
      return;  // `dead` is buried here
    }
    const bool start = to_start_ > 0;
    to_start_ -= start;
    starting_ += start;
    lock.unlock();
    std::unique_ptr<WorkerProcess> born;
    std::string error;
    if (start) {
      try {
        born = std::make_unique<WorkerProcess>(config_.worker);
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

std::unique_ptr<WorkerProcess> ImportPool::take(const Execution& execution) {
  std::unique_lock lock(mutex_);
  const std::uint64_t failures = failed_starts_;
  struct Waiting {
    int& count;
    explicit Waiting(int& c) : count(c) { ++count; }
    ~Waiting() { --count; }
  };
  const Waiting waiting(waiting_);
  while (idle_.empty()) {
    const int alive = counters_.workers + starting_ + to_start_;
    if (alive < config_.workers && starting_ + to_start_ < waiting_) {
      // Nobody will come free, and none could be started: better an error now than at the deadline.
      if (failed_starts_ > failures && counters_.workers == 0) throw std::runtime_error(start_error_);
      ++to_start_;
      supervisor_.notify_one();
    }
    free_.wait_for(lock, milliseconds(10));
    lock.unlock();
    execution.poll();
    lock.lock();
  }
  std::unique_ptr<WorkerProcess> worker = std::move(idle_.back());  // the one whose pages are warm
  idle_.pop_back();
  ++counters_.busy;
  busy_.push_back(worker->pid());
  return worker;
}

void ImportPool::give_back(std::unique_ptr<WorkerProcess> worker, bool healthy) {
  const bool worn = healthy && (worker->imports() >= config_.max_imports ||
                                worker->resident_bytes() > config_.max_resident_bytes);
  const std::lock_guard lock(mutex_);
  --counters_.busy;
  if (healthy && !worn) {
    idle_.push_back(std::move(worker));
  } else {
    --counters_.workers;
    counters_.recycled += worn;
    retired_.push_back(std::move(worker));
    // Replaced at once, so that the next import does not pay for its start.
    ++to_start_;
    supervisor_.notify_one();
  }
  free_.notify_one();
}

namespace {

/// What a reader takes for a file of these bytes, arrays in double and the answer included (measured over the
/// test meshes: 3 to 9 times), and how much more it is given where that was too little.
constexpr std::uint64_t kLeastMemory = 8u << 20, kMemoryPerByte = 10, kMore = 4;
/// The answer is in shared memory when the worker has freed its own; then the server takes it apart.
constexpr std::uint64_t kReserved = 2;

bool lacked_memory(const Expected<Mesh>& result) {
  return !result && result.error().code == ErrorCode::kImporterLimit &&
         result.error().extra.value("limit", "") == "memory";
}

}  // namespace

Expected<Mesh> ImportPool::import(std::span<const std::byte> mesh, MeshFormat format,
                                  std::span<const ImportFile> files, const ImportLimits& limits,
                                  const Execution& execution) {
  std::uint64_t most = config_.worker.memory_bytes;
  if (execution.allowance) {
    const std::uint64_t share = execution.allowance->limit() / kReserved;
    most = most > 0 ? std::min(most, share) : share;
  }
  std::uint64_t size = mesh.size();
  for (const ImportFile& file : files) size += file.bytes.size();
  for (std::uint64_t memory = std::min(most, kLeastMemory + kMemoryPerByte * size);;
       memory = std::min(most, kMore * memory)) {
    const Allowance::Temporary held(execution.allowance);
    execution.made(Product::kImportBytes, kReserved * memory);
    const bool last = memory >= most;
    Expected<Mesh> result = import_within(memory, last, mesh, format, files, limits, execution);
    if (last || !lacked_memory(result)) return result;
  }
}

Expected<Mesh> ImportPool::import_within(std::uint64_t memory_bytes, bool last,
                                         std::span<const std::byte> mesh, MeshFormat format,
                                         std::span<const ImportFile> files, const ImportLimits& limits,
                                         const Execution& execution) {
  execution.poll();
  std::unique_ptr<WorkerProcess> worker = take(execution);
  const pid_t pid = worker->pid();
  const auto finish = [&](std::uint64_t ImportCounters::*ended, bool healthy) {
    {
      const std::lock_guard lock(mutex_);
      if (ended) ++(counters_.*ended);
      busy_.erase(std::find(busy_.begin(), busy_.end(), pid));
    }
    give_back(std::move(worker), healthy);
  };
  try {
    Expected<Mesh> result = worker->import(mesh, format, files, limits, execution, memory_bytes);
    const bool healthy = worker->death() == WorkerDeath::kNone;
    if (lacked_memory(result) && !last)
      finish(nullptr, healthy);  // it goes on
    else if (result)
      finish(&ImportCounters::imported, healthy);
    else if (result.error().code == ErrorCode::kImporterLimit)
      finish(&ImportCounters::limited, healthy);
    else
      finish(healthy ? &ImportCounters::refused : &ImportCounters::crashed, healthy);
    return result;
  } catch (const Interrupted&) {
    finish(&ImportCounters::interrupted, false);
    throw;
  } catch (...) {  // the server lacks memory or descriptors: what the worker is at is not known
    finish(&ImportCounters::limited, false);
    throw;
  }
}

ImportCounters ImportPool::counters() const {
  const std::lock_guard lock(mutex_);
  ImportCounters now = counters_;
  now.starting = starting_ + to_start_;
  return now;
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
  if (length <= 0) return {};
  std::string program(path, static_cast<std::size_t>(length));
  program.replace(program.rfind('/') + 1, std::string::npos, "fracture-import");
  return ::access(program.c_str(), X_OK) == 0 ? program : std::string();
}

}  // namespace fracture
