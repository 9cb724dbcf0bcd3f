// Private to dispatcher*.cpp: waiters, computations, and the resources that they use.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <new>
#include <optional>
#include <stop_token>
#include <utility>

#include "common/base/processor_time.hpp"
#include "server/service/computation_allowance.hpp"
#include "server/service/dispatcher.hpp"
#include "server/service/leave_early.hpp"
#include "server/service/memory_holders.hpp"

namespace fracture {

/// Runs a step, and converts everything that it may throw to the error that the client gets.
template <class Work>
auto guarded(Work work) -> decltype(work()) {
  try {
    return work();
  } catch (const Interrupted& interrupted) {
    return tl::unexpected<Error>(to_error(interrupted));
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::kOutOfMemory,
                "The server does not have enough memory for this request at the moment.");
  } catch (const std::exception& e) {
    return fail(ErrorCode::kInternal, e.what());
  } catch (...) {
    return fail(ErrorCode::kInternal, "an exception of unknown type");
  }
}

/// Returns the error to report to all clients of a computation. If one client's share is used up, the others get
/// kOverloaded instead of kOverShare.
inline Error told_to_all(Error error, const Urgency& urgency) {
  if (error.code != ErrorCode::kOverShare || !urgency.is_of_several()) return error;
  error.code = ErrorCode::kOverloaded;
  error.detail =
      "Another client is waiting for the same computation, whose memory counts towards that client's "
      "share. That client's other computations are using too much memory at the moment.";
  return error;
}

/// The time that a computation has used so far.
struct Spent {
  double busy_seconds = 0;       ///< elapsed time, without the time for which it stood still for others
  double processor_seconds = 0;  ///< on all threads, and in other processes that worked for it
};

/// Adds the time used between its construction and its destruction, on one pool thread.
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

/// A waiter in a flight: its reply, and the two ways to leave early. The flight's callback owns it.
template <class Flights, class Value>
struct Dispatcher::Waiting : std::enable_shared_from_this<Waiting<Flights, Value>> {
  Waiting(Dispatcher& d, Flights& f, std::function<void(Expected<Value>)> r)
      : dispatcher(d), flights(f), reply(std::move(r)), early(d.timer_) {}

  /// Call it after join(). `take_part` starts the computation, or hurries the one that is running. If it throws, the exception
  /// becomes an error: for all waiters if nobody computes the value, otherwise only for this one. The waiter may leave, and
  /// so reply, before this returns.
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

  /// Replies to the client. Before that, frees the client's place, so that its next request can begin at once.
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
  tenants::Account::Seat share;  ///< place among the computations that its name may have at a time
  std::shared_ptr<const Observer> observer{};  ///< receives the progress
  LeaveEarly early;
};

/// Sets aside the memory for work whose turn has come. Returns false if there is not enough now; then the work must leave
/// its thread. When there is enough, `again` is called to queue it again; if that fails, `failed` gets the error.
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
                      },
                  .again = work->times_given_up() > 0,
                  .stood_still = work->has_stood_still(),
                  .gives_up = Work::kGivesUpMemory});
  if (!memory) watch_line();
  if (memory) work->hold(std::move(*memory));
  return memory.has_value();
}

/// The computation of one result, run by the leader of its flight.
struct Dispatcher::Computation : std::enable_shared_from_this<Computation> {
  static constexpr bool kGivesUpMemory = true;
  explicit Computation(Dispatcher& its_dispatcher) : dispatcher(its_dispatcher) {}
  /// Frees the memory, however the computation ended.
  ~Computation() { give_back(); }

  /// Others need its memory. kInBackground: they need it as long as the computation is background work.
  enum class GivenUp : std::uint8_t { kNo, kInBackground, kYes };
  /// A computation that a client waits for begins again so often. After that, the client gets the error. So the wasted work is
  /// bounded, and others never have to wait for a computation that holds more than its client's part.
  static constexpr int kMostBegunAgain = 3;

  Dispatcher& dispatcher;
  FractureRequest request{};
  RequestKeys keys{};
  double cost = 0;                                ///< revised when the mesh is known
  std::uint64_t bytes = 0;                        ///< expected memory, set aside when its turn comes
  bool is_provisional = false;                    ///< the cost was estimated without the mesh, which is known
  Priority origin = Priority::kBackground;        ///< class of the leader
  std::optional<ComputationAllowance> working{};  ///< empty: it waits for its turn, or for memory
  std::optional<MemoryHolders::Id> holder{};      ///< set together with `working`
  std::atomic<std::uint64_t> held_bytes{0};
  std::shared_ptr<ResultFlights::Flight> flight{};
  Clock::time_point submitted = Clock::now(), begun{};
  std::atomic<GivenUp> given_up{GivenUp::kNo};
  std::atomic<bool> stood_still{false};  ///< it was given up for this reason the last time
  std::atomic<int> begun_again{0};       ///< how often it was given up and began again
  std::mutex of_leave_part{};
  /// Stops waiting for a part. Returns false if it does not wait for one.
  std::function<bool()> leave_part{};
  bool has_file = true;      ///< the request still has the mesh's file
  bool tried_again = false;  ///< a part that failed must not be computed again
  double busy_seconds = 0;
  FractureAnswer answer{};
  std::shared_ptr<const PreparedMesh> mesh{};

