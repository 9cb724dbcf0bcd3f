// Jobs: fractures that run without a waiting connection (Prefer: respond-async, RFC 7240), or with a short
// wait.
#include <atomic>
#include <stop_token>

#include "common/base/json_text.hpp"
#include "common/base/words.hpp"
#include "server/http/api.hpp"
#include "server/http/job_document.hpp"
#include "server/http/job_wait.hpp"
#include "server/http/prefer.hpp"

namespace fracture::http {
namespace {

/// Longest silence of an event stream. Proxies close idle connections, and a client that is gone is only
/// noticed by writing to it.
constexpr std::chrono::seconds kKeepAlive{10};

/// Server-sent events (WHATWG HTML, section 9.2): one per change of the job, the last one when it has
/// finished.
class JobEvents final : public BodyStream {
 public:
  /// `sees`: returns whether the reader may still see the job; called before each event.
  using Sees = std::function<bool(const JobView&)>;
  JobEvents(Jobs& jobs, Timer& timer, std::string id, std::string request_id, Sees sees)
      : jobs_(jobs), timer_(timer), id_(std::move(id)) {
    state_->request_id = std::move(request_id);
    state_->sees = std::move(sees);
  }
  ~JobEvents() override { jobs_.unwatch(id_, watch_); }

  void next(std::function<void(std::optional<std::string>)> ready) override {
    if (state_->ended) return ready(std::nullopt);
    jobs_.unwatch(id_, watch_);  // the previous watch, if a keep-alive came before a change
    // The change and the timer race. The first one answers; the other one finds `used` set and does nothing.
    struct Once {
      std::function<void(std::optional<std::string>)> ready;
      std::atomic<bool> used{false};
    };
    const auto once = std::make_shared<Once>();
    once->ready = std::move(ready);
    const Timer::Id alarm = timer_.at(Timer::Clock::now() + kKeepAlive, [once] {
      if (!once->used.exchange(true)) once->ready(": nothing new\n\n");
    });
    const auto watch =
        jobs_.watch(id_, state_->seen, [state = state_, once, alarm, &timer = timer_](const JobView& job) {
          if (once->used.exchange(true)) return;
          timer.cancel(alarm);
          // This thread has the stream for itself until it calls ready().
          state->seen = job.version;
          const bool seen = state->sees(job);
          state->ended = job.finished() || !seen;
          if (!seen) return once->ready(std::nullopt);
          once->ready("id: " + std::to_string(job.version) +
                      "\nevent: " + (state->ended ? name_of(job.state) : "progress") +
                      "\ndata: " + json_text(describe(job, state->request_id)) + "\n\n");
        });
    if (watch)
      watch_ = *watch;
    else if (!once->used.exchange(true))
      once->ready(std::nullopt);
  }

 private:
  Jobs& jobs_;
  Timer& timer_;
  const std::string id_;
  // The watch of the last next() call. Atomic, because its answer, and the following next() call, may already
  // have come.
  std::atomic<Jobs::WatchId> watch_{0};
  // Shared with the watcher, which may be called after the stream and its session are gone.
  struct State {
    std::string request_id;
    Sees sees;
    std::uint64_t seen = 0;
    bool ended = false;
  };
  const std::shared_ptr<State> state_ = std::make_shared<State>();
};

Response job_response(const JobView& job, const std::string& request_id, int status) {
  Response response = Response::json(describe(job, request_id), status);
  response.headers.emplace_back("Cache-Control", "no-store");
  return response;
}

}  // namespace

Problem Api::no_job() const {
  if (waits_for_folder())
    return to_problem(overloaded(
        "This server does not know this job. Another server is still using the folder in which jobs are "
        "stored.",
        std::chrono::seconds(2)));
  return Problem(
      HttpProblem::kNotFound,
      "This server does not know this job. It may have been deleted: finished jobs are deleted after " +
          short_number(static_cast<double>(jobs_.config().ttl.count()) / 1000) +
          " s (--job-ttl). GET /jobs lists your jobs; to start a new job, send the request again.");
}

Answered Api::start_job(const std::shared_ptr<Request>& request, FractureRequest asked, const Terms& terms,
                        const Reply& reply) {
  const Preferences preferences = preferences_of(request->head);
  const auto accepted = [request, reply, preferences](const JobView& job) {
    Response response = job_response(job, request->id, 202);
    response.headers.emplace_back("Location", "/jobs/" + job.id);
    response.headers.emplace_back("Preference-Applied", applied(preferences));
    if (!job.finished()) response.headers.emplace_back("Retry-After", "1");
    reply(std::move(response));
  };
  const auto waited = [this, request, terms, reply, preferences, accepted](std::optional<JobView> job) {
    answering(*request, reply, [&]() -> Answered {
      if (!job) return tl::unexpected<Problem>(no_job());
      // If the client has left, the job stays in its list.
      if (!job->finished() || request->client_left.stop_requested()) {
        accepted(*job);
        return std::nullopt;
      }
      // The client gets the complete answer now, so the job is removed from its list.
      jobs_.cancel(job->id);
      // A job that was done (100 percent) has only lost its result.
      if (job->error && !(job->error->code == ErrorCode::kJobLost && job->percent == 100))
        return refusal(*job->error, request->id);
      if (!job->answer)
        return refusal(
            overloaded(
                "The result was deleted to make room for other results (--job-results) before it could be sent.",
                std::chrono::seconds(1)),
            request->id);
      return answer_fracture(request, *job->answer, terms, reply,
                             "wait=" + std::to_string(preferences.wait->count()));
    });
  };
  Jobs::Owner owner{owner_of(*request)};
  if (!owner.name.empty()) owner.share = request->payer.account->shares().stored_bytes;
  std::optional<Error> overload =
      jobs_.start(std::move(asked), terms, owner,
                  [this, request, terms, reply, preferences, accepted, waited](const JobView& job) {
                    answering(*request, reply, [&]() -> Answered {
                      if (!preferences.wait || preferences.wait->count() == 0)
                        accepted(job);
                      else if (job.finished())
                        waited(job);
                      else
                        wait_for_job(jobs_, dispatcher_.timer(), job.id,
                                     request->received + *preferences.wait, request->client_left, waited);
                      return std::nullopt;
                    });
                  });
  if (overload) return tl::unexpected<Problem>(to_problem(std::move(*overload)));
  return std::nullopt;
}

Answered Api::get_job(const std::shared_ptr<Request>& request, const std::stop_token& gone,
                      const Reply& reply) {
  const auto job = find_job(*request);
  if (!job) return tl::unexpected<Problem>(no_job());
  Preferences preferences = preferences_of(request->head);
  preferences.respond_async = false;  // nothing to start
  if (!preferences.wait || job->finished() || request->admission.head_only)
    return job_response(*job, request->id, 200);
  wait_for_job(jobs_, dispatcher_.timer(), job->id, request->received + *preferences.wait, gone,
               [this, request, reply, preferences](std::optional<JobView> later) {
                 answering(*request, reply, [&]() -> Answered {
                   if (!later || !sees(request->payer, *later)) return tl::unexpected<Problem>(no_job());
                   Response response = job_response(*later, request->id, 200);
                   response.headers.emplace_back("Preference-Applied", applied(preferences));
                   return response;
                 });
               });
  return std::nullopt;
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
      std::make_shared<JobEvents>(jobs_, dispatcher_.timer(), request.admission.segment, request.id,
                                  [payer = request.payer](const JobView& job) { return sees(payer, job); });
  return response;
}

}  // namespace fracture::http
