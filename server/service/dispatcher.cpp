#include "server/service/dispatcher.hpp"

#include <algorithm>
#include <utility>

#include "server/service/computation.hpp"
#include "server/service/estimate.hpp"
#include "server/service/solid_figures.hpp"

namespace fracture {
namespace {

std::uint64_t bytes_of(const FractureRequest& request) { return input_bytes(request.mesh, request.files); }

}  // namespace

void Dispatcher::Common::tell(Stage stage, double fraction) {
  if (!observed.load(std::memory_order_relaxed)) return;
  const std::lock_guard lock(mutex);
  for (const auto& observer : observers)
    if (const auto listens = observer.lock()) (*listens)(stage, fraction);
}

void Dispatcher::Common::add(const std::shared_ptr<const Observer>& observer) {
  const std::lock_guard lock(mutex);
  std::erase_if(observers, [](const auto& gone) { return gone.expired(); });
  observers.push_back(observer);
  observed = true;
}

// -- requests

std::optional<Error> Dispatcher::fracture(FractureRequest request, const Terms& terms, FractureReply reply) {
  if (terms.answered)
    reply = [answered = terms.answered, reply = std::move(reply)](Expected<FractureAnswer> answer) {
      if (answer) answered(*answer->result);
      reply(std::move(answer));
    };
  RequestKeys keys = keys_of(request);
  if (auto wrong = wrong_mesh(request, keys)) {
    reply(tl::unexpected<Error>(std::move(*wrong)));
    return std::nullopt;
  }
  if (auto result = service_.find_result(keys.result)) {
    FractureAnswer answer;
    answer.result = std::move(result);
    answer.result_cache = CacheOutcome::kHit;
    reply(std::move(answer));
    return std::nullopt;
  }
  if (auto failure = service_.find_failure(keys.result)) {
    reply(tl::unexpected<Error>(std::move(*failure)));
    return std::nullopt;
  }

  tenants::Account::Seat share;
  if (auto over = seat(terms, share)) {
    ++refused_;
    return over;
  }
  // A request that joins a flight costs nothing more, so it is always admitted. If that flight lands before the request joins,
  // the request leads a flight of its own.
  double cost = 0;
  std::uint64_t bytes = 0;
  bool is_provisional = false;
  {
    const std::shared_ptr<const PreparedMesh> mesh = service_.find_mesh(keys);
    const Expected<ExpectedWork> work = work_of(request, keys, mesh.get(), is_provisional);
    if (!work) {
      reply(tl::unexpected<Error>(work.error()));
      return std::nullopt;
    }
    cost = work->seconds + expected_further_seconds(request.parameters, mesh ? 0 : bytes_of(request));
    bytes = std::max(std::min(work->bytes, working_.most_at_once()), terms.least_bytes);
    std::optional<Error> overload;
    if (!results_.find(keys.result)) {
      overload = refuses(cost, terms);
      if (!overload && !waits_for_memory(terms))
        overload = lacks_memory(bytes, terms, MemoryBudget::Limit::kAllFree);
    }
    if (overload) {
      ++refused_;
      return overload;
    }
  }

  using Waiter = Waiting<ResultFlights, FractureAnswer>;
  const auto waiting = std::make_shared<Waiter>(*this, results_, std::move(reply));
  waiting->share = std::move(share);
  const auto seat = results_.join(
      keys.result, [waiting](const Expected<FractureAnswer>& outcome, ResultFlights::Role role) {
        Expected<FractureAnswer> mine = outcome;
        if (mine && role == ResultFlights::Role::kFollower) mine->result_cache = CacheOutcome::kCollapsed;
        waiting->answer(std::move(mine));
      });
  waiting->enter(seat, terms, [&] {
    ResultFlights::Flight& flight = *seat.flight;
    // Earlier clients may already have been charged for part of this computation. This client owes the same amount.
    if (const double owed = flight.common.payers.add(terms.payer, terms.priority); owed > 0)
      charge({{terms.payer, terms.priority}}, owed);
    if (terms.progress) {
      waiting->observer = std::make_shared<const Observer>(terms.progress);
      flight.common.add(waiting->observer);
    }
    const Clock::rep deadline = terms.deadline.time_since_epoch().count();
    for (Clock::rep latest = flight.common.latest_deadline;
         latest < deadline && !flight.common.latest_deadline.compare_exchange_weak(latest, deadline);) {
    }
    if (seat.role == ResultFlights::Role::kLeader) {
      const auto c = std::make_shared<Computation>(*this);
      c->request = std::move(request);
      c->keys = std::move(keys);
      c->cost = cost;
      c->bytes = bytes;
      c->is_provisional = is_provisional;
      c->origin = terms.priority;
      c->flight = seat.flight;
      flight.common.urgency.lead(pool_, terms.payer.turn(), terms.priority, [&] {
        return pool_.submit(
            terms.priority, cost, [this, c](int threads) { at_station(c, [&] { begin(c, threads); }); },
            terms.payer.turn(), Computation::paid_by(c));
      });
    } else {
      ++collapsed_;
      flight.common.urgency.join(pool_, terms.priority, terms.payer.turn());
      line_.given_back();  // if the computation waits for memory, it may be more urgent now
    }
  });
  return std::nullopt;
}

// -- the stations of a computation

/// Obtains the value of this key, and then calls `next`. The value is computed here, unless another computation is already
/// computing it. In that case, this thread becomes free, and `next` runs on another thread when the value is ready.
template <class Value, class Make>
void Dispatcher::obtain(SingleFlight<Step<Value>, Urgency>& flights, const std::string& key, const Shared& c,
                        int threads, Make make,
                        void (Dispatcher::*next)(const Shared&, const Outcome<Value>&, int)) {
  using Flights = SingleFlight<Step<Value>, Urgency>;
  // Owned by the flight's waiter, like Waiting. It must not be part of `c`: after this thread has joined as a follower, `c`
  // may continue on another thread.
  struct Place {
    typename Flights::Seat seat;
    std::shared_ptr<ResultFlights::Flight> result;
    std::atomic<bool> waits{false};
    std::optional<std::stop_callback<std::function<void()>>> gives_up;
  };
  const auto place = std::make_shared<Place>();
  place->result = c->flight;
  // Leaves the part if this computation is given up. By then, waits_for() or lead_part() must have been called.
  const auto leave = [this, &flights, weak = std::weak_ptr(place)] {
    const auto left = weak.lock();
    if (!left || !flights.leave(left->seat)) return false;
    left->result->common.urgency.gives_up(pool_);
    withdraw_if_abandoned(*left->seat.flight, left->seat.flight->common);
    return true;
  };
  c->waits_by([leave, weak = std::weak_ptr(place)] {
    const auto waiting = weak.lock();
    return waiting && waiting->waits && leave();
  });
  const auto seat =
      flights.join(key, [this, c, next, place](const Outcome<Value>& outcome, typename Flights::Role role) {
        if (role == Flights::Role::kLeader) return;  // the leader continues below
        Outcome<Value> waited = outcome;
        if (waited) waited->cache = CacheOutcome::kCollapsed;
        const auto resumed = guarded([&]() -> Expected<bool> {
          if (waited) c->pay(waited->processor_seconds);  // the part was computed for all that waited
          c->flight->common.urgency.goes_on(pool_, [&](Priority priority, const Flow& flow) {
            return pool_.resume([this, c, next, waited = std::move(waited)](
                                    int free) { at_station(c, [&] { (this->*next)(c, waited, free); }); },
                                priority, c->cost, c->origin, flow, Computation::paid_by(c));
          });
          return true;
        });
        if (!resumed) return end(c, tl::unexpected<Error>(resumed.error()));
        end_if_given_up(c);
      });
  place->seat = seat;
  const auto watch_for_the_end = [&] {
    place->gives_up.emplace(place->result->stop(), [leave] { leave(); });
  };
  Urgency& mine = place->result->common.urgency;
  const std::shared_ptr<Urgency> part(seat.flight, &seat.flight->common);
  if (seat.role != Flights::Role::kLeader) try {
      mine.waits_for(pool_, part);
      watch_for_the_end();
      place->waits = true;
      return end_if_given_up(c);
    } catch (...) {
      if (!flights.leave(seat)) return;  // the computation has already continued
      mine.gives_up(pool_);
      throw;
    }
  Spent spent;
  // From here on, every failure must land the flight, because nobody else would.
  Outcome<Value> made = guarded([&] {
    mine.lead_part(pool_, part);
    watch_for_the_end();
    const Meter meter(spent);
    return make(c->execution(threads, seat.flight->stop()));
  });
  c->busy_seconds += spent.busy_seconds;
  if (made) made->processor_seconds = spent.processor_seconds;
  mine.end_part(pool_, *part);
  Outcome<Value> told = made;
  if (!told) told = tl::unexpected<Error>(told_to_all(std::move(told.error()), *part));
  flights.land(seat.flight, told);
  if (!made) c->tried_again = true;  // computing it here once more would end in the same way
  (this->*next)(c, made, threads);
}

void Dispatcher::begin(const Shared& c, int threads) {
  if (c->abandoned()) return;
  if (c->was_given_up()) return end(c, tl::unexpected<Error>(given_up()));
  Urgency& urgency = c->flight->common.urgency;
  const auto again = [this, c, &urgency] {
    urgency.goes_on(pool_, [&](Priority priority, const Flow& flow) {
      return pool_.resume([this, c](int free) { at_station(c, [&] { begin(c, free); }); }, priority, c->cost,
                          c->origin, flow, Computation::paid_by(c));
    });
    end_if_given_up(c);  // it got its memory before it was queued, so it may have been given up already
  };
  const auto priority_now = [&urgency] { return urgency.priority(); };
  if (!has_memory(c, urgency.turn().name, priority_now, c->bytes, again,
                  [this, c](const Error& error) { end(c, tl::unexpected<Error>(error)); }))
    return;
  const Clock::time_point now = Clock::now();
  // A computation that would miss its deadline because it waited is not begun. If the prediction never fitted, it is tried: the
  // first predictions for a client can be ten times too high.
  const auto run =
      std::chrono::duration_cast<Clock::duration>(pool_.predicted_run(urgency.turn().name, c->cost));
  const Clock::time_point deadline{Clock::duration(c->flight->common.latest_deadline.load())};
  if (now > deadline || (now + run > deadline && c->submitted + run <= deadline)) {
    ++expired_;
    return end(c, tl::unexpected<Error>(to_error(Interrupted{ErrorCode::kDeadlineExceeded})));
  }
  c->begun = now;
  c->answer.queue_milliseconds = std::chrono::duration<double, std::milli>(now - c->submitted).count();
  if (service_.has_tiers()) {
    MemoryBudget::Reservation reading(working_.whole());
    // If there is no room to read the result, it is computed within the memory that was set aside.
    service_.fetch_result(
        c->keys.result, c->answer, [&reading](std::uint64_t bytes) { return reading.grow_to(bytes); },
        c->execution(threads, c->flight->stop()), urgency.turn().name);
    if (c->answer.result) return end(c, std::move(c->answer));
  }
  obtain_mesh(c, threads);
}

void Dispatcher::obtain_mesh(const Shared& c, int threads) {
  if (auto mesh = service_.find_mesh(c->keys))
    return with_mesh(c, Step<PreparedMesh>{std::move(mesh), CacheOutcome::kHit, {}}, threads);
  // It began again, and the mesh has left the cache since it gave up its memory.
  if (!c->has_file) return end(c, tl::unexpected<Error>(given_up()));
  obtain<PreparedMesh>(
      meshes_, c->keys.mesh, c, threads,
      [this, c](const Execution& execution) -> Outcome<PreparedMesh> {
        // Another flight may have landed since the first look.
        if (auto mesh = service_.peek_mesh(c->keys))
          return Step<PreparedMesh>{std::move(mesh), CacheOutcome::kHit, {}, {}};
        return service_.make_mesh(c->request, c->keys, execution);
      },
      &Dispatcher::with_mesh);
}

void Dispatcher::with_mesh(const Shared& c, const Outcome<PreparedMesh>& mesh, int threads) {
  if (c->abandoned()) return;
  if (c->was_given_up()) return end(c, tl::unexpected<Error>(given_up()));
  if (!mesh && c->goes_on_without(mesh.error())) return obtain_mesh(c, threads);
  if (!mesh) return end(c, tl::unexpected<Error>(mesh.error()));
  c->answer.mesh_cache = mesh->cache;
  c->answer.timings.add(mesh->timings);
  c->mesh = mesh->value;
  const Execution execution = c->execution(threads, c->flight->stop());
  const SolidFigures figures(c->mesh->solid, execution);
  const auto revise = [&](const ExpectedWork& work) {
    c->cost = std::max(c->cost, work.seconds);
    pool_.revise(c->flight->common.urgency.task(), c->cost);
  };
  if (auto error = cannot_fit(c->request.parameters, figures, most_bytes()))
    return end(c, tl::unexpected<Error>(std::move(*error)));
  if (mesh->cache != CacheOutcome::kHit) {  // corrects the estimate that was based on the file's size
    const ExpectedWork work = expected_work(c->request.parameters.fracture, bytes_of(c->request),
                                            &c->mesh->solid, 0, c->request.parameters.selection, &figures);
    revise(work);
  } else if (c->is_provisional) {
    revise(work_of(c->request, c->keys, 0, &figures));
  }
  if (!failures_) {  // only the failure keeper would still need the file
    c->request.mesh = {};
    c->request.files.clear();
    c->request.owner.reset();
    c->has_file = false;
  }
  obtain_diagram(c, threads);
}

void Dispatcher::obtain_diagram(const Shared& c, int threads) {
  if (auto diagram = service_.find_diagram(c->keys))
    return with_diagram(c, Step<CutBase>{std::move(diagram), CacheOutcome::kHit, {}}, threads);
  obtain<CutBase>(
      diagrams_, c->keys.diagram, c, threads,
      [this, c](const Execution& execution) -> Outcome<CutBase> {
        if (auto diagram = service_.peek_diagram(c->keys))
          return Step<CutBase>{std::move(diagram), CacheOutcome::kHit, {}, {}};
        return service_.make_diagram(*c->mesh, c->request, c->keys, execution);
      },
      &Dispatcher::with_diagram);
}

void Dispatcher::with_diagram(const Shared& c, const Outcome<CutBase>& diagram, int threads) {
  if (c->abandoned()) return;
  if (c->was_given_up()) return end(c, tl::unexpected<Error>(given_up()));
  if (!diagram && c->goes_on_without(diagram.error())) return obtain_diagram(c, threads);
  if (!diagram) return end(c, tl::unexpected<Error>(diagram.error()));
  c->answer.diagram_cache = diagram->cache;
  c->answer.timings.add(diagram->timings);
  Expected<FracturedSolid> made;  // freed after the reply
  Spent spent;
  {
    const Meter meter(spent);
    made = guarded([&] {
      return service_.make_result(*c->mesh, *diagram->value, c->request, c->keys,
                                  c->execution(threads, c->flight->stop()), c->answer,
                                  c->flight->common.urgency.turn().name);
    });
  }
  if (!made) return end(c, tl::unexpected<Error>(std::move(made.error())));
  ++computed_;
  c->answer.work_milliseconds = std::chrono::duration<double, std::milli>(Clock::now() - c->begun).count();
  pool_.measured(c->flight->common.urgency.turn().name, c->cost, c->busy_seconds + spent.busy_seconds);
  end(c, std::move(c->answer));
}

std::vector<std::optional<std::size_t>> Dispatcher::queue_positions(
    const std::vector<std::string>& result_keys) const {
  std::vector<WorkerPool::TaskId> tasks;
  for (const std::string& key : result_keys) {
    const auto flight = results_.find(key);
    tasks.push_back(flight ? flight->common.urgency.task() : 0);
  }
  return pool_.positions(tasks);
}

Dispatcher::Figures Dispatcher::figures() const {
  return {computed_, collapsed_, abandoned_, expired_, refused_, results_.count(), working_.whole().used()};
}

}  // namespace fracture
