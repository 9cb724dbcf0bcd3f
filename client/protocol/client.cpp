#include "client/protocol/client.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "client/protocol/outcomes.hpp"
#include "common/base/error.hpp"
#include "common/base/json_text.hpp"
#include "common/exchange/backoff.hpp"
#include "common/exchange/connection_pool.hpp"
#include "common/exchange/headers.hpp"
#include "common/exchange/stored_meshes.hpp"

namespace fracture::protocol {
namespace {

using Clock = std::chrono::steady_clock;
using Outcome = Exchange::Outcome;

constexpr std::size_t kLatencies = 512;

struct StoredMesh {
  std::shared_ptr<const std::string> bytes;
  std::string content_type, query;
};

struct Job {
  RequestKind kind = RequestKind::kFracture;
  Ticket ticket = 0;
  std::string mesh;  ///< id
  HttpRequest request;
  Clock::time_point asked;
  Interruption interruption;
};

ConnectionSettings connections_of(const Settings& s) {
  return {.host = s.host,
          .port = s.port,
          .tls = nullptr,
          .token = s.token,
          .connections = s.connections,
          .connect_timeout = s.connect_timeout,
          .answer_timeout = s.answer_timeout,
          .idle = s.idle,
          .max_answer_bytes = s.max_answer_bytes};
}

}  // namespace

struct Client::State {
  explicit State(Settings given)
      : settings(std::move(given)), pool(io, connections_of(settings)), work(asio::make_work_guard(io)) {
    if (settings.heartbeat.count() > 0) asio::co_spawn(io, heartbeat(), asio::detached);
    thread = std::thread([this] { io.run(); });
  }
  ~State() {
    asio::post(io, [this] {
      stopping = true;
      for (const auto& [ticket, job] : jobs) job->interruption.request();
      beat.request();
      pool.close_idle();
      work.reset();
    });
    thread.join();  // every wait has been interrupted, so that all coroutines end by themselves
  }

  Ticket submit(std::shared_ptr<Job> job) {
    {
      const std::lock_guard lock(mutex);
      job->ticket = next_ticket++;
      ++shown.open;
    }
    job->asked = Clock::now();
    const Ticket ticket = job->ticket;
    asio::post(io, [this, job = std::move(job)]() mutable { start(std::move(job)); });
    return ticket;
  }

  // -- from here on: IO thread

  void start(std::shared_ptr<Job> job) {
    jobs.emplace(job->ticket, job);
    asio::co_spawn(
        io,
        [this, job]() -> asio::awaitable<void> {
          Answer answer = co_await run(*job);
          finish(*job, std::move(answer));
        },
        asio::detached);
  }

  void finish(const Job& job, Answer answer) {
    answer.ticket = job.ticket;
    answer.kind = job.kind;
    answer.milliseconds = std::chrono::duration<double, std::milli>(Clock::now() - job.asked).count();
    jobs.erase(job.ticket);
    const std::lock_guard lock(mutex);
    --shown.open;
    ++(answer.ok() ? shown.answered : shown.failed);
    if (!answer.ok() && answer.failure != Failure::kCancelled) shown.last_trouble = answer.detail;
    if (answer.ok() && job.kind == RequestKind::kFracture) {
      latencies[timed++ % kLatencies] = answer.milliseconds;
      shown.last_stages = answer.server_timing;
    }
    answers.push_back(std::move(answer));
  }

  void note(ServerState state, const std::string& trouble = {}) {
    const std::lock_guard lock(mutex);
    shown.state = state;
    shown.connections_made = pool.connections_made();
    if (!trouble.empty()) shown.last_trouble = trouble;
    heard = Clock::now();
  }
  void note_retry() {
    const std::lock_guard lock(mutex);
    ++shown.retried;
  }

  /// Performs one exchange and updates the server's state.
  asio::awaitable<Exchange> ask(const HttpRequest& request, Interruption& interruption) {
    Exchange exchange = co_await pool.exchange(request, interruption);
    switch (exchange.outcome) {
      case Outcome::kAnswered: {
        const bool busy = exchange.status == 503 || exchange.status == 429;
        note(busy ? ServerState::kOverloaded : ServerState::kReachable,
             busy ? "The server is busy (" + std::to_string(exchange.status) + ")." : "");
        break;
      }
      case Outcome::kInterrupted:
        break;
      case Outcome::kTooLarge:
        note(ServerState::kReachable, exchange.detail);
        break;
      case Outcome::kTimedOut:
        note(ServerState::kOverloaded, exchange.detail);
        break;
      case Outcome::kNoServer:
      case Outcome::kBroken:
        note(ServerState::kAbsent, exchange.detail);
        break;
    }
    co_return exchange;
  }

