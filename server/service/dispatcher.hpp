// Who computes what, when, and for whom. Requests come in and callbacks go out; nobody blocks.
//
//   request ──in memory?──> answer at once
//      │ no
//      ├──in flight?──> one more waiter                       (result flights, by RequestKeys::result)
//      │ no
//      ├──would it be too late, too much memory?──> refused at once, with the time when to come back
//      │ no
//      └──queued──> mesh ──> diagram ──> cut, encode ──> everybody who waits
//                  flight    flight
//
// Mesh preparation and tetrahedralization are flights of their own, shared by results that differ in their
// seed or in their dual. A computation that needs a value somebody else is computing gives its thread back
// and is resumed when the value is there.
//
// Whoever waits has a deadline and may leave at any time; a computation is stopped when nobody waits for it.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "server/service/admission.hpp"
#include "server/service/background_memory.hpp"
#include "server/service/client_shares.hpp"
#include "server/service/computation_allowance.hpp"
#include "server/service/failure_keeper.hpp"
#include "server/service/memory_budget.hpp"
#include "server/service/memory_line.hpp"
#include "server/service/payer.hpp"
#include "server/service/service.hpp"
#include "server/service/single_flight.hpp"
#include "server/service/timer.hpp"
#include "server/service/urgency.hpp"
#include "server/service/worker_pool.hpp"

namespace fracture {

struct DispatcherConfig {
  /// Bytes that computations may be working in at the same time, by estimate; one alone may always run. An
  /// eighth is for small ones alone, and no client holds more than three quarters, less where others hold much, but for
  /// one computation of its own: who asks for much leaves room for a collision, of others and its own. What is queued
  /// holds none of it.
  std::uint64_t max_working_bytes = 2ull << 30;
  FailureKeeper* failures = nullptr;  ///< gets what is unsound or a bug; borrowed; null: nobody does
};

/// What goes with a request besides what is asked.
struct Terms {
  Priority priority = Priority::kBatch;
  std::chrono::steady_clock::time_point deadline = std::chrono::steady_clock::time_point::max();
  std::stop_token gone{};  ///< requested when nobody wants the answer any more
  /// Told (stage, fraction of it) by whatever thread computes; must be thread-safe and cheap.
  std::function<void(Stage, double)> progress{};
  Payer payer{};
  /// Told of a good answer before it is replied, by whatever thread brings it.
  std::function<void(const FractureResult&)> answered{};
  /// Where the steps of one request hand on its place among the computations of its name: the first step
  /// takes it, the next one finds it here. Null: each step takes one.
  std::shared_ptr<tenants::Account::Seat> seat{};
  bool needs_seat = true;         ///< false: finishes what had its place
  std::uint64_t least_bytes = 0;  ///< set aside at least: it needed more than was expected before
};

/// kOverloaded: there is no room, and when there should be.
inline Error overloaded(std::string detail, std::chrono::seconds retry_after) {
  return {.code = ErrorCode::kOverloaded, .detail = std::move(detail), .retry_after = retry_after};
}

/// What refuses at once returns an error: kOverloaded where everybody's room is taken, kOverShare where it is this
/// client's alone, with the time when to come back.
class Dispatcher {
 public:
  using FractureReply = std::function<void(Expected<FractureAnswer>)>;
  using MeshReply = std::function<void(Expected<std::shared_ptr<const PreparedMesh>>)>;

  Dispatcher(FractureService& service, WorkerPool& pool, const DispatcherConfig& config = {})
      : service_(service),
        pool_(pool),
        failures_(config.failures),
        working_(divided(config.max_working_bytes), share_of(config.max_working_bytes)) {}
  /// Waits until nothing is computed any more; stop the flights first (stop_all) when that would take long.
  ~Dispatcher() { wait_idle(); }
  Dispatcher(const Dispatcher&) = delete;
  Dispatcher& operator=(const Dispatcher&) = delete;

  /// Nothing: `reply` is called exactly once, before this returns or later, from any thread. All errors of
  /// FractureService::fracture; kInternal for a broken invariant, kOutOfMemory. Otherwise `reply` is dropped
  /// uncalled. The request must own its bytes (FractureRequest::owner).
  std::optional<Error> fracture(FractureRequest request, const Terms& terms, FractureReply reply);
  /// The first two steps alone, in the same way.
  std::optional<Error> prepare(FractureRequest request, const Terms& terms, MeshReply reply);
  /// Other work for the pool's threads (a body to decode, an entry of a tier to read), with no flight, in the
  /// class of the request. Nothing: exactly one of two is called, before this returns or later. `job` on a
  /// thread of the pool when its turn comes, with the deadline and the stop of the terms for it to poll;
  /// `given_up` where the deadline (kDeadlineExceeded) or the client's leaving (kCancelled) comes first: then
  /// it is queued no longer. Otherwise both are dropped. They must not throw.
  using Job = std::function<void(const Execution&)>;
  using GivenUp = std::function<void(Error)>;
  std::optional<Error> run(const ExpectedWork& work, const Terms& terms, Job job, GivenUp given_up);
  /// What all that is computed or read holds.
  MemoryBudget& working() { return working_.whole(); }
  /// Computations whose turn has come and that wait for memory.
  std::size_t waiting_for_memory() const { return line_.size(); }

  /// Would a request of so much work be refused? Asked before a body is read, so nothing is reserved.
  std::optional<Error> refuses(const ExpectedWork& work, const Terms& terms) const;

