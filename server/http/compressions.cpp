#include "server/http/compressions.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "server/service/leave_early.hpp"

namespace fracture::http {
namespace {

Error no_memory() {
  return {ErrorCode::kOutOfMemory,
          "The server does not have enough memory to compress this answer at the moment."};
}

/// Returns how long a request waits for the compression of another client.
std::chrono::steady_clock::duration patience_of(const WorkerPool& pool, const Compressions::Wanted& wanted) {
  using Seconds = std::chrono::duration<double>;
  const Seconds least = Compressions::kLeastPatience, most = wanted.longest;
  const Seconds takes = pool.predicted_run(wanted.terms.payer.flow.name, wanted.work.seconds);
  return std::chrono::duration_cast<std::chrono::steady_clock::duration>(
      std::clamp(takes, least, std::max(least, most)));
}

}  // namespace

/// A request that waits. Owned by the flight, and by its task while that is queued or runs.
struct Compressions::Waiter : std::enable_shared_from_this<Waiter> {
  Waiter(Compressions& its_owner, Wanted what)
      : owner(its_owner),
        wanted(std::move(what)),
        patience(patience_of(owner.dispatcher_.pool(), wanted)),
        early(owner.dispatcher_.timer()) {}

  const std::string& client() const { return wanted.terms.payer.flow.name; }
  Priority priority() const { return wanted.terms.priority; }
  Attempts& attempts() const { return seat.flight->common; }
  /// Called by the flight. Its task leaves the queue, because the answer is there.
  void answer(const Expected<Made>& made) {
    over.request_stop();
    std::exchange(wanted.reply, nullptr)(made);  // its attempt may go on, and must not keep the request alive
  }
  /// Ends the wait, unless the request was answered. Its own attempt goes on, because others may wait for it.
  void leave(Error error) {
    if (!owner.flights_.leave(seat)) return;
    over.request_stop();
    std::exchange(wanted.reply, nullptr)(tl::unexpected<Error>(std::move(error)));
  }
  void leave(ErrorCode code) { leave(to_error(Interrupted{code})); }

