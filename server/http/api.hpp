// What the server answers. Knows HTTP's meaning but no sockets: a session hands it the header (admit), then
// the whole request (start), and writes what comes back. admit.cpp decides from the header alone,
// prepare_body.cpp makes a body ready for its handler. The handlers stand in one file for each subject:
// api_discovery.cpp, api_fracture.cpp, api_jobs.cpp, api_meshes.cpp, api_metrics.cpp, api_results.cpp; who
// may see what in api_tenants.cpp.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/http/content_coding.hpp"
#include "server/http/held_buffers.hpp"
#include "server/http/limits.hpp"
#include "server/http/mesh_input.hpp"
#include "server/http/message.hpp"
#include "server/http/result_response.hpp"
#include "server/http/routes.hpp"
#include "server/jobs/jobs.hpp"
#include "server/ops/metrics.hpp"
#include "server/page/samples.hpp"
#include "server/service/client_shares.hpp"
#include "server/service/dispatcher.hpp"
#include "server/service/memory_budget.hpp"
#include "server/service/mesh_store.hpp"
#include "server/service/service.hpp"
#include "server/service/single_flight.hpp"
#include "server/tenants/ledger.hpp"

namespace fracture::http {

/// What a handler has to say: an answer, or nothing yet (it replies later), or a refusal.
using Answered = OrProblem<std::optional<Response>>;

/// Whether this asks for the page, which holds no secret.
bool is_page(Operation operation, const RequestHead& head);
/// Whether a job is made of this request (Prefer: respond-async).
bool makes_job(Operation operation, const RequestHead& head);
/// Whether it is done also when its client closes the connection: a job, or a mesh that is to be stored, is wanted
/// for itself and not for the answer.
bool goes_on_alone(Operation operation, const RequestHead& head);

class Api {
 public:
  using Reply = std::function<void(Response)>;

  Api(Dispatcher& dispatcher, const HttpLimits& limits, const StoreConfig& store = {},
      const JobsConfig& jobs = {});
  ~Api();

  /// Decides from the header alone, before any of the body is read: 404, 405, 406, 413, 415, bad parameters
  /// in the query, no room in the queue.
  OrProblem<Admission> admit(Listener listener, const RequestHead& head, const Payer& payer = {}) const;

  /// Answers through `reply`, which is called exactly once: before this returns or later, from any thread. A
  /// stop of `gone` says that nobody waits for the answer any more. A broken invariant becomes a 500 problem
  /// and a log line.
  void start(std::shared_ptr<Request> request, std::stop_token gone, Reply reply);
  /// The end: stops the jobs, then returns when nothing is computed any more and no reply is outstanding.
  void wait_idle();
  /// Goes on with the jobs that an earlier process left on the disk. `account_of` finds a name's account; it
  /// is called from any thread until stop_jobs().
  void resume_jobs(
      const std::function<std::shared_ptr<tenants::Account>(const std::string& name)>& account_of);
  /// Another server has the folder of the disk tier and the jobs, as a predecessor does while it drains. Until
  /// take_folder() gets it this server is not ready: it does not know the jobs that were promised.
  bool waits_for_folder() const { return service_.tiers().waits_for_folder() || jobs_.waits_for_folder(); }
  /// False while the other server has it: to be called again. kFileAccess when the folder cannot be used any more. By one
  /// thread at a time; blocks.
  Expected<bool> take_folder();
  /// Stops what was started with Prefer: respond-async: those on the disk go on after a restart, the others
  /// are cancelled.
  void stop_jobs() { jobs_.stop(); }
  /// Returns when what has become of the jobs is on the disk.
  void flush_jobs() { jobs_.flush(); }

  /// Whether browsers get the page. Before the first request.
  void show_page(bool shown) { page_ = shown; }
  bool shows_page() const { return page_; }
  /// What the page offers beside its own shapes. Before the first request.
  void offer(page::Samples samples) { samples_ = std::move(samples); }
  /// Not ready any more. Jobs of an earlier process that have not begun yet stay for the next one.
  void set_draining() {
    draining_ = true;
    jobs_.stop_resuming();
  }
  bool draining() const { return draining_; }
  bool ready() const { return !draining() && !waits_for_folder(); }
  /// Why this reservation could not grow.
  Problem no_memory(const MemoryBudget::Reservation& reservation) const;
  ClientShares& bodies() { return bodies_; }
  HeldBuffers& answers() { return answers_; }
  const MeshStore& meshes() const { return meshes_; }
  const Jobs& jobs() const { return jobs_; }
  const tenants::AnswerLedger& ledger() const { return ledger_; }
  ops::Metrics& metrics() { return metrics_; }
  const HttpLimits& limits() const { return limits_; }

