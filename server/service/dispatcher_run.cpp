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
    ++dispatcher.abandoned_;
    if (code == ErrorCode::kDeadlineExceeded) ++dispatcher.expired_;
    dispatcher.pool_.withdraw(task);  // if its turn has just come, it finds that nobody waits
    share = {};
    job = nullptr;
    dispatcher.line_.given_back();  // removes it from the line if it waits for memory
    given_up(code == ErrorCode::kDeadlineExceeded
                 ? Error{code,
                         "The deadline of the request passed before its turn came: the server's --deadline, "
                         "or the request's own Request-Timeout. Send the request again later, or with a "
                         "longer Request-Timeout."}
                 : to_error(Interrupted{code}));
  }
  void fail(const Error& error) {
    if (!decided.exchange(true)) given_up(error);
  }

  bool abandoned() const { return decided; }
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
  if (!overload) overload = refuses(work.seconds, terms);
  if (!overload && !waits_for_memory(terms)) overload = lacks_memory(work.bytes, terms);
  if (overload) {
    ++refused_;
    return overload;
  }
  const WorkerPool::TaskId task = pool_.submit(
      terms.priority, work.seconds, [this, errand](int threads) { begin_errand(errand, threads); },
      terms.payer.turn());
  try {
    errand->arm(task);
  } catch (...) {
    if (errand->decided.exchange(true)) return std::nullopt;
    pool_.withdraw(task);
    throw;
  }
  return std::nullopt;
}

void Dispatcher::begin_errand(const std::shared_ptr<Errand>& errand, int threads) {
  if (errand->abandoned()) return;
  const auto again = [this, errand] {
    pool_.resume([this, errand](int free) { begin_errand(errand, free); }, errand->terms.priority,
                 errand->work.seconds, std::nullopt, errand->terms.payer.turn());
  };
  const auto failed = [errand](const Error& error) { errand->fail(error); };
  const Expected<bool> ready = guarded([&]() -> Expected<bool> {
    return has_memory(
        errand, errand->terms.payer.flow.name, [errand] { return errand->terms.priority; },
        errand->work.bytes, again, failed);
  });
  if (!ready) return failed(ready.error());
  if (!*ready) return;  // its turn comes again
  if (errand->begin(threads))
    pool_.measured(errand->terms.payer.flow.name, errand->work.seconds, errand->spent.busy_seconds);
}

}  // namespace fracture
