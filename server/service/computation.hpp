// Private to dispatcher*.cpp: one who waits, what is computed, and what that takes.
#pragma once

#include <atomic>
#include <chrono>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <new>
#include <optional>
#include <stop_token>
#include <utility>

#include "common/base/processor_time.hpp"
#include "server/service/background_memory.hpp"
#include "server/service/computation_allowance.hpp"
#include "server/service/dispatcher.hpp"
#include "server/service/leave_early.hpp"

namespace fracture {

/// Everything that a step may throw, as the error that it is for the client.
template <class Work>
auto guarded(Work work) -> decltype(work()) {
  try {
    return work();
  } catch (const Interrupted& interrupted) {
    return tl::unexpected<Error>(to_error(interrupted));
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::kOutOfMemory, "There is not enough memory for this request now.");
  } catch (const std::exception& e) {
    return fail(ErrorCode::kInternal, e.what());
  } catch (...) {
    return fail(ErrorCode::kInternal, "an exception of unknown type");
  }
}

/// The error as all clients of a computation get it. If one of them holds its share, that is a lack of room to the others.
inline Error told_to_all(Error error, const Urgency& urgency) {
  if (error.code != ErrorCode::kOverShare || !urgency.is_of_several()) return error;
  error.code = ErrorCode::kOverloaded;
  error.detail =
      "Another client is waiting for the same computation, so its memory counts towards that client's "
      "share. That client's other computations are using too much memory now.";
  return error;
}

/// What computing has taken so far.
struct Spent {
  double busy_seconds = 0;       ///< from begin to end, but what it stood still for others
  double processor_seconds = 0;  ///< of all threads, and of the processes that worked for it
};

/// Adds what is spent from its construction to its destruction, on one thread of the pool.
class Meter {
 public:
  explicit Meter(Spent& spent) : spent_(spent) {}
  ~Meter() {
    const auto since = [](double now, double before) { return now - before; };
    const std::chrono::duration<double> all = std::chrono::steady_clock::now() - start_;
    spent_.busy_seconds += all.count() - since(WorkerPool::paused_seconds(), paused_);
    spent_.processor_seconds += since(processor_seconds_of_this_thread(), processor_) +
                                since(WorkerPool::seconds_elsewhere(), elsewhere_);
  }
  Meter(const Meter&) = delete;
  Meter& operator=(const Meter&) = delete;

 private:
  Spent& spent_;
  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  const double processor_ = processor_seconds_of_this_thread(), paused_ = WorkerPool::paused_seconds(),
               elsewhere_ = WorkerPool::seconds_elsewhere();
};

/// One who waits in a flight: its reply, and the two ways to leave early. Lives in the flight's waiter.
template <class Flights, class Value>
struct Dispatcher::Waiting : std::enable_shared_from_this<Waiting<Flights, Value>> {
  Waiting(Dispatcher& d, Flights& f, std::function<void(Expected<Value>)> r)
      : dispatcher(d), flights(f), reply(std::move(r)), early(d.timer_) {}

  /// After join(). `take_part` does what else there is: it has the value computed, or hurries who computes it.
  /// What that throws is an error like any other: for all who wait where nobody computes. May leave, and so
  /// reply, before it returns.
  template <class TakePart>
  void enter(const typename Flights::Seat& taken, const Terms& terms, TakePart take_part) {
    bool computed = taken.role != Flights::Role::kLeader;
    const Expected<bool> entered = guarded([&]() -> Expected<bool> {
      take_part();
      computed = true;
      seat = taken;
      priority = terms.priority;
      early.arm(this->weak_from_this(), terms);
      return true;
    });
    if (entered) return;
    const tl::unexpected<Error> why(entered.error());
    if (!computed)
      flights.land(taken.flight, why);
    else if (flights.leave(taken))
      answer(why);
  }

  void leave(ErrorCode code) {
    if (!flights.leave(seat)) return;
    Urgency& urgency = urgency_of(seat.flight->common);
    urgency.leave(dispatcher.pool_, priority);
    dispatcher.withdraw_if_abandoned(*seat.flight, urgency);
    ++dispatcher.abandoned_;
    answer(tl::unexpected<Error>(to_error(Interrupted{code})));
  }

  /// Its place among the computations of its name is free before the client can ask again.
  void answer(Expected<Value> value) {
    share = {};
    reply(std::move(value));
  }

  static Urgency& urgency_of(Urgency& all) { return all; }
  static Urgency& urgency_of(Common& all) { return all.urgency; }

  Dispatcher& dispatcher;
  Flights& flights;
  const std::function<void(Expected<Value>)> reply;
  typename Flights::Seat seat;
  Priority priority = Priority::kBackground;  ///< how urgently it waits
  tenants::Account::Seat share;               ///< of the computations that its name may have at the same time
  std::shared_ptr<const Observer> observer{};  ///< of the progress
  LeaveEarly early;
};

