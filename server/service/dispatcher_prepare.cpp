// Runs only the first two steps: reads and prepares a mesh that a client stores.
#include <algorithm>
#include <utility>

#include "server/service/computation.hpp"

namespace fracture {

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
  std::optional<ComputationAllowance> working{};

  bool abandoned() const { return flight->stop().stop_requested(); }
  void give_back() {
    if (!working) return;
    working.reset();
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
  work.seconds += expected_further_seconds(request.parameters, unread);
  tenants::Account::Seat share;
  if (auto over = seat(terms, share)) {
    ++refused_;
    return over;
  }
  if (!meshes_.find(keys.mesh)) {
    std::optional<Error> overload = refuses(work.seconds, terms);
    if (!overload) overload = lacks_memory(work.bytes, terms);
    if (overload) {
      ++refused_;
      return overload;
    }
  }

  using Waiter = Waiting<MeshFlights, std::shared_ptr<const PreparedMesh>>;
  const auto waiting = std::make_shared<Waiter>(*this, meshes_, std::move(reply));
  waiting->share = std::move(share);
  const auto seat =
      meshes_.join(keys.mesh, [this, waiting, payer = terms.payer, priority = terms.priority](
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
      p->request = std::move(request);
      p->keys = std::move(keys);
      p->terms = terms;
      p->work = work;
      seat.flight->common.lead(pool_, terms.payer.turn(), terms.priority, [&] {
        return pool_.submit(
            terms.priority, work.seconds, [this, p](int threads) { begin_mesh(p, threads); },
            terms.payer.turn(),
            [this, waits = Waits{terms.payer, terms.priority}](double seconds) { charge({waits}, seconds); });
      });
    } else {
      seat.flight->common.join(pool_, terms.priority, terms.payer.turn());
    }
  });
  return std::nullopt;
}

/// Does not wait in the line for memory, because a computation that holds memory may be waiting for this mesh. If memory is
/// short, the preparation fails, and that computation prepares the mesh itself.
void Dispatcher::begin_mesh(const std::shared_ptr<Preparation>& p, int threads) {
  if (p->abandoned()) return;
  const std::uint64_t bytes = std::min(p->work.bytes, working_.whole().capacity());
  p->land(guarded([&]() -> Outcome<PreparedMesh> {
    const std::string& client = p->terms.payer.flow.name;
    MemoryBudget::Reservation memory = working_.begin(client, use_of(p->terms.priority));
    const ComputationAllowance::MakeRoom make_room = make_room_for(client);
    if (!memory.grow_to(bytes) && !make_room(memory, bytes))
      return tl::unexpected<Error>(lacking(memory.verdict(), bytes));
    p->working.emplace(working_.whole(), std::move(memory), make_room);
    return p->make(threads);
  }));
}

}  // namespace fracture
