// Work without a flight: one step of one request, on a pool thread.
#include <utility>

#include "server/service/computation.hpp"

namespace fracture {

/// Waits in the queue until its turn comes or nobody waits for it any more, whichever is first. The task owns it.
struct Dispatcher::Errand : std::enable_shared_from_this<Errand> {
  Errand(Dispatcher& d, const ExpectedWork& w, const Terms& t, Job j, GivenUp g)
      : dispatcher(d), work(w), terms(t), job(std::move(j)), given_up(std::move(g)), early(d.timer_) {}
  ~Errand() { give_back(); }

  /// Starts the deadline and the watch for the client. Call it after the task was queued. The errand may be given up before
  /// this returns.
  void arm(WorkerPool::TaskId its_task) {
    task = its_task;
    early.arm(weak_from_this(), terms);
  }

  void leave(ErrorCode code) {
    if (decided.exchange(true)) return;
    if (!terms.passes) ++dispatcher.abandoned_;
    if (code == ErrorCode::kDeadlineExceeded) ++dispatcher.expired_;
    withdraw();  // if its turn has just come, it ends at once, because `decided` is set
    share = {};
    job = nullptr;
    dispatcher.line_.given_back();  // removes it from the line if it waits for memory
    given_up(
        code == ErrorCode::kDeadlineExceeded
            ? Error{code,
                    "The request's deadline passed before its turn came. The deadline is the server's "
                    "--deadline or the request's own Request-Timeout. Send the request again later, or with a "
                    "longer Request-Timeout."}
            : to_error(Interrupted{code}));
  }
  /// Another request does the work.
  void pass() {
    if (!decided.exchange(true)) job = nullptr;
  }
  void fail(const Error& error) {
    if (!decided.exchange(true)) given_up(error);
  }

  void withdraw() {
    if (terms.is_computed)
      dispatcher.pool_.withdraw_resumed(task);
    else
      dispatcher.pool_.withdraw(task);
  }

  bool abandoned() const { return decided; }
  static constexpr bool kGivesUpMemory = false;
  static int times_given_up() { return 0; }
  static bool has_stood_still() { return false; }
  void hold(MemoryBudget::Reservation memory) { working.emplace(std::move(memory)); }
  void give_back() {
    if (!working) return;
    working.reset();
    dispatcher.line_.given_back();
  }

  /// Runs the job on this thread. Returns false if it was given up.
  bool begin(int threads) {
    if (decided.exchange(true)) return false;
    if (terms.seat) *terms.seat = std::move(share);
    Execution execution;
    execution.threads = threads;
    execution.stop = terms.gone;
    if (terms.deadline != Clock::time_point::max()) execution.deadline = terms.deadline;
    execution.turn = WorkerPool::turn();
    WorkerPool::stands_still_while_wanted(execution);
    const Meter meter(spent);
    job(execution);
    return true;
  }

