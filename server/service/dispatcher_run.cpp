// Work without a flight: one step of one request, on a thread of the pool.
#include <utility>

#include "server/service/computation.hpp"

namespace fracture {

/// Waits in the queue, until its turn comes or nobody waits for it any more: what is first decides. Lives in
/// the task.
struct Dispatcher::Errand : std::enable_shared_from_this<Errand> {
  Errand(Dispatcher& d, const Terms& t, Job j, GivenUp g)
      : dispatcher(d), terms(t), job(std::move(j)), given_up(std::move(g)), early(d.timer_) {}

  /// After it was queued. May give up before it returns.
  void arm(WorkerPool::TaskId its_task) {
    task = its_task;
    early.arm(weak_from_this(), terms);
  }

  void leave(ErrorCode code) {
    if (decided.exchange(true)) return;
    ++dispatcher.abandoned_;
    if (code == ErrorCode::kDeadlineExceeded) ++dispatcher.expired_;
    dispatcher.pool_.withdraw(task);  // where its turn has just come, it finds that nobody waits
    share = {};
    job = nullptr;
    working = {};
    given_up(to_error(Interrupted{code}));
  }

  /// On its thread. False: it was given up.
  bool begin(Spent& spent, int threads) {
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
  const Terms terms;
  Job job;
  const GivenUp given_up;
  MemoryBudget::Reservation working;
  tenants::Account::Seat share;
  std::atomic<bool> decided{false};
  WorkerPool::TaskId task = 0;
  LeaveEarly early;
};

std::optional<Error> Dispatcher::run(const ExpectedWork& work, const Terms& terms, Job job,
                                     GivenUp given_up) {
  const auto errand = std::make_shared<Errand>(*this, terms, std::move(job), std::move(given_up));
  std::optional<Error> overload = seat(terms, errand->share);
  if (!overload) overload = refuses(work.seconds, terms);
  if (!overload) overload = reserve(work.bytes, terms, errand->working);
  if (overload) {
    ++refused_;
    return overload;
  }
  const auto at_its_turn = [this, errand, cost = work.seconds](int threads) {
    Spent spent;
    if (errand->begin(spent, threads)) pool_.measured(cost, spent.busy_seconds);
  };
  const WorkerPool::TaskId task = pool_.submit(terms.priority, work.seconds, at_its_turn, terms.payer.turn());
  try {
    errand->arm(task);
  } catch (...) {
    if (errand->decided.exchange(true)) return std::nullopt;
    pool_.withdraw(task);
    throw;
  }
  return std::nullopt;
}

}  // namespace fracture