  asio::awaitable<Answer> run(Job& job) {
    Answer answer;
    const Clock::time_point deadline = job.asked + settings.patience;
    Backoff backoff(settings.first_pause, settings.longest_pause);
    int damaged = 0;
    bool put = job.kind == RequestKind::kStore;  // after a PUT, a 404 is the server's refusal
    while (true) {
      ++answer.exchanges;
      const Clock::time_point sent = Clock::now();
      const Exchange exchange = co_await ask(job.request, job.interruption);
      answer.status = exchange.status;
      answer.failure = failure_of(exchange.outcome);
      answer.detail = exchange.detail;
      Milliseconds wait = backoff.pause();
      if (exchange.outcome == Outcome::kAnswered) {
        if (exchange.status == 200 || exchange.status == 201) {
          std::optional<Error> wrong = damage(job.kind, exchange);
          answer.detail = wrong ? std::move(wrong->detail) : "";
          if (!wrong) {
            answer.server_timing = parse_server_timing(exchange.server_timing);
            answer.body = exchange.body;
            answer.location = exchange.content_location;
            if (job.kind == RequestKind::kStore) {
              const std::lock_guard lock(mutex);
              ++shown.meshes_stored;
            }
            co_return answer;
          }
          answer.failure = Failure::kDamaged;
          if (++damaged >= settings.damaged_answers) co_return answer;
          wait = Milliseconds(0);
        } else if (exchange.status == 503 || exchange.status == 429) {
          read_problem(exchange, answer);
          answer.failure = Failure::kOverloaded;
          wait = parse_retry_after(exchange.retry_after).value_or(backoff.pause());
        } else {
          read_problem(exchange, answer);
          answer.failure = Failure::kRefused;
          const bool forgotten = mesh_is_missing(exchange.status, answer.problem);
          if (!forgotten || put || job.kind != RequestKind::kFracture || meshes.count(job.mesh) == 0)
            co_return answer;
          wait = Milliseconds(0);
          if (const PutOnce::Role role = puts.begin(job.mesh, sent); role != PutOnce::Role::kRetry) {
            put = true;
            Answer stored = co_await store(job, role);
            answer.exchanges += stored.exchanges;
            if (!stored.ok()) {
              stored.exchanges = answer.exchanges;
              co_return stored;
            }
          }
        }
      } else if (exchange.outcome == Outcome::kTooLarge || exchange.outcome == Outcome::kInterrupted) {
        if (answer.failure == Failure::kCancelled) answer.detail = "Cancelled.";
        co_return answer;
      } else if (exchange.outcome == Outcome::kBroken && exchange.began) {
        answer.failure = Failure::kDamaged;
        if (++damaged >= settings.damaged_answers) co_return answer;
        wait = Milliseconds(0);
      }
      if (Clock::now() + wait > deadline) co_return answer;  // with the last failure
      note_retry();
      if (wait.count() > 0) {
        co_await pool.pause(wait, job.interruption);
        backoff.lengthen();
      }
      if (job.interruption.requested) {
        answer.failure = Failure::kCancelled;
        answer.detail = "Cancelled.";
        co_return answer;
      }
    }
  }

  /// Stores the job's mesh. The first job that lacks it sends the PUT, and the others wait for it.
  asio::awaitable<Answer> store(Job& job, PutOnce::Role role) {
    const std::string id = job.mesh;
    if (role == PutOnce::Role::kWait) {
      while (puts.pending(id) && !job.interruption.requested)
        co_await pool.pause(Milliseconds(2), job.interruption);
      co_return Answer{};
    }
    Job put;
    put.kind = RequestKind::kStore;
    put.mesh = id;
    const StoredMesh& mesh = meshes.at(id);
    put.request = put_request(id, mesh.content_type, mesh.bytes, mesh.query);
    put.asked = job.asked;
    // An interruption of the job also interrupts its PUT.
    job.interruption.wake = [&put] { put.interruption.request(); };
    Answer answer = co_await run(put);
    job.interruption.wake = nullptr;
    puts.done(id, answer.ok());
    co_return answer;
  }