/// Sets aside what a piece of work needs whose turn has come. False: there is not so much now, and it leaves its thread.
/// When there is, `again` queues it; where that cannot be, `failed` is told why.
template <class Work, class PriorityNow, class Again, class Failed>
bool Dispatcher::has_memory(const std::shared_ptr<Work>& work, const std::string& client,
                            PriorityNow priority_now, std::uint64_t bytes, Again again, Failed failed) {
  if (work->working) return true;
  std::optional<MemoryBudget::Reservation> memory =
      line_.take({.client = client,
                  .bytes = bytes,
                  .use = [work, priority_now] { return use_of(priority_now()); },
                  .given_up = [work] { return work->abandoned(); },
                  .go_on =
                      [work, again, failed](MemoryBudget::Reservation later) {
                        const auto queued = guarded([&]() -> Expected<bool> {
                          work->hold(std::move(later));
                          again();
                          return true;
                        });
                        if (!queued) failed(queued.error());
                      }});
  if (memory) work->hold(std::move(*memory));
  return memory.has_value();
}

/// One result being computed, by the leader of its flight.
struct Dispatcher::Computation : std::enable_shared_from_this<Computation> {
  explicit Computation(Dispatcher& its_dispatcher) : dispatcher(its_dispatcher) {}
  /// However it ended, its memory is free.
  ~Computation() { give_back(); }

  Dispatcher& dispatcher;
  FractureRequest request{};
  RequestKeys keys{};
  double cost = 0;                                ///< revised when the mesh is known
  std::uint64_t bytes = 0;                        ///< that it should need, set aside when its turn comes
  Priority origin = Priority::kBackground;        ///< of whoever led
  std::optional<ComputationAllowance> working{};  ///< nothing: it waits for its turn, or for memory
  std::optional<BackgroundMemory::Id> in_background{};
  std::shared_ptr<ResultFlights::Flight> flight{};
  Clock::time_point submitted = Clock::now(), begun{};
  std::atomic<bool> given_up{false};  ///< others need its memory
  std::mutex of_leave_part{};
  /// While it waits for a part, it waits no longer. False: it does not wait.
  std::function<bool()> leave_part{};
  bool tried_again = false;  ///< a part that somebody else computed, and was ended for
  double busy_seconds = 0;
  FractureAnswer answer{};
  std::shared_ptr<const PreparedMesh> mesh{};

  /// Whoever was to compute the part for all was one too many of its class, or found no memory: this one computes it
  /// itself, once.
  bool goes_on_without(const Error& error) {
    const bool crowded_out = error.code == ErrorCode::kOverloaded || error.code == ErrorCode::kOverShare;
    return crowded_out && !std::exchange(tried_again, true);
  }
  bool abandoned() const { return flight->stop().stop_requested(); }
  bool was_given_up() const {
    return given_up && flight->common.urgency.priority_of_task() == Priority::kBackground;
  }
  Execution execution(int threads, std::stop_token stop) {
    Execution e;
    e.threads = threads;
    e.stop = std::move(stop);
    e.allowance = &working->allowance();
    e.turn = WorkerPool::turn();
    WorkerPool::stands_still_while_wanted(e);
    e.progress = [flight = flight](Stage stage, double fraction) { flight->common.tell(stage, fraction); };
    return e;
  }
  void hold(MemoryBudget::Reservation memory) {
    const std::string client = flight->common.urgency.turn().name;
    if (memory.use() == MemoryBudget::Use::kBackground)
      in_background = dispatcher.background_.add({client, memory.bytes(), [this] { return give_up(); }});
    working.emplace(dispatcher.working_.whole(), std::move(memory), dispatcher.make_room_for(client));
  }
  /// As BackgroundMemory::Holder says it, with the lock of that.
  bool give_up() {
    const Urgency& urgency = flight->common.urgency;
    given_up = urgency.priority_of_task() == Priority::kBackground;
    if (!given_up) return false;
    dispatcher.pool_.give_up(urgency.task());
    // If it does not run, it is queued or waits for a part, or will soon. Ending it gives memory back, which takes the same lock.
    dispatcher.timer_.at(Clock::now(), [weak = weak_from_this()] {
      if (const Shared c = weak.lock()) c->dispatcher.end_if_given_up(c);
    });
    return true;
  }
  void waits_by(std::function<bool()> leave) {
    const std::lock_guard lock(of_leave_part);
    leave_part.swap(leave);
  }
  bool waits_no_longer() {
    std::function<bool()> leave;
    {
      const std::lock_guard lock(of_leave_part);
      leave = leave_part;
    }
    return leave && leave();
  }
  void give_back() {
    if (!working) return;
    working.reset();
    if (in_background) dispatcher.background_.remove(*std::exchange(in_background, std::nullopt));
    dispatcher.line_.given_back();
  }
  /// All who wait for it pay for what was computed for it.
  void pay(double seconds) { dispatcher.charge(flight->common.payers.charge(seconds), seconds); }
  /// As the pool measures it.
  static WorkerPool::Used paid_by(const Shared& c) {
    return [c](double seconds) { c->pay(seconds); };
  }
};

}  // namespace fracture
