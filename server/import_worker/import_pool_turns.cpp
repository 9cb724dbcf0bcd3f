// The turns of imports: which import takes a worker next, and which one stands still for others.
#include <algorithm>
#include <chrono>
#include <utility>

#include "server/import_worker/import_pool.hpp"

namespace fracture {

using std::chrono::milliseconds;

/// Keeps an import in the line while it lives. Construction and destruction require the lock.
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

/// Keeps a worker stopped while it lives. Must be constructed and destroyed without the lock.
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
  /// Counts the worker as reading again. Requires the lock.
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

}  // namespace fracture
