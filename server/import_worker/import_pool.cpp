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
  if (!idle_.empty() || starting_ + to_start_ > 0 || reading_or_starting() >= config_.workers) return;
  ++to_start_;
  supervisor_.notify_one();
}

int ImportPool::reading_or_starting() const {
  return counters_.workers - counters_.standing + starting_ + to_start_;
}

/// In the line, for as long as this lives. Made and destroyed with the lock.
struct ImportPool::Waiting {
  Waiting(ImportPool& p, Place& place) : pool(p), at(p.line_.insert(p.line_.end(), &place)) {}
  ~Waiting() {
    pool.line_.erase(at);
    pool.free_.notify_all();
  }
  Waiting(const Waiting&) = delete;
  Waiting& operator=(const Waiting&) = delete;
  ImportPool& pool;
  const std::list<Place*>::iterator at;
};

/// Stopped, for as long as this lives. Made and destroyed without the lock.
struct ImportPool::Standing {
  explicit Standing(Place& p) : place(p) {
    place.worker->stop();
    const std::lock_guard lock(place.pool.mutex_);
    --place.pool.counters_.busy;
    ++place.pool.counters_.standing;
    place.pool.free_.notify_all();
  }
  ~Standing() {
    if (!reads) {
      const std::lock_guard lock(place.pool.mutex_);
      reads_again();
    }
    place.worker->go_on();
  }
  Standing(const Standing&) = delete;
  Standing& operator=(const Standing&) = delete;
  /// With the lock.
  void reads_again() {
    ++place.pool.counters_.busy;
    --place.pool.counters_.standing;
    place.since = std::chrono::steady_clock::now();
    reads = true;
  }
  Place& place;
  bool reads = false;
};

bool ImportPool::is_next(const Place& place) const {
  if (counters_.busy >= config_.workers) return false;
  const bool urgent = place.is_urgent();
  bool before = true;
  for (const Place* const other : line_) {
    if (other == &place)
      before = false;
    else if (before ? other->is_urgent() || !urgent : other->is_urgent() && !urgent)
      return false;
  }
  return true;
}

bool ImportPool::is_others_turn(const Place& place) const {
  if (line_.empty() || counters_.busy < config_.workers) return false;
  const bool urgent = place.is_urgent(), over = std::chrono::steady_clock::now() - place.since >= kTurn;
  return std::any_of(line_.begin(), line_.end(), [&](const Place* other) {
    const bool more = other->is_urgent();
    return more == urgent ? over : more;
  });
}

void ImportPool::Place::tell_of_use() {
  if (!execution.turn || !worker) return;
  const std::chrono::nanoseconds now = worker->processor_time();
  const std::chrono::duration<double> used = now - std::exchange(told, now);
  execution.turn->spent_elsewhere(used.count());
}

void ImportPool::Place::give_way() {
  tell_of_use();
  const bool back = stands_back && stands_back();
  bool others = false;
  {
    const std::lock_guard lock(pool.mutex_);
    others = pool.is_others_turn(*this);
  }
  if (back || others)
    pool.stand_still(*this, back);
  else if (execution.turn)
    execution.turn->give_way();
}

void ImportPool::stand_still(Place& place, bool back) {
  const Execution& execution = place.execution;
  Standing standing(place);
  if (back) execution.turn->give_way();
  std::unique_lock lock(mutex_);
  const Waiting waiting(*this, place);
  std::optional<Away> away;
  const auto unwanted = [&execution] {
    return execution.stop.stop_requested() ||
           (execution.deadline && std::chrono::steady_clock::now() > *execution.deadline);
  };
  while (!is_next(place) && !unwanted()) {
    if (!away) away.emplace(execution.turn);
    free_.wait_for(lock, milliseconds(10));
    if (execution.turn) execution.turn->end_where_it_must();
  }
  standing.reads_again();
}

std::unique_ptr<WorkerProcess> ImportPool::take(Place& place) {
  const Execution& execution = place.execution;
  std::unique_lock lock(mutex_);
  const std::uint64_t failures = failed_starts_;
  const Waiting waiting(*this, place);
  std::optional<Away> away;
  while (idle_.empty() || !is_next(place)) {
    if (!away) away.emplace(execution.turn);
    if (idle_.empty() && reading_or_starting() < config_.workers && starting_ + to_start_ == 0) {
      // Nobody will come free, and none could be started: better an error now than at the deadline.
      // They could be when the server started: what is missing now are memory, processes or descriptors.
      if (failed_starts_ > failures && counters_.workers == 0) {
        ++counters_.no_room;
        throw Interrupted(no_room_to_read(start_error_));
      }
      ++to_start_;
      supervisor_.notify_one();
    }
    free_.wait_for(lock, milliseconds(10));
    lock.unlock();
    try {
      execution.poll();
    } catch (...) {
      lock.lock();  // who waits is counted under it
      throw;
    }
    lock.lock();
  }
  std::unique_ptr<WorkerProcess> worker = std::move(idle_.back());
  idle_.pop_back();
  busy_.push_back(worker->pid());
  ++counters_.busy;
  place.worker = worker.get();
  place.since = std::chrono::steady_clock::now();
  place.told = worker->processor_time();
  want_a_spare();
  return worker;
}

/// For the next file.
void ImportPool::keep(std::unique_ptr<WorkerProcess> worker) {
  const std::lock_guard lock(mutex_);
  --counters_.busy;
  idle_.push_back(std::move(worker));
  free_.notify_all();
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
  free_.notify_all();
}

Expected<Mesh> ImportPool::import(std::span<const std::byte> mesh, MeshFormat format,
                                  std::span<const ImportFile> files, const ImportLimits& limits,
                                  const Execution& execution, std::string_view digest,
                                  const StandsBack& stands_back) {
  execution.poll();
  std::uint64_t most = config_.worker.memory_bytes;
  if (execution.allowance) {
    const std::uint64_t share = execution.allowance->limit() / kReserved;
    most = most > 0 ? std::min(most, share) : share;
  }
  Input input{mesh, format, files, std::string(digest), {}, stands_back};
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
  Place place(*this, execution, input.stands_back);
  Execution reading = execution;
  reading.turn = &place;
  std::unique_ptr<WorkerProcess> taken = take(place);
  WorkerProcess& worker = *taken;
  const pid_t pid = worker.pid();
  const auto start = ImportMemo::Clock::now();
  bool reusable = false;
  const auto finish = [&](std::uint64_t ImportCounters::*ended) {
    place.tell_of_use();
    {
      const std::lock_guard lock(mutex_);
      if (ended) ++(counters_.*ended);
      std::erase(busy_, pid);
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
    throw std::runtime_error("there is no program " + program +
                             ", which reads files for this one: install both");
  return program;
}

}  // namespace fracture