 private:
  /// Of compressed answers: of several of one class who want the same one, one makes it.
  using VariantFlights = SingleFlight<std::shared_ptr<const FractureResult>>;
  struct VariantWaiter;

  /// Runs a handler and replies with what it returns, if anything; exceptions become problems.
  void answering(const Request& request, const Reply& reply,
                 const std::function<Answered()>& handle) noexcept;
  /// A step of a request on a thread of the pool, when its turn comes; answered there, or where its deadline
  /// or its client's leaving comes first.
  using Step = std::function<Answered(const Execution&)>;
  Answered on_pool(const ExpectedWork& work, const std::shared_ptr<Request>& request, const Terms& terms,
                   const Reply& reply, Step step);
  /// Goes on with so many bytes of parameters: here if they are at most `most`, else on the pool.
  Answered with_parameters(std::uint64_t bytes, std::uint64_t most, const std::shared_ptr<Request>& request,
                           const Terms& terms, const Reply& reply, std::function<Answered()> go_on);
  /// What a body takes to be made ready: hashed, decoded, taken apart.
  struct Preparation {
    std::string digest{};  ///< Content-Digest, of the bytes as they were sent; empty: nothing to check
    ContentCoding coding = ContentCoding::kIdentity;
    std::uint64_t expected = 0;  ///< bytes of the decoded body that are admitted
  };
  /// All of that in one step on the pool; then the request goes on. A body that decodes to more than was
  /// expected is admitted again for that.
  Answered prepare_body(const std::shared_ptr<Request>& request, const Preparation& preparation,
                        const std::stop_token& gone, const Reply& reply);
  Answered prepared_body(const std::shared_ptr<Request>& request, const Preparation& preparation,
                         const Execution& execution, const std::stop_token& gone, const Reply& reply);
  void write_metrics(ops::MetricWriter& writer) const;
  Answered dispatch(const std::shared_ptr<Request>& request, const std::stop_token& gone, const Reply& reply);

  /// Takes a mesh out of the body and goes on with it: on the pool, unless it is small and no form.
  using WithMesh =
      std::function<Answered(FractureRequest input, std::shared_ptr<Body> body, const Terms& terms)>;
  Answered with_mesh_input(const std::shared_ptr<Request>& request, const std::stop_token& gone,
                           const Reply& reply, WithMesh go_on);
  Answered post_fracture(const std::shared_ptr<Request>& request, const std::stop_token& gone,
                         const Reply& reply);
  /// What every way to ask for a fracture ends in.
  Answered fracture(const std::shared_ptr<Request>& request, FractureRequest asked, Terms terms,
                    const Reply& reply);
  /// What was computed, in the representation that the client asks for. `applied`: Preference-Applied.
  Answered answer_fracture(const std::shared_ptr<Request>& request, const FractureAnswer& answer,
                           const Terms& terms, const Reply& reply, const std::string& applied = "");
  Answered get_fracture(const std::shared_ptr<Request>& request, const std::stop_token& gone,
                        const Reply& reply);
  Answered found_result(const std::shared_ptr<Request>& request,
                        const std::shared_ptr<const FractureResult>& result, std::string_view cache_status,
                        const Reply& reply);
  /// Makes an answer of a result in the coding that the client accepts best, compressed on the pool where
  /// that has not been done yet, and replies with what `finish` makes of it.
  using Finish = std::function<Answered(Response)>;
  Answered send_result(const std::shared_ptr<Request>& request, std::shared_ptr<const FractureResult> result,
                       const Representation& representation, const Terms& terms, const Reply& reply,
                       Finish finish);