  /// Checks whether the server is reachable while no request is running.
  asio::awaitable<void> heartbeat() {
    const HttpRequest version{.target = "/version"};
    while (!stopping) {
      const bool quiet = jobs.empty() && Clock::now() - heard >= settings.heartbeat;
      if (quiet) co_await ask(version, beat);
      if (!stopping) co_await pool.pause(settings.heartbeat, beat);
    }
  }

  const Settings settings;
  asio::io_context io{1};
  ConnectionPool pool;
  asio::executor_work_guard<asio::io_context::executor_type> work;
  std::map<Ticket, std::shared_ptr<Job>> jobs;
  std::map<std::string, StoredMesh> meshes;
  PutOnce puts;
  Interruption beat;
  Clock::time_point heard{};
  bool stopping = false;

  mutable std::mutex mutex;  ///< protects the following members
  Ticket next_ticket = 1;
  std::vector<Answer> answers;
  Status shown;
  std::array<double, kLatencies> latencies{};
  std::size_t timed = 0;

  std::thread thread;
};

Client::Client(Settings settings) : state_(std::make_unique<State>(std::move(settings))) {}
Client::~Client() = default;

std::string Client::add_mesh(std::string bytes, const std::string& content_type, const std::string& query,
                             Ticket* ticket) {
  const std::string id = mesh_id(bytes);
  auto shared = std::make_shared<const std::string>(std::move(bytes));
  asio::post(state_->io, [state = state_.get(), id, mesh = StoredMesh{shared, content_type, query}] {
    state->meshes.insert_or_assign(id, mesh);
  });
  auto job = std::make_shared<Job>();
  job->kind = RequestKind::kStore;
  job->mesh = id;
  job->request = put_request(id, content_type, shared, query);
  const Ticket given = state_->submit(std::move(job));
  if (ticket != nullptr) *ticket = given;
  return id;
}

Ticket Client::fracture(const std::string& mesh, const nlohmann::json& parameters) {
  auto job = std::make_shared<Job>();
  job->mesh = mesh;
  std::string text = json_text(parameters);
  if (text.size() > kMaxParameterBytes) {
    Answer answer;
    answer.failure = Failure::kTooLarge;
    answer.detail = "The parameters have " + std::to_string(text.size()) +
                    " bytes; the maximum for a request is " + std::to_string(kMaxParameterBytes) + ".";
    const std::lock_guard lock(state_->mutex);
    answer.ticket = state_->next_ticket++;
    ++state_->shown.failed;
    state_->answers.push_back(answer);
    return answer.ticket;
  }
  job->request = fracture_request(mesh, std::move(text));
  if (!state_->settings.realtime) job->request.fields.emplace_back("Priority", "u=3");  // RFC 9218
  return state_->submit(std::move(job));
}

Ticket Client::patterns() {
  auto job = std::make_shared<Job>();
  job->kind = RequestKind::kPatterns;
  job->request.target = "/patterns";
  return state_->submit(std::move(job));
}

void Client::cancel(Ticket ticket) {
  asio::post(state_->io, [state = state_.get(), ticket] {
    if (const auto job = state->jobs.find(ticket); job != state->jobs.end())
      job->second->interruption.request();
  });
}

std::vector<Answer> Client::poll() {
  std::vector<Answer> answers;
  const std::lock_guard lock(state_->mutex);
  answers.swap(state_->answers);
  return answers;
}

Status Client::status() const {
  Status status;
  std::vector<double> sorted;
  {
    const std::lock_guard lock(state_->mutex);
    status = state_->shown;
    status.fractures_timed = std::min(state_->timed, kLatencies);
    sorted.assign(state_->latencies.begin(),
                  state_->latencies.begin() + static_cast<std::ptrdiff_t>(status.fractures_timed));
  }
  if (sorted.empty()) return status;
  std::sort(sorted.begin(), sorted.end());
  // Nearest rank: at least this share of all values is not larger than the result.
  const auto rank = [&](double share) {
    const auto count = static_cast<double>(sorted.size());
    return sorted[static_cast<std::size_t>(std::max(0.0, std::ceil(share * count) - 1))];
  };
  status.p50_ms = rank(0.50);
  status.p99_ms = rank(0.99);
  return status;
}

}  // namespace fracture::protocol
