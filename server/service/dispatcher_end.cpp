// The end of a computation: its answer, its error, or a further attempt if other clients needed its memory.
#include <utility>

#include "server/service/computation.hpp"

namespace fracture {

void Dispatcher::end(const Shared& c, Expected<FractureAnswer> outcome) {
  const bool again = !outcome && c->begins_again_after(outcome.error());
  c->give_back();
  WorkerPool::charge_by_now();
  if (again) return begin_again(c);
  if (!outcome)
    outcome = tl::unexpected<Error>(told_to_all(std::move(outcome.error()), c->flight->common.urgency));
  results_.land(c->flight, outcome);
  if (failures_ && !outcome && FailureKeeper::concerns(outcome.error().code))
    failures_->keep(c->request, outcome.error(), *outcome.error().extra);
}

void Dispatcher::begin_again(const Shared& c) {
  c->given_up = Computation::GivenUp::kNo;  // it holds no memory, so it is not asked to end again
  ++c->begun_again;
  c->tried_again = false;
  c->busy_seconds = 0;
  c->answer = {};
  c->mesh.reset();
  const auto queued = guarded([&]() -> Expected<bool> {
    c->flight->common.urgency.goes_on(pool_, [&](Priority priority, const Flow& flow) {
      return pool_.resume([this, c](int threads) { at_station(c, [&] { begin(c, threads); }); }, priority,
                          c->cost, c->origin, flow, Computation::paid_by(c));
    });
    return true;
  });
  if (!queued) end(c, tl::unexpected<Error>(queued.error()));
}

void Dispatcher::end_if_given_up(const Shared& c) {
  if (!c->was_given_up()) return;
  if (!c->waits_no_longer() && !pool_.withdraw_resumed(c->flight->common.urgency.task())) return;
  // Its task may have ended, and begun again, just before: then the further attempt was stopped instead.
  if (!c->was_given_up() && c->can_begin_again()) {
    c->give_back();
    return begin_again(c);
  }
  end(c, tl::unexpected<Error>(given_up()));
}

Error Dispatcher::given_up() {
  return overloaded(
      "This computation was stopped because other computations need its memory. Send the "
      "request again.",
      std::chrono::seconds(1));
}

}  // namespace fracture
