// Who is let in, and who pays: the part of the dispatcher that computes nothing.
#include <algorithm>
#include <cmath>
#include <utility>

#include "server/service/computation.hpp"

namespace fracture {
namespace {

// A request that is admitted and then not done in time has cost others theirs: rather a few too many are
// turned away. (bench_overload: at four times the capacity.)
constexpr double kCaution = 1.2;

std::chrono::seconds whole_seconds(double seconds) {
  return std::chrono::seconds(static_cast<int>(std::clamp(std::ceil(seconds), 1.0, 60.0)));
}

}  // namespace

std::optional<Overload> Dispatcher::refuses(double cost, const Terms& terms) const {
  const Flow& flow = terms.payer.flow;
  const double wait = pool_.predicted_wait(terms.priority, flow).count();
  const double total = kCaution * wait + pool_.predicted_run(cost).count();
  if (pool_.full(flow))
    return Overload{"The queue is full: " + std::to_string(pool_.queued()) + " jobs wait and " +
                        std::to_string(pool_.running()) + " run.",
                    whole_seconds(wait)};
  const std::chrono::duration<double> left = terms.deadline - Clock::now();
  // With nothing ahead it is tried: the prediction may be wrong.
  if (terms.deadline != Clock::time_point::max() && wait > 0 && total > left.count())
    return Overload{"The work would be done in about " + std::to_string(total) +
                        " s; the deadline of this request is in " +
                        std::to_string(std::max(0.0, left.count())) + " s.",
                    whole_seconds(total - left.count())};
  return std::nullopt;
}

std::optional<Overload> Dispatcher::refuses(const ExpectedWork& work, const Terms& terms) const {
  return refuses(work.seconds, terms);
}

std::optional<Overload> Dispatcher::seat(const Terms& terms, tenants::Account::Seat& share) {
  if (!terms.payer.account) return std::nullopt;
  auto seat = terms.payer.account->begin_computation();
  if (!seat)
    return Overload{std::move(seat.error().detail), seat.error().retry_after, Overload::Cause::kOverShare};
  share = std::move(*seat);
  return std::nullopt;
}

void Dispatcher::charge(const Payers& payers, const Flow& leader, Priority priority, double seconds,
                        double cost) {
  for (const Payer& payer : payers.all()) {
    if (payer.account) payer.account->charge(seconds);
    // The cost of the task was charged when its turn came.
    pool_.charge(priority, payer.flow, payer.flow.name == leader.name ? seconds - cost : seconds);
  }
}

std::optional<Overload> Dispatcher::reserve(std::uint64_t bytes, MemoryBudget::Reservation& reservation) {
  reservation = MemoryBudget::Reservation(working_);
  if (reservation.grow_to(std::min(bytes, working_.capacity()))) return std::nullopt;
  return Overload{"The computations in progress hold " + std::to_string(working_.used()) +
                      " bytes by estimate, and this one needs " + std::to_string(bytes) + ".",
                  whole_seconds(pool_.predicted_wait(Priority::kBatch).count())};
}

std::optional<Overload> Dispatcher::run(const ExpectedWork& work, const Terms& terms,
                                        std::function<void()> job) {
  const auto held = std::make_shared<MemoryBudget::Reservation>();
  std::optional<Overload> overload = refuses(work.seconds, terms);
  if (!overload) overload = reserve(work.bytes, *held);
  if (overload) {
    ++refused_;
    return overload;
  }
  const auto metered = [this, cost = work.seconds, job = std::move(job), held, payer = terms.payer,
                        priority = terms.priority](int) {
    Spent spent;
    {
      const Meter meter(spent);
      job();
    }
    pool_.measured(cost, spent.busy_seconds);
    Payers payers;
    payers.add(payer);
    charge(payers, payer.flow, priority, spent.processor_seconds, cost);
  };
  pool_.submit(terms.priority, work.seconds, metered, terms.payer.flow);
  return std::nullopt;
}

}  // namespace fracture
