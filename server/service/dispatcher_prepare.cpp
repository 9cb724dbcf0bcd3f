// Runs only the first two steps: reads and prepares a mesh that a client stores.
#include <algorithm>
#include <atomic>
#include <memory>
#include <optional>
#include <utility>

#include "server/service/computation.hpp"

namespace fracture {

/// A mesh that a client stores.
struct Dispatcher::Upload {
  FractureRequest request;
  RequestKeys keys;
  ExpectedWork work;
  tenants::Account::Seat share;
  MeshReply reply;
  MemoryBudget::Reservation memory{};  ///< empty if it did not have to wait for memory
};

/// An upload that waits for memory. It does not join a flight before it has the memory, because computations that hold memory
/// may wait for flights.
struct Dispatcher::Arrival : std::enable_shared_from_this<Arrival> {
  Arrival(Dispatcher& its_dispatcher, Upload its_upload, const Terms& its_terms)
      : dispatcher(its_dispatcher),
        upload(std::move(its_upload)),
        terms(its_terms),
        reply(upload.reply),
        early(its_dispatcher.timer_) {}

  /// Joins the line for memory, or a flight if the memory is free by now.
  void enter() {
    const auto self = shared_from_this();
    std::optional<MemoryBudget::Reservation> memory = dispatcher.line_.take(
        {.client = terms.payer.flow.name,
         .bytes = upload.work.bytes,
         .use = [priority = terms.priority] { return use_of(priority); },
         .given_up = [self] { return self->decided.load(); },
         .go_on = [self](MemoryBudget::Reservation later) { self->go_on(std::move(later)); }});
    if (memory) return go_on(std::move(*memory));
    dispatcher.watch_line();
    try {
      early.arm(weak_from_this(), terms);
    } catch (...) {
      if (!decided.exchange(true)) throw;
    }
  }
  void go_on(MemoryBudget::Reservation memory) {
    if (decided.exchange(true)) return give_back(std::move(memory));
    upload.memory = std::move(memory);
    const Expected<bool> joined = guarded([&]() -> Expected<bool> {
      dispatcher.prepare(std::move(upload), terms);
      return true;
    });
    if (!joined) reply(tl::unexpected<Error>(joined.error()));
  }
  void leave(ErrorCode code) {
    if (decided.exchange(true)) return;
    ++dispatcher.abandoned_;
    if (code == ErrorCode::kDeadlineExceeded) ++dispatcher.expired_;
    upload.share = {};
    dispatcher.line_.given_back();  // removes it from the line
    reply(tl::unexpected<Error>(to_error(Interrupted{code})));
  }

 private:
  void give_back(MemoryBudget::Reservation memory) {
    memory = {};
    dispatcher.line_.given_back();
  }

  Dispatcher& dispatcher;
  Upload upload;
  const Terms terms;
  const MeshReply reply;
  std::atomic<bool> decided{false};
  LeaveEarly early;
};

/// The preparation of one mesh, run by the leader of its flight.
struct Dispatcher::Preparation {
  Preparation(Dispatcher& its_dispatcher, std::shared_ptr<MeshFlights::Flight> its_flight)
      : dispatcher(its_dispatcher), flight(std::move(its_flight)) {}
  ~Preparation() { give_back(); }

  Dispatcher& dispatcher;
  const std::shared_ptr<MeshFlights::Flight> flight;
  FractureRequest request{};
  RequestKeys keys{};
  Terms terms{};
  ExpectedWork work{};
  MemoryBudget::Reservation memory{};  ///< until its turn comes, if it waited for memory
  std::optional<ComputationAllowance> working{};

