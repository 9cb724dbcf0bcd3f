// Jobs: fractures that nobody waits for on a connection (Prefer: respond-async, RFC 7240).
#include <atomic>

#include "server/http/api.hpp"

namespace fracture::http {
namespace {

/// How long an event stream may be silent: proxies close connections that are idle for long, and a client
/// that is gone is only noticed by writing to it.
constexpr std::chrono::seconds kKeepAlive{10};

nlohmann::ordered_json describe(const JobView& job, std::string_view request_id) {
  nlohmann::ordered_json document = {
      {"id", job.id}, {"state", name_of(job.state)}, {"stage", job.stage}, {"percent", job.percent}};
  if (job.queue_position) document["queue_position"] = *job.queue_position;
  if (job.result) document["result"] = "/fractures/sha256:" + job.result->key;
  if (job.error) document["error"] = nlohmann::ordered_json::parse(to_problem(*job.error).body(request_id));
  document["links"] = {{"self", "/jobs/" + job.id}, {"events", "/jobs/" + job.id + "/events"}};
  return document;
}

/// Server-sent events (WHATWG HTML, section 9.2): one for each change of the job, the last when it has
/// finished.
class JobEvents final : public BodyStream {
 public:
  JobEvents(Jobs& jobs, Timer& timer, std::string id, std::string request_id)
      : jobs_(jobs), timer_(timer), id_(std::move(id)) {
    state_->request_id = std::move(request_id);
  }

  void next(std::function<void(std::optional<std::string>)> ready) override {
    if (state_->ended) return ready(std::nullopt);
    // Whichever comes first, the change or the time, answers; the other one finds the seal broken.
    struct Once {
      std::function<void(std::optional<std::string>)> ready;
      std::atomic<bool> used{false};
    };
    const auto once = std::make_shared<Once>();
    once->ready = std::move(ready);
    const Timer::Id alarm = timer_.at(Timer::Clock::now() + kKeepAlive, [once] {
      if (!once->used.exchange(true)) once->ready(": nothing new\n\n");
    });
    const bool known =
        jobs_.watch(id_, state_->seen, [state = state_, once, alarm, &timer = timer_](const JobView& job) {
          if (once->used.exchange(true)) return;
          timer.cancel(alarm);
          // Nobody else touches the stream before ready() is called.
          state->seen = job.version;
          state->ended = job.finished();
          once->ready("id: " + std::to_string(job.version) +
                      "\nevent: " + (state->ended ? name_of(job.state) : "progress") +
                      "\ndata: " + describe(job, state->request_id).dump() + "\n\n");
        });
    if (!known && !once->used.exchange(true)) once->ready(std::nullopt);
  }

 private:
  Jobs& jobs_;
  Timer& timer_;
  const std::string id_;
  // Shared with the watcher, which may be called when the stream is gone with its session.
  struct State {
    std::string request_id;
    std::uint64_t seen = 0;
    bool ended = false;
  };
  const std::shared_ptr<State> state_ = std::make_shared<State>();
};

Problem no_job() { return Problem(HttpProblem::kNotFound, "This job is not (or no longer) known here."); }

}  // namespace

bool prefers_async(const RequestHead& head) {
  std::string_view field_rest;
  const std::string field = head.field("prefer");
  for (field_rest = field; !field_rest.empty();) {
    std::string_view item = field_rest.substr(0, field_rest.find(','));
    field_rest.remove_prefix(std::min(field_rest.size(), item.size() + 1));
    item = item.substr(0, item.find(';'));
    while (!item.empty() && (item.front() == ' ' || item.front() == '\t')) item.remove_prefix(1);
    while (!item.empty() && (item.back() == ' ' || item.back() == '\t')) item.remove_suffix(1);
    if (equals_ignoring_case(item, "respond-async")) return true;
  }
  return false;
}

Answered Api::start_job(const Request& request, FractureRequest asked, const Terms& terms) {
  const auto job = jobs_.start(std::move(asked), terms, owner_of(request));
  if (!job) return tl::unexpected<Problem>(to_problem(job.error()));
  Response response = Response::json(describe(*job, request.id), 202);
  response.headers.emplace_back("Location", "/jobs/" + job->id);
  response.headers.emplace_back("Preference-Applied", "respond-async");
  return response;
}

Answered Api::get_job(const Request& request) {
  const auto job = find_job(request);
  if (!job) return tl::unexpected<Problem>(no_job());
  Response response = Response::json(describe(*job, request.id));
  response.headers.emplace_back("Cache-Control", "no-store");
  return response;
}

Answered Api::delete_job(const Request& request) {
  if (!find_job(request) || !jobs_.cancel(request.admission.segment))
    return tl::unexpected<Problem>(no_job());
  Response response;
  response.status = 204;
  return response;
}

Answered Api::get_job_events(const Request& request) {
  if (!find_job(request)) return tl::unexpected<Problem>(no_job());
  Response response;
  response.content_type = "text/event-stream";
  response.headers.emplace_back("Cache-Control", "no-store");
  response.stream =
      std::make_shared<JobEvents>(jobs_, dispatcher_.timer(), request.admission.segment, request.id);
  return response;
}

}  // namespace fracture::http
