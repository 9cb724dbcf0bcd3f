// The turns of imports: which import takes a worker next, and which one stands still for others.
#include <algorithm>
#include <chrono>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "server/import_worker/import_pool.hpp"

namespace fracture {

using std::chrono::milliseconds;

namespace {

/// Number of clients that are remembered without an import.
constexpr std::size_t kMostClients = 256;

constexpr auto kAny = [](const auto&, Priority) { return true; };

}  // namespace

/// Keeps an import in the line while it lives. Construction and destruction require the lock.
struct ImportPool::Waiting {
  Waiting(ImportPool& its_pool, Place& its_place)
      : pool(its_pool), place(its_place), id(pool.next_in_line_++), priority(place.priority()) {
    // All arrivals are equal, so that imports do not age: is_others_turn() would stop an aged one at once.
    pool.line_.push(priority, {id, 0, place.input.flow, {}, &place});
  }
  ~Waiting() {
    pool.line_.remove(id);
    pool.free_.notify_all();
  }
  Waiting(const Waiting&) = delete;
  Waiting& operator=(const Waiting&) = delete;
  /// Returns its entry for begin() if it may read now. Requires the lock.
  std::optional<Queue::Next> turn() {
    if (const Priority now = place.priority(); now != priority) {
      pool.line_.move(id, now, place.input.flow);
      priority = now;
    }
    if (pool.counters_.busy >= pool.config_.workers) return std::nullopt;
    const std::vector<Queue::Next> next = pool.line_.candidates(kAny);
    if (next.empty() || next.front().item().place != &place) return std::nullopt;
    return next.front();
  }

  ImportPool& pool;
  Place& place;
  const std::uint64_t id;
  Priority priority;
};

/// Keeps a worker stopped while it lives. Must be constructed and destroyed without the lock.
struct ImportPool::Standing {
  explicit Standing(Place& p) : place(p) {
    place.worker->stop();
    const std::lock_guard lock(place.pool.mutex_);
    place.pool.end(place);
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
  /// Counts the worker as reading again. Requires the lock.
  void reads_again() {
    ++place.pool.counters_.busy;
    --place.pool.counters_.standing;
    reads = true;
  }
  Place& place;
  bool reads = false;
};

void ImportPool::begin(Place& place, const Queue::Next& next) {
  reading_.push_back(&place);  // first, because it may throw
  place.client = next.client;
  place.since = place.charged = std::chrono::steady_clock::now();
  line_.take(next);
}

void ImportPool::charge(Place& place) {
  if (!place.client) return;
  const auto now = std::chrono::steady_clock::now();
  const std::chrono::duration<double> read = now - std::exchange(place.charged, now);
  line_.charge(place.priority(), place.input.flow, read.count());
  double least = place.client->tag;
  for (const Place* const other : reading_) least = std::min(least, other->client->tag);
  line_.advance(least);
}

void ImportPool::end(Place& place) {
  if (!place.client) return;
  charge(place);
  line_.end(*std::exchange(place.client, nullptr));
  std::erase(reading_, &place);
}

void ImportPool::forget_clients() {
  if (line_.empty() && reading_.empty() && counters_.standing == 0)
    line_.idle();
  else if (line_.flows() > kMostClients)
    line_.sweep(kMostClients);
}

bool ImportPool::is_others_turn(const Place& place) {
  if (!place.client || counters_.busy < config_.workers || line_.empty()) return false;
  const Priority priority = place.priority();
  const auto waits = [&place](Priority of) { return !place.client->line(of).empty(); };
  if (priority != Priority::kRealtime && waits(Priority::kRealtime)) return true;
  if (waits(priority) && std::chrono::steady_clock::now() - place.since >= kTurn) return true;
  const std::chrono::duration<double> quantum = kQuantum;
  for (const Queue::Next& next : line_.candidates(kAny))
    if (next.client != place.client) return next.key() + quantum.count() < place.client->key(priority);
  return false;
}

void ImportPool::Place::tell_of_use() {
  if (!execution.turn || !worker) return;
  const std::chrono::nanoseconds now = worker->processor_time();
  const std::chrono::duration<double> used = now - std::exchange(told, now);
  execution.turn->spent_elsewhere(used.count());
}

void ImportPool::Place::give_way() {
  tell_of_use();
  // The report may be the reason to stand back. The computation must know it first, so that the worker is stopped too.
  if (execution.turn) execution.turn->end_where_it_must();
  const bool back = input.stands_back && input.stands_back();
  bool others = false;
  {
    const std::lock_guard lock(pool.mutex_);
    pool.charge(*this);
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
  Waiting waiting(*this, place);
  std::optional<Away> away;
  const auto unwanted = [&execution] {
    return execution.stop.stop_requested() ||
           (execution.deadline && std::chrono::steady_clock::now() > *execution.deadline);
  };
  std::optional<Queue::Next> next;
  while (!(next = waiting.turn()) && !unwanted()) {
    if (!away) away.emplace(execution.turn);
    free_.wait_for(lock, milliseconds(10));
    if (execution.turn) execution.turn->end_where_it_must();
  }
  if (next) begin(place, *next);
  standing.reads_again();
}

std::unique_ptr<WorkerProcess> ImportPool::take(Place& place) {
  const Execution& execution = place.execution;
  std::unique_lock lock(mutex_);
  const std::uint64_t failures = failed_starts_;
  Waiting waiting(*this, place);
  std::optional<Away> away;
  std::optional<Queue::Next> next;
  while (!(next = waiting.turn()) || idle_.empty()) {
    if (!away) away.emplace(execution.turn);
    if (idle_.empty() && reading_or_starting() < config_.workers && starting_ + to_start_ == 0) {
      // No worker will become free, and none could be started, so an error now is better than one at the deadline. Workers
      // could be started when the server began, so memory, processes or descriptors must be missing now.
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
      lock.lock();  // the destructor of `waiting` requires it
      throw;
    }
    lock.lock();
  }
  busy_.reserve(busy_.size() + 1);
  begin(place, *next);  // nothing after this throws
  std::unique_ptr<WorkerProcess> worker = std::move(idle_.back());
  idle_.pop_back();
  busy_.push_back(worker->pid());
  ++counters_.busy;
  place.worker = worker.get();
  place.told = worker->processor_time();
  want_a_spare();
  return worker;
}

}  // namespace fracture