  /// Another computation of a part has failed with this error. Returns whether to compute the part here instead: once, and
  /// only if the other computation was ended because of more urgent work or a lack of memory.
  bool goes_on_without(const Error& error) {
    const bool crowded_out = error.code == ErrorCode::kOverloaded || error.code == ErrorCode::kOverShare;
    return crowded_out && !std::exchange(tried_again, true);
  }
  bool abandoned() const { return flight->stop().stop_requested(); }
  bool was_given_up() const {
    const GivenUp state = given_up;
    return state == GivenUp::kYes || (state == GivenUp::kInBackground && is_background());
  }
  bool is_background() const { return flight->common.urgency.priority_of_task() == Priority::kBackground; }
  int times_given_up() const { return begun_again; }
  bool has_stood_still() const { return stood_still; }
  /// Returns whether it begins again after this error, because it ended only for the memory that others needed. A job
  /// begins again here only if a client waits for it now. Otherwise, its owner (Jobs) submits it again.
  bool begins_again_after(const Error& error) const {
    const bool crowded_out =
        error.code == ErrorCode::kOverloaded || error.code == ErrorCode::kOverShare ||
        error.code == ErrorCode::kOutOfMemory;  // it may have needed more before it ended
    return crowded_out && given_up != GivenUp::kNo && !is_background() && !abandoned() &&
           begun_again < kMostBegunAgain && can_begin_again();
  }
  bool can_begin_again() const { return has_file || dispatcher.service_.peek_mesh(keys); }
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
    held_bytes = memory.bytes();
    holder = dispatcher.holders_.add(
        {.client = client,
         .bytes = [this] { return held_bytes.load(); },
         .may_give_up = [this](MemoryHolders::Why why) { return may_give_up(why); },
         .give_up = [this](MemoryHolders::Why why) { give_up(why); },
         .urgency = [this] { return static_cast<int>(flight->common.urgency.priority_of_task()); },
         .begun_again = begun_again});
    working.emplace(dispatcher.working_.whole(), std::move(memory), dispatcher.make_room_for(client),
                    &held_bytes);
  }
  /// See MemoryHolders::Holder. The caller holds the lock of MemoryHolders.
  bool may_give_up(MemoryHolders::Why why) const {
    if (why == MemoryHolders::Why::kBackground) return is_background();
    if (dispatcher.working_.whole().is_small(held_bytes)) return false;  // it would not help
    const Urgency& urgency = flight->common.urgency;
    return why == MemoryHolders::Why::kOverPart ? !urgency.computes_for_others() : urgency.stands_still();
  }
  void give_up(MemoryHolders::Why why) {
    const bool in_background = why == MemoryHolders::Why::kBackground;
    stood_still = why == MemoryHolders::Why::kStandsStill;
    given_up = in_background ? GivenUp::kInBackground : GivenUp::kYes;
    dispatcher.pool_.give_up(flight->common.urgency.task(),
                             in_background ? Priority::kBackground : Priority::kRealtime);
    // If it does not run, it is queued or waits for a part, or will soon. Ending it gives memory back, which takes the same
    // lock, so the timer does it later.
    dispatcher.timer_.at(Clock::now(), [weak = weak_from_this()] {
      if (const Shared c = weak.lock()) c->dispatcher.end_if_given_up(c);
    });
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
    if (!working && !holder) return;
    working.reset();
    if (holder) dispatcher.holders_.remove(*std::exchange(holder, std::nullopt));
    dispatcher.line_.given_back();
  }
  /// Charges all clients that are waiting for it.
  void pay(double seconds) { dispatcher.charge(flight->common.payers.charge(seconds), seconds); }
  /// Returns a function that charges these clients for the time that the pool measures.
  static WorkerPool::Used paid_by(const Shared& c) {
    return [c](double seconds) { c->pay(seconds); };
  }
};

template <class Station>
void Dispatcher::at_station(const Shared& c, Station station) {
  const auto passed = guarded([&]() -> Expected<bool> {
    station();
    return true;
  });
  if (!passed) end(c, tl::unexpected<Error>(passed.error()));
}

}  // namespace fracture
