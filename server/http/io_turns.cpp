#include "server/http/io_turns.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <utility>

namespace fracture::http {
namespace {

constexpr Priority kClass = Priority::kBatch;  // only one class is used
/// Maximum number of clients without a waiting request whose used time is remembered.
constexpr std::size_t kMostClients = 256;
/// One request may begin for this number of turns of the threads, if these were of other kinds.
constexpr std::uint64_t kTurnsPerRequest = 8;

/// The current turn of this thread.
struct Turn {
  bool handles = false;  // a request
  bool paid = false;     // by `flow`
  Flow flow;
};
thread_local Turn this_turn;

void charge_turn_to(const Flow& flow) {
  this_turn.paid = true;
  this_turn.flow.name = flow.name;
  this_turn.flow.weight = flow.weight;
}

}  // namespace

bool IoTurns::begin(const Flow& flow) {
  charge_turn_to(flow);
  if (this_turn.handles) return true;
  {
    const std::lock_guard lock(mutex_);
    if (waiting_ > 0 || taken_ >= threads_) return false;
    ++taken_;
  }
  this_turn.handles = true;
  free_later();
  return true;
}

IoTurns::Place IoTurns::wait(const Flow& flow, Call wake) {
  auto waiting = std::make_shared<Waiting>(Waiting{std::move(wake), {flow.name, flow.weight}});
  std::uint64_t id = 0;
  {
    const std::lock_guard lock(mutex_);
    id = next_++;
    queue_.push(kClass, {id, 0, {flow.name, flow.weight}, std::chrono::steady_clock::now(), waiting});
    ++waiting_;
  }
  Place place(*this, id, std::move(waiting));
  grant();  // a thread may have become free since begin()
  return place;
}

void IoTurns::end_turn(double seconds) {
  this_turn.handles = false;
  ended_.fetch_add(1, std::memory_order_relaxed);
  if (!std::exchange(this_turn.paid, false)) return;
  const std::lock_guard lock(mutex_);
  queue_.charge(kClass, this_turn.flow, seconds);
  if (queue_.flows() > kMostClients + waiting_) queue_.sweep(kMostClients);
}

void IoTurns::free_later() noexcept {
  const std::uint64_t since = ended_.load(std::memory_order_relaxed);
  try {
    later_([this, since] { free_one(since); });
  } catch (const std::exception& e) {  // no memory: the thread is freed now, because waiting requests need it
    spdlog::error("the turn of a request ended early: {}", e.what());
    try {
      free_one(since);
    } catch (const std::exception&) {  // the next request to arrive grants the turns
    }
  }
}

void IoTurns::free_one(std::uint64_t since) {
  {
    const std::lock_guard lock(mutex_);
    --taken_;
    const std::uint64_t turns = ended_.load(std::memory_order_relaxed) - since;
    most_ = std::max(threads_, static_cast<std::size_t>(turns / kTurnsPerRequest));
    if (taken_ == 0 && waiting_ == 0) return queue_.idle();
  }
  grant();
}

void IoTurns::grant() {
  for (;;) {
    std::shared_ptr<Waiting> next;
    {
      const std::lock_guard lock(mutex_);
      if (stopped_ || waiting_ == 0 || taken_ >= most_) return;
      const auto candidates = queue_.candidates([](const auto&, Priority) { return true; });
      auto& client = *candidates.front().client;
      queue_.advance(client.tag);
      next = queue_.take(candidates.front()).waiting;
      queue_.end(client);
      --waiting_;
      next->granted = true;
      ++taken_;
    }
    try {
      next->wake();
    } catch (const std::exception& e) {  // its deadline wakes it; the others go on
      spdlog::error("a request was not told about its turn: {}", e.what());
      const std::lock_guard lock(mutex_);
      if (next->used) continue;  // something else woke it
      next->granted = false;
      --taken_;
    }
  }
}

void IoTurns::stop() {
  const std::lock_guard lock(mutex_);
  stopped_ = true;
}

std::size_t IoTurns::waiting() const {
  const std::lock_guard lock(mutex_);
  return waiting_;
}

IoTurns::Place::~Place() {
  if (!waiting_) return;
  {
    const std::lock_guard lock(turns_->mutex_);
    if (!waiting_->granted) {
      if (turns_->queue_.remove(id_)) --turns_->waiting_;
      return;
    }
    if (turns_->stopped_) return;
    waiting_->used = true;
  }
  turns_->free_later();
}

bool IoTurns::Place::granted() const {
  const std::lock_guard lock(turns_->mutex_);
  return waiting_ && waiting_->granted;
}

bool IoTurns::Place::take() {
  {
    const std::lock_guard lock(turns_->mutex_);
    if (!waiting_ || !waiting_->granted) return false;
    waiting_->used = true;
  }
  charge_turn_to(waiting_->flow);
  waiting_.reset();
  this_turn.handles = true;
  turns_->free_later();
  return true;
}

}  // namespace fracture::http