  bool abandoned() const { return flight->stop().stop_requested(); }
  void give_back() {
    if (!working && memory.bytes() == 0) return;
    working.reset();
    memory = {};
    dispatcher.line_.given_back();
  }
  Outcome<PreparedMesh> make(int threads) {
    Execution execution;
    execution.threads = threads;
    execution.stop = flight->stop();
    execution.allowance = &working->allowance();
    execution.turn = WorkerPool::turn();
    execution.progress = terms.progress;
    WorkerPool::stands_still_while_wanted(execution);
    Spent spent;
    Outcome<PreparedMesh> made = guarded([&] {
      const Meter meter(spent);
      return dispatcher.service_.make_mesh(request, keys, execution);
    });
    if (!made) return made;
    made->processor_seconds = spent.processor_seconds;
    dispatcher.pool_.measured(terms.payer.flow.name, work.seconds, spent.busy_seconds);
    return made;
  }
  void land(Outcome<PreparedMesh> made) {
    give_back();
    WorkerPool::charge_by_now();
    flight->common.end();
    if (!made) made = tl::unexpected<Error>(told_to_all(std::move(made.error()), flight->common));
    dispatcher.meshes_.land(flight, made);
  }
};

std::optional<Error> Dispatcher::prepare(FractureRequest request, const Terms& terms, MeshReply reply) {
  RequestKeys keys = keys_of(request);
  if (auto mesh = service_.find_mesh(keys)) {
    reply(std::move(mesh));
    return std::nullopt;
  }
  const std::uint64_t unread = input_bytes(request.mesh, request.files);
  ExpectedWork work = expected_work(unread);
  work.bytes = std::min(work.bytes, working_.most_at_once());
  work.seconds += expected_further_seconds(request.parameters, unread);
  tenants::Account::Seat share;
  if (auto over = seat(terms, share)) {
    ++refused_;
    return over;
  }
  std::optional<Error> overload, lack;
  if (!meshes_.find(keys.mesh)) {
    overload = refuses(work.seconds, terms);
    lack = lacks_memory(work.bytes, terms);
  }
  const bool may_wait = !overload && waits_for_memory(terms);
  if (!overload && lack && !may_wait) overload = lack;
  if (overload) {
    ++refused_;
    return overload;
  }
  Upload upload{std::move(request), std::move(keys), work, std::move(share), std::move(reply)};
  const MemoryBudget::Verdict verdict = working_.judge(terms.payer.flow.name, work.bytes);
  const bool waits = lack || (may_wait && verdict != MemoryBudget::Verdict::kFits &&
                              verdict != MemoryBudget::Verdict::kHeldInBackground);
  if (waits)
    std::make_shared<Arrival>(*this, std::move(upload), terms)->enter();
  else
    prepare(std::move(upload), terms);
  return std::nullopt;
}

void Dispatcher::prepare(Upload upload, const Terms& terms) {
  using Waiter = Waiting<MeshFlights, std::shared_ptr<const PreparedMesh>>;
  const auto waiting = std::make_shared<Waiter>(*this, meshes_, std::move(upload.reply));
  waiting->share = std::move(upload.share);
  const auto seat =
      meshes_.join(upload.keys.mesh, [this, waiting, payer = terms.payer, priority = terms.priority](
                                         const Outcome<PreparedMesh>& outcome, MeshFlights::Role role) {
        if (outcome && role == MeshFlights::Role::kFollower)
          charge({{payer, priority}}, outcome->processor_seconds);
        if (outcome)
          waiting->answer(outcome->value);
        else
          waiting->answer(tl::unexpected<Error>(outcome.error()));
      });
  waiting->enter(seat, terms, [&] {
    if (seat.role == MeshFlights::Role::kLeader) {
      const auto p = std::make_shared<Preparation>(*this, seat.flight);
      p->request = std::move(upload.request);
      p->keys = std::move(upload.keys);
      p->terms = terms;
      p->work = upload.work;
      p->memory = std::move(upload.memory);
      seat.flight->common.lead(pool_, terms.payer.turn(), terms.priority, [&] {
        return pool_.submit(
            terms.priority, p->work.seconds, [this, p](int threads) { begin_mesh(p, threads); },
            terms.payer.turn(),
            [this, waits = Waits{terms.payer, terms.priority}](double seconds) { charge({waits}, seconds); });
      });
    } else {
      seat.flight->common.join(pool_, terms.priority, terms.payer.turn());
    }
  });
  if (upload.memory.bytes() == 0) return;
  upload.memory = {};  // another request prepares the mesh
  line_.given_back();
}

/// Does not wait for more memory, because a computation that holds memory may be waiting for this mesh. If memory is short, the
/// preparation fails, and that computation prepares the mesh itself.
void Dispatcher::begin_mesh(const std::shared_ptr<Preparation>& p, int threads) {
  if (p->abandoned()) return;
  const std::uint64_t bytes = std::min(p->work.bytes, working_.whole().capacity());
  p->land(guarded([&]() -> Outcome<PreparedMesh> {
    const std::string& client = p->terms.payer.flow.name;
    MemoryBudget::Reservation memory = std::move(p->memory);
    if (memory.bytes() == 0) memory = working_.begin(client, use_of(p->terms.priority));
    const ComputationAllowance::MakeRoom make_room = make_room_for(client);
    if (!memory.grow_to(bytes) && !make_room(memory, bytes))
      return tl::unexpected<Error>(lacking(memory.verdict(), bytes));
    p->working.emplace(working_.whole(), std::move(memory), make_room);
    return p->make(threads);
  }));
}

}  // namespace fracture
