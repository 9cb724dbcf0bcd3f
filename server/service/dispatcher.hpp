// Decides what is computed, when, and for which clients. Requests come in, callbacks go out, and nobody blocks.
//
//   request ──in memory?──> answer at once
//      │ no
//      ├──in flight?──> one more waiter                       (result flights, by RequestKeys::result)
//      │ no
//      ├──would it be too late, too much memory?──> refused at once, with a time to retry
//      │ no
//      └──queued──> mesh ──> diagram ──> cut, encode ──> all waiters
//                  flight    flight
//
// Mesh preparation and tetrahedralization are flights of their own, because results with different seeds share a mesh, and
// results with different duals share a diagram. If a computation needs a value that another one is computing, it releases
// its thread and is resumed when the value is ready.
//
// Each waiter has a deadline and may leave at any time. A computation is stopped when nobody is waiting for it any more.
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
#include "server/service/client_shares.hpp"
#include "server/service/computation_allowance.hpp"
#include "server/service/failure_keeper.hpp"
#include "server/service/memory_budget.hpp"
#include "server/service/memory_holders.hpp"
#include "server/service/memory_line.hpp"
#include "server/service/payer.hpp"
#include "server/service/service.hpp"
#include "server/service/single_flight.hpp"
#include "server/service/timer.hpp"
#include "server/service/urgency.hpp"
#include "server/service/worker_pool.hpp"

namespace fracture {

struct DispatcherConfig {
  /// Working memory, in estimated bytes, that all computations may use at the same time. A single computation may always run.
  /// An eighth is reserved for small computations. A client may use at most three quarters, and less if others use a lot. So a
  /// demanding client leaves room for collisions, both its own and others'. A client with only one computation may use more, but
  /// only as the computation proves to need it: predictions reserve at most three quarters. Queued work holds no memory. If a
  /// client lacks memory within its even part, computations of clients that hold more than theirs are given up (MemoryHolders).
  std::uint64_t max_working_bytes = 2ull << 30;
  FailureKeeper* failures = nullptr;  ///< gets unsound answers and defects; borrowed; null: not kept
};

/// Everything about a request except the mesh and the parameters.
struct Terms {
  Priority priority = Priority::kBatch;
  std::chrono::steady_clock::time_point deadline = std::chrono::steady_clock::time_point::max();
  std::string allowed{};   ///< the time until the deadline and its setting, for errors: "60 s (--deadline)"
  std::stop_token gone{};  ///< stop is requested when nobody wants the answer any more
  /// Called with (stage, fraction of it) by the computing thread; must be thread-safe and cheap.
  std::function<void(Stage, double)> progress{};
  Payer payer{};
  /// Called with a successful answer before the reply, by any thread.
  std::function<void(const FractureResult&)> answered{};
  /// The request's place among the computations of its name, which its steps pass on: the first step takes the place, and
  /// leaves it here for the next step. Null: each step takes a place of its own.
  std::shared_ptr<tenants::Account::Seat> seat{};
  bool needs_seat = true;    ///< false: the request finishes work that already had a place
  bool is_computed = false;  ///< run() finishes work that had its turn: it is not refused for a full queue
  /// False: clients that wait for run() hold memory themselves. If memory is short, the work is given up instead of waiting.
  bool may_wait_for_memory = true;
  /// For work that several requests queue, of which one does it for all. Called when the turn of run() comes, before memory is
  /// taken. If it returns true, the work lets its turn pass: it leaves the queue and calls nothing. Work with this
  /// function is never counted as abandoned.
  std::function<bool()> passes{};
  std::uint64_t least_bytes = 0;  ///< minimum memory, if an earlier attempt needed more than expected
};

/// Returns a kOverloaded error that says when to retry.
inline Error overloaded(std::string detail, std::chrono::seconds retry_after) {
  return {.code = ErrorCode::kOverloaded, .detail = std::move(detail), .retry_after = retry_after};
}

/// Computes answers on a pool, and shares computations between requests. A request that is refused at once gets an error with
/// a time to retry: kOverloaded if there is no room for anybody, kOverShare if only this client's share is used up.
class Dispatcher {
 public:
  using FractureReply = std::function<void(Expected<FractureAnswer>)>;
  using MeshReply = std::function<void(Expected<std::shared_ptr<const PreparedMesh>>)>;

  Dispatcher(FractureService& service, WorkerPool& pool, const DispatcherConfig& config = {})
      : service_(service),
        pool_(pool),
        failures_(config.failures),
        working_(divided(config.max_working_bytes), share_of(config.max_working_bytes)) {}
  /// Waits until all computations have ended. If that would take too long, stop them first through Terms::gone.
  ~Dispatcher() { wait_idle(); }
  Dispatcher(const Dispatcher&) = delete;
  Dispatcher& operator=(const Dispatcher&) = delete;