  /// Returns when nothing is computed any more and no reply is outstanding.
  void wait_idle() {
    do {  // a call of the timer may resume tasks
      pool_.wait_idle();
      timer_.flush();
    } while (pool_.running() + pool_.queued() > 0);
  }

  /// How many tasks go before the computations of these results (RequestKeys::result); nothing for one that is not
  /// queued (WorkerPool::positions).
  std::vector<std::optional<std::size_t>> queue_positions(const std::vector<std::string>& result_keys) const;

  struct Figures {
    std::uint64_t computed = 0;   ///< results computed to the end
    std::uint64_t collapsed = 0;  ///< requests that waited for the computation of another one
    std::uint64_t abandoned = 0;  ///< waiters who left: closed, cancelled or past their deadline
    std::uint64_t expired = 0;    ///< work whose deadline passed before its turn came
    std::uint64_t refused = 0;    ///< by admission
    std::size_t flights = 0;      ///< of results, now
    std::uint64_t working_bytes = 0;
  };
  Figures figures() const;
  Timer& timer() { return timer_; }
  FractureService& service() { return service_; }
  const WorkerPool& pool() const { return pool_; }

 private:
  using Clock = std::chrono::steady_clock;
  struct Computation;
  using Shared = std::shared_ptr<Computation>;
  template <class Value>
  using Outcome = Expected<Step<Value>>;

  /// Lives as long as the one who waits: those who come and go leave none behind.
  using Observer = std::function<void(Stage, double)>;

  /// What all who wait for a result share.
  struct Common {
    Urgency urgency;
    std::atomic<Clock::rep> latest_deadline{0};
    Payers payers;
    std::mutex mutex;  // of the observers
    std::vector<std::weak_ptr<const Observer>> observers;
    std::atomic<bool> observed{false};  ///< there are any: loops tell often, and mostly nobody listens
    void tell(Stage stage, double fraction);
    void add(const std::shared_ptr<const Observer>& observer);
  };
  using ResultFlights = SingleFlight<FractureAnswer, Common>;
  using MeshFlights = SingleFlight<Step<PreparedMesh>, Urgency>;
  using DiagramFlights = SingleFlight<Step<CutBase>, Urgency>;

  std::optional<Error> refuses(double cost, const Terms& terms) const;
  /// A place among the computations of a name: that of the step before, else a new one.
  static std::optional<Error> seat(const Terms& terms, tenants::Account::Seat& share);
  /// All who waited are charged for all of it, each in the class of its own request.
  void charge(const std::vector<Waits>& payers, double seconds);
  /// Why it would not be begun now for want of memory. Nothing is set aside: that is done when its turn comes.
  std::optional<Error> lacks_memory(std::uint64_t bytes, const Terms& terms);
  Error lacking(MemoryBudget::Verdict verdict, std::uint64_t bytes) const;
  static MemoryBudget::Use use_of(Priority priority);
  /// Background work of others gives up what it has beyond its half and this client lacks.
  ComputationAllowance::MakeRoom make_room_for(const std::string& client);
  static MemoryBudget::Divided divided(std::uint64_t working_bytes);
  static std::uint64_t share_of(std::uint64_t bytes);
  /// What nobody waits for keeps no place in a queue until its turn.
  template <class Flight>
  void withdraw_if_abandoned(const Flight& flight, const Urgency& urgency) {
    if (!flight.stop().stop_requested()) return;
    pool_.withdraw(urgency.task());
    line_.given_back();
  }

  // The stations of a computation, each on a thread of the pool.
  void begin(const Shared& c, int threads);
  template <class Work, class PriorityNow, class Again, class Failed>
  bool has_memory(const std::shared_ptr<Work>& work, const std::string& client, PriorityNow priority_now,
                  std::uint64_t bytes, Again again, Failed failed);
  void obtain_mesh(const Shared& c, int threads);
  void obtain_diagram(const Shared& c, int threads);
  void with_mesh(const Shared& c, const Outcome<PreparedMesh>& mesh, int threads);
  void with_diagram(const Shared& c, const Outcome<CutBase>& diagram, int threads);
  /// Runs a station; whatever it throws ends the computation with a typed error.
  template <class Station>
  void at_station(const Shared& c, Station station);
  void end(const Shared& c, Expected<FractureAnswer> outcome);
  /// A background computation that others need the memory of, and that does not run.
  void end_if_given_up(const Shared& c);
  static Error given_up();
  template <class Value, class Make>
  void obtain(SingleFlight<Step<Value>, Urgency>& flights, const std::string& key, const Shared& c,
              int threads, Make make, void (Dispatcher::*next)(const Shared&, const Outcome<Value>&, int));

  template <class Flights, class Value>
  struct Waiting;
  struct Errand;
  struct Preparation;
  void begin_mesh(const std::shared_ptr<Preparation>& p, int threads);
  void begin_errand(const std::shared_ptr<Errand>& errand, int threads);

  FractureService& service_;
  WorkerPool& pool_;
  FailureKeeper* const failures_;
  ClientShares working_;
  BackgroundMemory background_;
  MemoryLine line_{working_, [this](const std::string& client, std::uint64_t bytes) {
                     background_.give_up(client, working_.whole().missing(bytes));
                   }};
  ResultFlights results_;
  MeshFlights meshes_;
  DiagramFlights diagrams_;
  std::atomic<std::uint64_t> computed_{0}, collapsed_{0}, abandoned_{0}, expired_{0}, refused_{0};
  Timer timer_;  // last: its calls use everything above
};

}  // namespace fracture