  Dispatcher& dispatcher;
  const ExpectedWork work;
  const Terms terms;
  Job job;
  const GivenUp given_up;
  std::optional<MemoryBudget::Reservation> working{};
  tenants::Account::Seat share;
  std::atomic<bool> decided{false};
  Spent spent{};
  WorkerPool::TaskId task = 0;
  LeaveEarly early;
};

std::optional<Error> Dispatcher::run(ExpectedWork work, const Terms& terms, Job job, GivenUp given_up) {
  work.bytes = std::min(work.bytes, working_.most_at_once());
  const auto errand = std::make_shared<Errand>(*this, work, terms, std::move(job), std::move(given_up));
  std::optional<Error> overload = seat(terms, errand->share);
  if (!overload && !terms.is_computed) overload = refuses(work.seconds, terms);
  const bool needs_none = terms.is_computed && work.bytes == 0;
  if (!overload && !needs_none && !(terms.may_wait_for_memory && waits_for_memory(terms)))
    overload = lacks_memory(work.bytes, terms);
  if (overload) {
    ++refused_;
    return overload;
  }
  const auto at_turn = [this, errand](int threads) { begin_errand(errand, threads); };
  const WorkerPool::TaskId task =
      terms.is_computed
          ? pool_.resume(at_turn, terms.priority, work.seconds, std::nullopt, terms.payer.turn())
          : pool_.submit(terms.priority, work.seconds, at_turn, terms.payer.turn());
  try {
    errand->arm(task);
  } catch (...) {
    if (errand->decided.exchange(true)) return std::nullopt;
    errand->withdraw();
    throw;
  }
  return std::nullopt;
}

MemoryBudget::Verdict Dispatcher::set_aside(const std::string& client, std::uint64_t bytes,
                                            std::shared_ptr<const void>& aside) {
  struct Aside {
    Aside(MemoryLine& l, MemoryBudget::Reservation m) : line(l), memory(std::move(m)) {}
    ~Aside() {
      if (memory.bytes() == 0) return;
      memory = {};
      line.given_back();
    }
    MemoryLine& line;
    MemoryBudget::Reservation memory;
  };
  auto kept = std::make_shared<Aside>(line_, working_.begin(client));
  const MemoryBudget& whole = working_.whole();
  constexpr auto kWaitedFor = MemoryBudget::Use::kWaitedFor;
  constexpr auto kStrict = MemoryBudget::Limit::kFairShare;  // an answer cannot be given up for other clients
  auto verdict = MemoryBudget::Verdict::kFits;
  // A small answer is judged as a large reservation if it would take memory that is for small computations.
  if (whole.missing(bytes) > 0)
    verdict = working_.judge(client, std::max(bytes, whole.largest_small() + 1), kWaitedFor, kStrict);
  if (verdict == MemoryBudget::Verdict::kFits && !kept->memory.grow_to(bytes, kStrict))
    verdict = kept->memory.verdict();
  if (verdict == MemoryBudget::Verdict::kHeldInBackground)  // the caller holds a lock, so the timer does it
    timer_.at(Clock::now(), [this, client, bytes] { make_room_for_answer(client, bytes); });
  if (verdict == MemoryBudget::Verdict::kFits) aside = std::move(kept);
  return verdict;
}

void Dispatcher::make_room_for_answer(const std::string& client, std::uint64_t bytes) {
  static constexpr std::chrono::seconds kLongest{3};  // the client is told to ask again after two
  const Clock::time_point until = Clock::now() + kLongest;
  timer_.at(until, [this] { end_claim(Clock::now()); });
  {
    const std::lock_guard lock(of_claim_);
    if (!claim_) claim_ = std::make_unique<MemoryLine::Claim>(line_);
    claimed_until_ = until;
  }
  holders_.give_up_background(client, working_.whole().missing(bytes));
}

void Dispatcher::end_claim(Clock::time_point now) {
  std::unique_ptr<MemoryLine::Claim> over;  // ends without the lock
  const std::lock_guard lock(of_claim_);
  if (claimed_until_ <= now) over.swap(claim_);
}

void Dispatcher::begin_errand(const std::shared_ptr<Errand>& errand, int threads) {
  if (errand->abandoned()) return;
  const auto again = [this, errand] {
    pool_.resume([this, errand](int free) { begin_errand(errand, free); }, errand->terms.priority,
                 errand->work.seconds, std::nullopt, errand->terms.payer.turn());
  };
  const auto failed = [errand](const Error& error) { errand->fail(error); };
  const std::string& client = errand->terms.payer.flow.name;
  const std::uint64_t bytes = errand->work.bytes;
  const Expected<bool> ready = guarded([&]() -> Expected<bool> {
    if (errand->terms.passes && errand->terms.passes()) {
      errand->pass();
      return false;
    }
    if (errand->terms.may_wait_for_memory)
      return has_memory(
          errand, client, [errand] { return errand->terms.priority; }, bytes, again, failed);
    MemoryBudget::Reservation memory = working_.begin(client, use_of(errand->terms.priority));
    // Only background work gives up memory for it. Other computations would lose more than it gains.
    if (!memory.grow_to(bytes) && !(memory.verdict() == MemoryBudget::Verdict::kHeldInBackground &&
                                    make_room_for(client)(memory, bytes)))
      return tl::unexpected<Error>(lacking(memory.verdict(), bytes));
    errand->hold(std::move(memory));
    return true;
  });
  if (!ready) return failed(ready.error());
  if (!*ready) return;  // it let its turn pass, or its turn comes again
  if (errand->begin(threads) && errand->work.seconds > 0)
    pool_.measured(errand->terms.payer.flow.name, errand->work.seconds, errand->spent.busy_seconds);
}

}  // namespace fracture