  Answered put_mesh(const std::shared_ptr<Request>& request, const std::stop_token& gone, const Reply& reply);
  /// Keeps a mesh that was prepared, out of its body.
  Answered store(const Request& request, const FractureRequest& asked, const PreparedMesh& prepared,
                 Body& body);
  Answered get_mesh(const Request& request);
  Answered delete_mesh(const Request& request);
  OrProblem<std::shared_ptr<const StoredMesh>> stored_mesh(const Request& request, std::string_view id);
  /// `text` holds parameters as JSON; an empty `id` stands there as "mesh".
  Answered fracture_stored(const std::shared_ptr<Request>& request, std::string_view text,
                           std::string_view id, const std::stop_token& gone, const Reply& reply);
  Answered fracture_stored_mesh(const std::shared_ptr<Request>& request,
                                const std::vector<RawParameter>& given, const std::string& id,
                                const Terms& terms, const Reply& reply);
  Problem mesh_is_not_held(HeldBuffers::Refusal refusal) const;

  /// Whose what this request makes is; "" where nobody is asked who it is, or names share everything.
  static std::string owner_of(const Request& request);
  /// Whose it counts as: the owner's, and where all share everything, the client's.
  static std::string holder_of(const Request& request);
  static MeshStore::Whose whose(const Request& request);
  /// May it see the answer of this key?
  bool may_see(const Request& request, const std::string& key);
  /// So that it may see what it asked for, once that is there.
  void enter_in_ledger(const Request& request, Terms& terms);
  /// This name may see the answer of this key from now on.
  void enter_in_ledger(const tenants::Account& account, const std::string& owner, const std::string& key,
                       std::uint64_t bytes);

  /// 202 when the job is accepted; with `wait` the answer itself where it is there in time.
  Answered start_job(const std::shared_ptr<Request>& request, FractureRequest asked, const Terms& terms,
                     const Reply& reply);
  static bool sees(const Payer& payer, const JobView& job);
  std::optional<JobView> find_job(const Request& request);
  /// Why a job is not there.
  Problem no_job() const;
  Answered get_jobs(const std::shared_ptr<Request>& request, const std::stop_token& gone, const Reply& reply);
  Response list_jobs(const Jobs::Filter& filter, std::size_t limit, const std::string& request_id);
  Answered get_job(const std::shared_ptr<Request>& request, const std::stop_token& gone, const Reply& reply);
  Answered delete_job(const Request& request);
  Answered get_job_events(const Request& request);
  Response get_index() const;
  /// A file of client/page, or why there is none.
  OrProblem<Response> get_page(const Request& request, std::string_view path) const;
  Response get_version() const;
  Response get_limits() const;
  Response get_patterns() const;
  Response get_openapi() const;
  Response get_llms() const;
  OrProblem<Response> get_problem(const Request& request) const;
  nlohmann::ordered_json describe_limits() const;
  OrProblem<Response> get_readyz() const;
  std::optional<Problem> refuse_media_type(const RequestHead& head, const Admission& admission) const;

  /// Deadline and class of a request, from its header; no higher a class than its name may have. `received`:
  /// when the deadline begins.
  OrProblem<Terms> terms_of(
      const RequestHead& head, const Route& route, const Payer& payer,
      std::chrono::steady_clock::time_point received = std::chrono::steady_clock::now()) const;
  OrProblem<Terms> terms_of(const Request& request, const std::stop_token& gone = {}) const;
  std::optional<Problem> refuse_overload(const RequestHead& head, const Admission& admission,
                                         const Payer& payer) const;
  std::optional<Problem> refuse_body(const RequestHead& head, const Admission& admission,
                                     const Payer& payer) const;
  void sweep_later();

  Dispatcher& dispatcher_;
  FractureService& service_;
  const HttpLimits limits_;
  ClientShares bodies_;
  HeldBuffers answers_;
  MeshStore meshes_;
  HeldBuffers held_meshes_;  ///< stored meshes that requests use, which the store cannot let go
  tenants::AnswerLedger ledger_;
  Jobs jobs_;
  std::string limits_text_, patterns_text_;  ///< made once: they are long and never change
  VariantFlights variants_;
  bool page_ = true;
  page::Samples samples_;
  std::atomic<bool> draining_{false}, closing_{false};
  ops::Metrics metrics_;
};

/// An error as an answer; what is a bug of ours is logged.
Response refusal(Error error, std::string_view request_id);

/// The OpenAPI document as JSON, generated from proto/openapi.yaml at build time.
std::string_view openapi_json();
/// interface.md, operations and parameters.md in one: what a client is written from.
std::string_view llms_txt();

}  // namespace fracture::http