  /// Computes an answer. If it returns nothing, `reply` is called exactly once, before or after the return, from any thread.
  /// If it returns an error, `reply` is dropped without a call. Replies may be errors: those of FractureService::fracture(),
  /// kInternal for a broken invariant, and kOutOfMemory. The request must own its bytes (FractureRequest::owner).
  std::optional<Error> fracture(FractureRequest request, const Terms& terms, FractureReply reply);
  /// Runs only the first two steps. Otherwise like fracture().
  std::optional<Error> prepare(FractureRequest request, const Terms& terms, MeshReply reply);
  /// Runs other work on a pool thread, in the request's class and without a flight: decoding a body, or reading from a cache
  /// tier. If it returns nothing, exactly one of the functions is called, before or after the return. `job` is called when its
  /// turn comes; its Execution has the deadline and the stop token of the terms, which it must poll. `given_up` is called
  /// instead if the deadline passes (kDeadlineExceeded) or the client leaves (kCancelled) before that; the job then leaves
  /// the queue. So it is if the job may not wait for memory (Terms) and there is too little (kOverloaded, kOverShare). If it returns an error, both functions are dropped. They must not throw.
  using Job = std::function<void(const Execution&)>;
  using GivenUp = std::function<void(Error)>;
  std::optional<Error> run(ExpectedWork work, const Terms& terms, Job job, GivenUp given_up);
  /// Sets aside working memory of this client (Flow::name) for an answer that stays after its computation. Fills `aside`, whose
  /// destructor gives the memory back, if the verdict is kFits. An answer may be read slowly, so even a small one leaves the
  /// part for small computations free. If the verdict is kHeldInBackground, background work gives up memory soon, and no other
  /// background work takes it for three seconds. Takes only locks of the memory budget and of the timer.
  MemoryBudget::Verdict set_aside(const std::string& client, std::uint64_t bytes,
                                  std::shared_ptr<const void>& aside);
  /// The working memory of everything that is computed or read.
  MemoryBudget& working() { return working_.whole(); }
  /// The most working memory that a single computation may hold, bytes.
  std::uint64_t most_bytes() const { return working_.whole().capacity(); }
  /// Returns how many computations have had their turn and now wait for memory.
  std::size_t waiting_for_memory() const { return line_.size(); }

  /// Returns an error if a request with this much work would be refused. Called before the body is read, so it reserves
  /// nothing.
  std::optional<Error> refuses(const ExpectedWork& work, const Terms& terms) const;

  /// Blocks until nothing is computed any more and no reply is outstanding.
  void wait_idle() {
    do {  // the timer's calls and the end of the claim may resume tasks
      pool_.wait_idle();
      timer_.flush();
      end_claim(Clock::time_point::max());
    } while (pool_.running() + pool_.queued() > 0);
  }

  /// Returns how many tasks go before the computation of each of these results (RequestKeys::result); nothing if it is not
  /// queued (WorkerPool::positions).
  std::vector<std::optional<std::size_t>> queue_positions(const std::vector<std::string>& result_keys) const;

  struct Figures {
    std::uint64_t computed = 0;   ///< results computed to the end
    std::uint64_t collapsed = 0;  ///< requests that waited for another request's computation
    std::uint64_t abandoned = 0;  ///< waiters that left: disconnected, cancelled or past their deadline
    std::uint64_t expired = 0;    ///< work whose deadline passed before its turn came
    std::uint64_t refused = 0;    ///< requests that admission refused
    std::size_t flights = 0;      ///< current number of result flights
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

  /// Receives the progress for one waiter. Its lifetime ends with the waiter's, so waiters that leave do not accumulate.
  using Observer = std::function<void(Stage, double)>;

  /// Data that all waiters of a result share.
  struct Common {
    Urgency urgency;
    std::atomic<Clock::rep> latest_deadline{0};
    Payers payers;
    std::mutex mutex;  // guards the observers
    std::vector<std::weak_ptr<const Observer>> observers;
    std::atomic<bool> observed{false};  ///< avoids the lock: usually there is no observer
    void tell(Stage stage, double fraction);
    void add(const std::shared_ptr<const Observer>& observer);
  };
  using ResultFlights = SingleFlight<FractureAnswer, Common>;
  using MeshFlights = SingleFlight<Step<PreparedMesh>, Urgency>;
  using DiagramFlights = SingleFlight<Step<CutBase>, Urgency>;

