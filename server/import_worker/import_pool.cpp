#include "server/import_worker/import_pool.hpp"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <climits>
#include <iterator>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "common/import/picture_heads.hpp"

namespace fracture {

using std::chrono::milliseconds;

namespace {

/// What a reader takes for a file of these bytes, arrays in double and the answer included (measured over the
/// test meshes: 3 to 9 times), and for the largest of its pictures, one of which is decoded at a time
/// (surface_color/pixels.cpp); and how much more it is given where that was too little.
constexpr std::uint64_t kLeastMemory = 8u << 20, kMemoryPerByte = 10, kMore = 4;
constexpr std::uint64_t kMemoryPerPixel = 17, kMostPixels = 1u << 24;
/// The answer is in shared memory when the worker has freed its own; then the server takes it apart.
constexpr std::uint64_t kReserved = 2;
/// A shorter try is repeated at no greater cost.
constexpr milliseconds kWorthRemembering{50};

std::uint64_t expected_memory(std::span<const std::byte> mesh, std::span<const ImportFile> files) {
  std::uint64_t pixels = largest_picture(mesh);
  for (const ImportFile& file : files) pixels = std::max(pixels, largest_picture(file.bytes));
  return kLeastMemory + kMemoryPerByte * input_bytes(mesh, files) +
         kMemoryPerPixel * std::min(pixels, kMostPixels);
}

bool lacked_memory(const Expected<Mesh>& result) {
  return !result && result.error().code == ErrorCode::kImporterLimit &&
         result.error().extra->value("limit", "") == "memory";
}

/// 0 is no limit.
std::uint64_t most_of(std::uint64_t memory_bytes) {
  return memory_bytes > 0 ? memory_bytes : ImportMemo::kAnyMemory;
}

/// Is it of no use to try? What was not done in a time is not done in an eighth more: tries of one length are
/// never quite of one length.
bool refuses(const ImportMemo::Known& known, std::uint64_t memory_bytes, const Execution& execution) {
  if (known.error && most_of(memory_bytes) <= known.with_bytes) return true;
  if (known.needs_more_than.count() == 0 || !execution.deadline) return false;
  return *execution.deadline - ImportMemo::Clock::now() < known.needs_more_than / 8 * 9;
}

}  // namespace

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
      zygote_pid_ = -1;
      lock.unlock();
      zygote_.reset();
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

/// A zygote that has ended (the system was short of memory) is found out by its fork: then from a new one.
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
    // These are the first that the system ends when it is short of memory: also while they start.
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

/// So that the next import does not wait for a fork. Called with the lock.
void ImportPool::want_a_spare() {
  if (!idle_.empty() || starting_ + to_start_ > 0 || counters_.workers >= config_.workers) return;
  ++to_start_;
  supervisor_.notify_one();
}

/// A file may be read for a minute, which those who are in a hurry have not got: like their computations
/// (worker_pool.hpp), one import of theirs begins beside as many as may be read. Called with the lock.
int ImportPool::most_workers(bool urgent) const {
  const auto is_unhurried = [](const Busy& busy) { return !busy.place->is_urgent(); };
  return config_.workers + (urgent && std::any_of(busy_.begin(), busy_.end(), is_unhurried) ? 1 : 0);
}

/// Whoever took it was urgent. Where it is not any more, it ends for who is. Called with the lock.
void ImportPool::free_the_extra_place() {
  for (const Busy& busy : busy_)
    if (busy.place->extra && !busy.place->is_urgent()) busy.place->must_end = true;
}

void ImportPool::Place::give_way() {
  if (must_end)
    throw Interrupted(
        Error{.code = ErrorCode::kOverloaded,
              .detail = "The import process that read this file is needed for more urgent work. Ask again.",
              .retry_after = std::chrono::seconds(1)});
  if (of) of->give_way();
}

std::unique_ptr<WorkerProcess> ImportPool::take(Place& place, const Execution& execution) {
  bool urgent = place.is_urgent();
  std::unique_lock lock(mutex_);
  const std::uint64_t failures = failed_starts_;
  struct Waiting {
    int& count;
    explicit Waiting(int& c) : count(c) { ++count; }
    ~Waiting() { --count; }
  };
  const Waiting waiting(waiting_);
  while (idle_.empty() || counters_.busy >= most_workers(urgent)) {
    const int alive = counters_.workers + starting_ + to_start_;
    if (idle_.empty() && alive < most_workers(urgent) && starting_ + to_start_ < waiting_) {
      // Nobody will come free, and none could be started: better an error now than at the deadline.
      // They could be when the server started: what is missing now are memory, processes or descriptors.
      if (failed_starts_ > failures && counters_.workers == 0) {
        ++counters_.no_room;
        throw Interrupted(no_room_to_read(start_error_));
      }
      ++to_start_;
      supervisor_.notify_one();
    }
    if (urgent && counters_.busy > config_.workers) free_the_extra_place();
    free_.wait_for(lock, milliseconds(10));
    lock.unlock();
    try {
      execution.poll();
      urgent = place.is_urgent();
    } catch (...) {
      lock.lock();  // who waits is counted under it
      throw;
    }
    lock.lock();
  }
  place.extra = counters_.busy >= config_.workers;
  busy_.push_back({idle_.back()->pid(), &place});
  std::unique_ptr<WorkerProcess> worker = std::move(idle_.back());
  idle_.pop_back();
  ++counters_.busy;
  want_a_spare();
  return worker;
}

/// For the next file.
void ImportPool::keep(std::unique_ptr<WorkerProcess> worker) {
  const std::lock_guard lock(mutex_);
  --counters_.busy;
  idle_.push_back(std::move(worker));
  free_.notify_one();
}

/// It has read its file. Ended by the supervisor, and replaced at once.
void ImportPool::bury(std::unique_ptr<WorkerProcess> worker) {
  const std::lock_guard lock(mutex_);
  --counters_.busy;
  --counters_.workers;
  renew_zygote_ = renew_zygote_ || worker->death() == WorkerDeath::kCrash;
  retired_.push_back(std::move(worker));
  want_a_spare();
  supervisor_.notify_one();
  free_.notify_one();
}

Expected<Mesh> ImportPool::import(std::span<const std::byte> mesh, MeshFormat format,
                                  std::span<const ImportFile> files, const ImportLimits& limits,
                                  const Execution& execution, std::string_view digest) {
  execution.poll();
  std::uint64_t most = config_.worker.memory_bytes;
  if (execution.allowance) {
    const std::uint64_t share = execution.allowance->limit() / kReserved;
    most = most > 0 ? std::min(most, share) : share;
  }
  Input input{mesh, format, files, std::string(digest), {}};
  input.name = input.digest + "." + extension_of(format);
  if (const auto known = memo_.find(input.name); known && refuses(*known, most, execution)) {
    const std::lock_guard lock(mutex_);
    ++counters_.remembered;
    if (known->error && most_of(most) <= known->with_bytes) return tl::unexpected<Error>(*known->error);
    throw Interrupted{ErrorCode::kDeadlineExceeded};
  }
  Try attempt;
  attempt.memory_bytes = std::min(most, expected_memory(mesh, files));
  for (;;) {
    const Allowance::Temporary held(execution.allowance);
    execution.made(Product::kImportBytes, kReserved * attempt.memory_bytes);
    attempt.last = attempt.memory_bytes >= most;
    if (std::optional<Expected<Mesh>> result = import_within(attempt, input, limits, execution))
      return std::move(*result);
    if (!attempt.was_killed) attempt.memory_bytes = std::min(most, kMore * attempt.memory_bytes);
    attempt.was_killed_before = attempt.was_killed_before || attempt.was_killed;
  }
}

std::optional<Expected<Mesh>> ImportPool::import_within(Try& attempt, const Input& input,
                                                        const ImportLimits& limits,
                                                        const Execution& execution) {
  execution.poll();
  Place place(execution.turn);
  Execution reading = execution;
  reading.turn = &place;
  std::unique_ptr<WorkerProcess> taken = take(place, execution);
  WorkerProcess& worker = *taken;
  const pid_t pid = worker.pid();
  const auto start = ImportMemo::Clock::now();
  const std::chrono::duration<double> used_before = worker.processor_time();
  bool reusable = false;
  const auto finish = [&](std::uint64_t ImportCounters::*ended) {
    if (execution.turn) {
      const std::chrono::duration<double> used = worker.processor_time();
      execution.turn->spent_elsewhere((used - used_before).count());
    }
    {
      const std::lock_guard lock(mutex_);
      if (ended) ++(counters_.*ended);
      std::erase_if(busy_, [pid](const Busy& busy) { return busy.pid == pid; });
    }
    reusable ? keep(std::move(taken)) : bury(std::move(taken));
  };
  try {
    Expected<Mesh> result = worker.import(input.mesh, input.format, input.files, input.digest, limits,
                                          reading, attempt.memory_bytes);
    const WorkerDeath death = worker.death();
    reusable =
        death == WorkerDeath::kNone && !lacked_memory(result) && worker.files() < config_.files_per_worker;
    // What an earlier file has left behind in its process is not this one's doing.
    const bool had_less = lacked_memory(result) && worker.had_less();
    attempt.was_killed = death == WorkerDeath::kKilled || death == WorkerDeath::kNoRoom ||
                         ((death == WorkerDeath::kCrash || had_less) && worker.files() > 1);
    if ((lacked_memory(result) && !attempt.last) || (attempt.was_killed && !attempt.was_killed_before)) {
      finish(nullptr);
      return std::nullopt;
    }
    if (had_less)
      result = tl::unexpected<Error>(no_room_to_read(
          "this machine allows it less memory than one import may have (--import-memory, ulimit -v)"));
    const bool over_limit = !result && result.error().code == ErrorCode::kImporterLimit;
    const bool no_room = !result && result.error().code == ErrorCode::kOverloaded;
    if (lacked_memory(result) && attempt.memory_bytes > 0)
      result.error().detail =
          "The importer needed more than the " + std::to_string(attempt.memory_bytes) +
          " bytes of memory that it may have for this file: --import-memory, and half of what one "
          "computation may have of --max-working. Send a smaller mesh, or raise them.";
    if (lacked_memory(result))
      memo_.add(input.name, result.error(), most_of(attempt.memory_bytes));
    else if (over_limit || death == WorkerDeath::kCrash)
      memo_.add(input.name, result.error());
    if (result)
      finish(&ImportCounters::imported);
    else if (no_room)
      finish(&ImportCounters::no_room);
    else if (over_limit)
      finish(&ImportCounters::limited);
    else
      finish(death == WorkerDeath::kNone ? &ImportCounters::refused : &ImportCounters::crashed);
    return result;
  } catch (const Interrupted& interrupted) {
    // What counts is the processor's time: where others had it, more of the same time might have done.
    const auto given = ImportMemo::Clock::now() - start, used = worker.processor_time();
    finish(&ImportCounters::interrupted);  // first: the memo may find no memory
    if (interrupted.code == ErrorCode::kDeadlineExceeded && used >= kWorthRemembering)
      memo_.add(input.name, used >= given / 4 * 3 ? given : used);
    throw;
  } catch (const std::system_error& e) {  // a descriptor, or shared memory
    finish(&ImportCounters::no_room);
    return tl::unexpected<Error>(no_room_to_read(e.what()));
  } catch (...) {  // the server lacks memory: what the worker is at is not known
    finish(&ImportCounters::no_room);
    throw;
  }
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
  std::vector<pid_t> pids;
  for (const Busy& busy : busy_) pids.push_back(busy.pid);
  for (const auto& worker : idle_) pids.push_back(worker->pid());
  return pids;
}

std::string import_worker_beside_this_program() {
  char path[PATH_MAX];
  const ssize_t length = ::readlink("/proc/self/exe", path, sizeof path - 1);
  std::string program(path, static_cast<std::size_t>(std::max<ssize_t>(length, 0)));
  program.replace(program.rfind('/') + 1, std::string::npos, "fracture-import");
  if (::access(program.c_str(), X_OK) != 0)
    throw std::runtime_error("there is no program " + program +
                             ", which reads files for this one: install both");
  return program;
}

}  // namespace fracture
