// Admission and charging: the part of the dispatcher that computes nothing.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <new>
#include <utility>

#include "common/hits/delta.hpp"
#include "server/service/computation.hpp"
#include "server/service/estimate.hpp"
#include "server/service/solid_figures.hpp"

namespace fracture {
namespace {

// Factor on the predicted wait. A request that is admitted and then misses its deadline has taken time from others, so it
// is better to refuse a few too many. (Measured with bench_overload at four times the capacity.)
constexpr double kCaution = 1.2;

// Maximum bytes of a computation that counts as small: enough for some hundred fragments of a stored mesh with ten thousand
// triangles.
constexpr std::uint64_t kLargestSmall = 16u << 20;

std::chrono::seconds whole_seconds(double seconds) {
  return std::chrono::seconds(static_cast<int>(std::clamp(std::ceil(seconds), 1.0, 60.0)));
}

std::string in_seconds(double seconds) {
  char text[48];
  std::snprintf(text, sizeof text, "%.3g s", seconds);
  return text;
}

}  // namespace

std::optional<Error> Dispatcher::refuses(double cost, const Terms& terms) const {
  const Flow& flow = terms.payer.flow;
  const double wait = pool_.predicted_wait(terms.priority, flow, cost).count();
  const double total = kCaution * wait + pool_.predicted_run(flow.name, cost).count();
  if (pool_.full(terms.priority, flow))
    return overloaded("The queue is full: " + std::to_string(pool_.queued()) +
                          " computations are waiting, and " + std::to_string(pool_.running()) +
                          " are running.",
                      whole_seconds(wait));
  const std::chrono::duration<double> left = terms.deadline - Clock::now();
  // If nothing is ahead of it, the request is tried, because the prediction may be wrong.
  if (terms.deadline != Clock::time_point::max() && wait > 0 && total > left.count())
    return overloaded("This work would be finished in about " + in_seconds(total) +
                          ", but the deadline of this request passes in " +
                          in_seconds(std::max(0.0, left.count())) + ".",
                      whole_seconds(total - left.count()));
  return std::nullopt;
}

Expected<ExpectedWork> Dispatcher::work_of(const FractureRequest& request, const RequestKeys& keys,
                                           const PreparedMesh* mesh, bool& is_provisional) {
  const RequestParameters& asked = request.parameters;
  is_provisional = false;
  if (!mesh) return work_of(request, keys, input_bytes(request.mesh, request.files), nullptr);
  const auto is_short = [&](int evaluations) {
    return seconds_of_estimate(asked.fracture, mesh->solid, evaluations) <= kEstimateInline;
  };
  if (is_short(kEvaluationsIfItFits)) {
    const SolidFigures figures(mesh->solid);
    if (fits(asked, figures, most_bytes())) return work_of(request, keys, 0, &figures);
    if (is_short(kEvaluationsWithAdvice))
      if (auto error = cannot_fit(asked, figures, most_bytes()))
        return tl::unexpected<Error>(std::move(*error));
  }
  is_provisional = true;
  return work_of(request, keys, 0, nullptr);
}

ExpectedWork Dispatcher::work_of(const FractureRequest& request, const RequestKeys& keys,
                                 std::uint64_t unread, const SolidFigures* figures) {
  const FractureParameters& fracture = request.parameters.fracture;
  const Selection& selection = request.parameters.selection;
  const Solid* const solid = figures ? &figures->solid() : nullptr;
  ExpectedWork work = expected_work(fracture, unread, solid, request.triangles, selection, figures);
  if (!selection.new_hits) return work;
  const std::shared_ptr<const CutBase> kept = service_.find_diagram(keys);
  const auto* const before = kept ? std::get_if<FracturedBase>(kept.get()) : nullptr;
  const bool continues =  // otherwise, the answer before the hits is only compared with the one after them
      fracture.rest == LocalRest::kFractured || fracture.hits.size() > selection.new_hits->count;
  if (before && before->broken.rest == fracture.rest)
    return expected_hit_work(fracture, selection, solid, figures);
  if (!before && !continues) {
    const ExpectedWork earlier = expected_work(before_hits(fracture, selection.new_hits->count), unread,
                                               solid, request.triangles, selection, figures);
    work.seconds += earlier.seconds;
    work.bytes = std::max(work.bytes, earlier.bytes);
  }
  return work;
}

std::optional<Error> Dispatcher::refuses(const ExpectedWork& work, const Terms& terms) const {
  return refuses(work.seconds, terms);
}

std::optional<Error> Dispatcher::seat(const Terms& terms, tenants::Account::Seat& share) {
  if (!terms.payer.account || !terms.needs_seat) return std::nullopt;
  if (terms.seat && *terms.seat) {
    share = std::move(*terms.seat);
    return std::nullopt;
  }
  auto seat = terms.payer.account->begin_computation();
  if (!seat) return std::move(seat.error());
  share = std::move(*seat);
  return std::nullopt;
}

void Dispatcher::charge(const std::vector<Waits>& payers, double seconds) {
  for (const auto& [payer, priority] : payers) pool_.charge(priority, payer.turn(), seconds);
}

MemoryBudget::Divided Dispatcher::divided(std::uint64_t working_bytes) {
  const std::uint64_t headroom = working_bytes / 8;
  return {working_bytes, headroom, std::min<std::uint64_t>(headroom, kLargestSmall), /*even_parts=*/true};
}

std::uint64_t Dispatcher::share_of(std::uint64_t bytes) { return bytes - bytes / 4; }

MemoryBudget::Use Dispatcher::use_of(Priority priority) {
  return priority == Priority::kBackground ? MemoryBudget::Use::kBackground : MemoryBudget::Use::kWaitedFor;
}

ComputationAllowance::MakeRoom Dispatcher::make_room_for(const std::string& client) {
  // Maximum time to wait for computations that were given up. They end at their next poll and free their memory.
  static constexpr std::chrono::seconds kLongest{2};
  return [this, client](MemoryBudget::Reservation& memory, std::uint64_t bytes) {
    const auto gives_up = [&] {
      return memory.use() != MemoryBudget::Use::kBackground &&
             give_up_for(client, memory.verdict(), bytes - memory.bytes());
    };
    if (!gives_up()) return false;
    const MemoryLine::Claim claim(line_);
    const Away away(WorkerPool::turn());  // lets others compute in the meantime
    const Clock::time_point longest = Clock::now() + kLongest;
    do {
      if (!holders_.wait(client, longest)) break;
    } while (!memory.grow_to(bytes) && gives_up());
    return memory.grow_to(bytes);
  };
}

bool Dispatcher::give_up_for(const std::string& client, MemoryBudget::Verdict verdict, std::uint64_t bytes,
                             std::chrono::milliseconds least_age) {
  using Verdict = MemoryBudget::Verdict;
  if (verdict == Verdict::kFits || verdict == Verdict::kOverShare) return false;
  // If memory is left, but not for this client, at least one other computation must end.
  const std::uint64_t missing = std::max<std::uint64_t>(working_.whole().missing(bytes), 1);
  if (verdict == Verdict::kHeldInBackground) return holders_.give_up_background(client, missing);
  // A client that holds memory and wants more than its part ends no work of others.
  const bool any_standing = (verdict == Verdict::kHeldOverPart || working_.is_newcomer(client)) &&
                            holders_.give_up_standing(client, missing);
  if (verdict != Verdict::kHeldOverPart) return any_standing;
  return holders_.give_up_over_part(
      client, missing, working_.even_part(client),
      [this](const std::string& other) { return working_.held_by(other); }, least_age);
}

void Dispatcher::watch_line() noexcept {
  static constexpr std::chrono::milliseconds kLook{50};
  if (watches_line_.exchange(true)) return;
  try {
    timer_.at(Clock::now() + kLook, [this] {
      watches_line_ = false;
      line_.given_back();
      if (line_.size() > 0) watch_line();
    });
  } catch (const std::bad_alloc&) {  // the next work that waits, or the next memory given back, asks
    watches_line_ = false;
  }
}

std::optional<Error> Dispatcher::lacks_memory(std::uint64_t bytes, const Terms& terms,
                                              MemoryBudget::Limit limit) {
  using Verdict = MemoryBudget::Verdict;
  const std::string& client = terms.payer.flow.name;
  bytes = std::min(bytes, working_.whole().capacity());
  const Verdict verdict = working_.judge(client, bytes, use_of(terms.priority), limit);
  // Other work that holds the rest gives it up when this computation gets its turn.
  if (verdict == Verdict::kFits || verdict == Verdict::kHeldInBackground) return std::nullopt;
  const bool may_take =
      terms.may_wait_for_memory && use_of(terms.priority) == MemoryBudget::Use::kWaitedFor &&
      (verdict == Verdict::kHeldOverPart || (verdict == Verdict::kFull && working_.is_newcomer(client)));
  const std::uint64_t part = verdict == Verdict::kHeldOverPart ? working_.even_part(client) : UINT64_MAX;
  if (may_take &&
      holders_.could_give_up(client, std::max<std::uint64_t>(working_.whole().missing(bytes), 1), part,
                             [this](const std::string& other) { return working_.held_by(other); }))
    return std::nullopt;
  return lacking(verdict, bytes);
}

bool Dispatcher::waits_for_memory(const Terms& terms) {
  return terms.priority == Priority::kBatch && working_.is_newcomer(terms.payer.flow.name);
}

Error Dispatcher::lacking(MemoryBudget::Verdict verdict, std::uint64_t bytes) const {
  const MemoryBudget& working = working_.whole();
  const std::chrono::seconds later = whole_seconds(pool_.backlog(Priority::kBatch).count());
  if (verdict == MemoryBudget::Verdict::kOverShare)
    return Error{
        .code = ErrorCode::kOverShare,
        .detail =
            "This computation needs " + std::to_string(bytes) +
            " bytes, but this client's other computations use up its share of the working memory. All computations together "
            "use about " +
            std::to_string(working.used()) + " bytes. A client that is alone may use " +
            std::to_string(working_.share()) + " bytes.",
        .retry_after = later};
  Error error =
      overloaded("The computations in progress use about " + std::to_string(working.used()) +
                     " bytes of working memory, and this one needs " + std::to_string(bytes) + " bytes.",
                 later);
  error.extra = fracture::Figures(nlohmann::json{{"bytes", bytes}});
  return error;
}

}  // namespace fracture