  std::optional<Error> refuses(double cost, const Terms& terms) const;
  /// Returns the work of a request, for its admission, or the refusal if it cannot fit. `mesh`: null if it is not prepared yet. The
  /// caller may be an io thread. If an estimate from the mesh takes too long for one, the work is estimated without it, and
  /// `is_provisional` is set: the computation then makes the estimate.
  Expected<ExpectedWork> work_of(const FractureRequest& request, const RequestKeys& keys,
                                 const PreparedMesh* mesh, bool& is_provisional);
  /// `unread`: bytes of the mesh that are still to be read. `figures`: of the solid; null if it is not known.
  ExpectedWork work_of(const FractureRequest& request, const RequestKeys& keys, std::uint64_t unread,
                       const SolidFigures* figures);
  /// Obtains a place among the computations of the payer's name: that of the request's previous step, or else a new one.
  static std::optional<Error> seat(const Terms& terms, tenants::Account::Seat& share);
  /// Charges each payer for all of the time, in the class of its own request.
  void charge(const std::vector<Waits>& payers, double seconds);
  /// Returns an error if there is not enough memory to begin now. Sets nothing aside: that happens when the computation gets
  /// its turn.
  std::optional<Error> lacks_memory(std::uint64_t bytes, const Terms& terms,
                                    MemoryBudget::Limit limit = MemoryBudget::Limit::kUsual);
  /// Returns whether a request that lacks memory waits for it, until its deadline, instead of being refused. This is so if its
  /// client holds none, because then others hold it, and might do so at each attempt. A collision waits only for memory that others
  /// have to give up. A job waits outside the dispatcher.
  bool waits_for_memory(const Terms& terms);
  Error lacking(MemoryBudget::Verdict verdict, std::uint64_t bytes) const;
  static MemoryBudget::Use use_of(Priority priority);
  /// Returns a function that makes room for a reservation of this client: work of other clients gives up memory.
  ComputationAllowance::MakeRoom make_room_for(const std::string& client);
  /// Gives up computations of other clients for a reservation that this client lacks (MemoryHolders). `verdict`: why it does not
  /// get `bytes`. Computations over their client's part are spared if they are younger than `least_age`. Returns false if nothing
  /// can be given up.
  bool give_up_for(const std::string& client, MemoryBudget::Verdict verdict, std::uint64_t bytes,
                   std::chrono::milliseconds least_age = {});
  /// Work that waits in the line spares computations of less than this age. watch_line() asks again.
  static constexpr std::chrono::milliseconds kSpared{100};
  /// Makes the line ask for memory again, as long as work waits there: a computation may begin to stand still.
  void watch_line() noexcept;
  /// Makes background work of other clients give up memory for an answer of this client, which asks again soon.
  void make_room_for_answer(const std::string& client, std::uint64_t bytes);
  /// Ends the claim for such answers, unless it lasts beyond `now`.
  void end_claim(std::chrono::steady_clock::time_point now);
  static MemoryBudget::Divided divided(std::uint64_t working_bytes);
  static std::uint64_t share_of(std::uint64_t bytes);
  /// Removes a computation from the queue, or from the line for memory, if nobody is waiting for it any more.
  template <class Flight>
  void withdraw_if_abandoned(const Flight& flight, const Urgency& urgency) {
    if (!flight.stop().stop_requested()) return;
    pool_.withdraw(urgency.task());
    line_.given_back();
  }

  // The stations of a computation. Each runs on a pool thread.
  void begin(const Shared& c, int threads);
  template <class Work, class PriorityNow, class Again, class Failed>
  bool has_memory(const std::shared_ptr<Work>& work, const std::string& client, PriorityNow priority_now,
                  std::uint64_t bytes, Again again, Failed failed);
  void obtain_mesh(const Shared& c, int threads);
  void obtain_diagram(const Shared& c, int threads);
  void with_mesh(const Shared& c, const Outcome<PreparedMesh>& mesh, int threads);
  void with_diagram(const Shared& c, const Outcome<CutBase>& diagram, int threads);
  /// Runs a station. If it throws, the computation ends with a typed error.
  template <class Station>
  void at_station(const Shared& c, Station station);
  void end(const Shared& c, Expected<FractureAnswer> outcome);
  /// Ends a computation that was given up and is not running, because others need its memory.
  void end_if_given_up(const Shared& c);
  /// Queues a computation again that was given up. It takes its memory when its turn comes again.
  void begin_again(const Shared& c);
  static Error given_up();
  template <class Value, class Make>
  void obtain(SingleFlight<Step<Value>, Urgency>& flights, const std::string& key, const Shared& c,
              int threads, Make make, void (Dispatcher::*next)(const Shared&, const Outcome<Value>&, int));

  template <class Flights, class Value>
  struct Waiting;
  struct Errand;
  struct Preparation;
  struct Upload;
  struct Arrival;
  /// Joins or starts the flight of the mesh. It was admitted.
  void prepare(Upload upload, const Terms& terms);
  void begin_mesh(const std::shared_ptr<Preparation>& p, int threads);
  void begin_errand(const std::shared_ptr<Errand>& errand, int threads);

  FractureService& service_;
  WorkerPool& pool_;
  FailureKeeper* const failures_;
  ClientShares working_;
  MemoryHolders holders_;
  MemoryLine line_{working_, [this](const std::string& client, std::uint64_t bytes) {
                     give_up_for(client, working_.judge(client, bytes), bytes, kSpared);
                   }};
  std::mutex of_claim_;
  std::unique_ptr<MemoryLine::Claim> claim_;  ///< for answers that could not be set aside
  Clock::time_point claimed_until_{};
  ResultFlights results_;
  MeshFlights meshes_;
  DiagramFlights diagrams_;
  std::atomic<std::uint64_t> computed_{0}, collapsed_{0}, abandoned_{0}, expired_{0}, refused_{0};
  std::atomic<bool> watches_line_{false};
  Timer timer_;  // last, because its calls use everything above
};

}  // namespace fracture