  Compressions& owner;
  Wanted wanted;                   ///< `reply` is dropped once it was called; the rest does not change
  const Clock::duration patience;  ///< how long it waits for another client's attempt
  Flights::Seat seat;
  std::stop_source over;  ///< it was answered, or has left
  LeaveEarly early;
};

void Compressions::obtain(Wanted wanted) {
  const auto waiter = std::make_shared<Waiter>(*this, std::move(wanted));
  const Flights::Seat seat = flights_.join(
      waiter->wanted.key, [waiter](const Expected<Made>& made, Flights::Role) { waiter->answer(made); });
  try {
    waiter->seat = seat;
    waiter->early.arm(waiter->weak_from_this(), waiter->wanted.terms);
    if (!passes(waiter)) queue(waiter, waiter->wanted.terms.is_computed);
  } catch (...) {
    if (!flights_.leave(seat)) return;  // it was answered
    waiter->over.request_stop();
    throw;
  }
}

void Compressions::queue(const std::shared_ptr<Waiter>& waiter, bool is_computed) {
  Terms terms = waiter->wanted.terms;
  terms.deadline = Clock::now() + waiter->wanted.longest;  // leave() watches for the request's own
  terms.gone = waiter->over.get_token();
  terms.seat.reset();
  terms.needs_seat = false;
  terms.is_computed = is_computed;
  terms.may_wait_for_memory = false;  // the request holds the result, and can get it as it is
  terms.passes = [this, weak = std::weak_ptr(waiter)] {
    const auto waits = weak.lock();
    return !waits || passes(waits);
  };
  ExpectedWork work = waiter->wanted.work;
  {
    // The others will leave the queue, so predictions of the wait must not count them.
    Attempts& attempts = waiter->attempts();
    const std::lock_guard lock(attempts.mutex);
    if (std::exchange(attempts.is_expected, true)) work.seconds = 0;
  }
  auto overload = dispatcher_.run(
      work, terms, [this, waiter](const Execution& execution) { compress(waiter, execution); },
      [waiter](Error error) { waiter->leave(std::move(error)); });
  if (overload) waiter->leave(std::move(*overload));
}

void Compressions::queue_again(const std::weak_ptr<Waiter>& weak) {
  const auto waiter = weak.lock();
  if (!waiter) return;
  try {
    queue(waiter, true);
  } catch (const std::exception&) {
    waiter->leave(no_memory());
  }
}

bool Compressions::has_begun(const Attempts& attempts, const Waiter& waiter) {
  return std::find(attempts.begun.begin(), attempts.begun.end(), waiter.client()) != attempts.begun.end();
}

bool Compressions::is_in_time(const Attempts& attempts, const Waiter& waiter) {
  return Clock::now() < attempts.latest + waiter.patience;
}

bool Compressions::may_begin(const Attempts& attempts, const Waiter& waiter) {
  const auto is_less_urgent = [&](const Attempt& other) { return other.priority > waiter.priority(); };
  return std::all_of(attempts.running.begin(), attempts.running.end(), is_less_urgent) ||
         (!is_in_time(attempts, waiter) && !has_begun(attempts, waiter));
}

bool Compressions::passes(const std::shared_ptr<Waiter>& waiter) {
  Attempts& attempts = waiter->attempts();
  const std::lock_guard lock(attempts.mutex);
  return passes(attempts, waiter);
}

bool Compressions::passes(Attempts& attempts, const std::shared_ptr<Waiter>& waiter) {
  if (attempts.over || waiter->over.stop_requested() || waiter->seat.flight->stop().stop_requested())
    return true;
  if (may_begin(attempts, *waiter)) return false;
  attempts.passed.push_back(waiter);
  if (has_begun(attempts, *waiter)) return true;
  try {
    look_later(waiter, attempts.latest + waiter->patience);
  } catch (const std::exception&) {  // without a timer, nothing would queue it again
    attempts.passed.pop_back();
    throw;
  }
  return true;
}

void Compressions::look_later(const std::shared_ptr<Waiter>& waiter, Clock::time_point when) {
  dispatcher_.timer().at(when, [weak = std::weak_ptr(waiter)] {
    if (const auto waits = weak.lock()) waits->owner.look_again(waits);
  });
}

void Compressions::look_again(const std::shared_ptr<Waiter>& waiter) {
  Attempts& attempts = waiter->attempts();
  {
    const std::lock_guard lock(attempts.mutex);
    const auto at =
        std::find_if(attempts.passed.begin(), attempts.passed.end(), [&](const std::weak_ptr<Waiter>& other) {
          return !other.owner_before(waiter) && !waiter.owner_before(other);
        });
    if (at == attempts.passed.end()) return;   // it was queued again, or the answer is there
    if (has_begun(attempts, *waiter)) return;  // it is queued again when all attempts have failed
    if (is_in_time(attempts, *waiter)) try {   // yet another client has begun
        return look_later(waiter, attempts.latest + waiter->patience);
      } catch (const std::exception&) {  // it does not wait for that one
      }
    attempts.passed.erase(at);
  }
  queue_again(waiter);
}

void Compressions::compress(const std::shared_ptr<Waiter>& waiter, const Execution& execution) {
  Attempts& attempts = waiter->attempts();
  const Attempt mine{waiter->client(), waiter->priority()};
  Expected<Made> made = tl::unexpected<Error>(no_memory());
  try {
    const std::lock_guard lock(attempts.mutex);
    if (passes(attempts, waiter)) return;  // another one began just now
    const bool others_wait_for_it = attempts.running.empty() || !is_in_time(attempts, *waiter);
    attempts.begun.push_back(mine.client);
    attempts.running.push_back(mine);
    if (others_wait_for_it) attempts.latest = Clock::now();
  } catch (const std::exception&) {
    return waiter->leave(made.error());
  }
  try {
    made = attempt(*waiter, execution);
  } catch (const std::exception& e) {
    spdlog::warn("compressing an answer failed: {}", e.what());
  }
  ended(waiter, mine, made);
}

Expected<Compressions::Made> Compressions::attempt(const Waiter& waiter, const Execution& execution) try {
  const std::stop_source& done = waiter.attempts().done;
  const std::stop_callback all_left(waiter.seat.flight->stop(),
                                    [source = done]() mutable { source.request_stop(); });
  Execution shared = execution;  // if this request leaves, it goes on for the others
  shared.stop = done.get_token();
  WorkerPool::stands_still_while_wanted(shared);
  return waiter.wanted.make(shared);
} catch (const Interrupted& interrupted) {
  return tl::unexpected<Error>(to_error(interrupted));
}

void Compressions::ended(const std::shared_ptr<Waiter>& waiter, const Attempt& mine,
                         const Expected<Made>& made) {
  Attempts& attempts = waiter->attempts();
  std::vector<std::weak_ptr<Waiter>> passed;
  {
    const std::lock_guard lock(attempts.mutex);
    attempts.running.erase(std::find(attempts.running.begin(), attempts.running.end(), mine));
    if (attempts.over && !made) return;  // the attempt that succeeded answers all requests
    attempts.over = attempts.over || made;
    if (attempts.over || attempts.running.empty()) passed.swap(attempts.passed);
  }
  if (made) {
    attempts.done.request_stop();
    return flights_.land(waiter->seat.flight, made);
  }
  // First, because the next attempt may succeed at once, and would answer this request, too.
  try {
    waiter->leave(made.error());
  } catch (const std::exception&) {  // no memory even to say so: it waits until its deadline
  }
  for (const auto& other : passed) try {
      queue_again(other);
    } catch (const std::exception&) {  // as above
    }
}

}  // namespace fracture::http
