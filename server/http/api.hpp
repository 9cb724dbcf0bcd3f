// Answers the requests. It knows the meaning of HTTP but no sockets: a session passes it the header
// (admit()), then the whole request (start()), and writes the answer. admit.cpp decides from the header
// alone, and prepare_body.cpp prepares a body for its handler. Each subject has a file with its handlers:
// api_discovery.cpp, api_fracture.cpp, api_jobs.cpp, api_meshes.cpp, api_metrics.cpp and api_results.cpp.
// api_tenants.cpp decides what each client may see.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/http/compressions.hpp"
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
#include "server/tenants/ledger.hpp"

namespace fracture::http {

/// Result of a handler: an answer, nothing yet (it replies later), or a refusal.
using Answered = OrProblem<std::optional<Response>>;

/// Returns whether this is a request for the page, which contains no secrets.
bool is_page(Operation operation, const RequestHead& head);
/// Returns whether the request starts a job (Prefer: respond-async).
bool makes_job(Operation operation, const RequestHead& head);
/// Returns whether the request is completed even if its client closes the connection. This applies to jobs
/// and to uploads of meshes, because their results are kept on the server.
bool goes_on_alone(Operation operation, const RequestHead& head);

/// The answer to GET for a stored mesh.
struct MeshDescription {
  std::shared_ptr<const std::string> text;  ///< JSON
  std::uint64_t triangles = 0;              ///< of the solid
};

class Api {
 public:
  using Reply = std::function<void(Response)>;

  Api(Dispatcher& dispatcher, const HttpLimits& limits, const StoreConfig& store = {},
      const JobsConfig& jobs = {});
  ~Api();

  /// Decides from the header alone, before any of the body is read. Refusals: 404, 405, 406, 413, 415,
  /// invalid parameters in the query, and a full queue.
  OrProblem<Admission> admit(Listener listener, const RequestHead& head, const Payer& payer = {}) const;

  /// Answers through `reply`, which is called exactly once, from any thread, possibly before this function
  /// returns. `gone` requests a stop when no client waits for the answer any more. A broken invariant becomes
  /// a 500 problem and a log line.
  void start(std::shared_ptr<Request> request, std::stop_token gone, Reply reply);
  /// Stops the jobs, then returns when all computations have ended and all replies have been sent.
  void wait_idle();
  /// Resumes the jobs that an earlier process left on disk. `account_of` returns the account of a name; it
  /// may be called from any thread until stop_jobs().
  void resume_jobs(
      const std::function<std::shared_ptr<tenants::Account>(const std::string& name)>& account_of);
  /// Returns whether another server still holds the folder of the disk tier and the jobs, as a predecessor
  /// does while it drains. Until take_folder() succeeds, this server is not ready, because it does not know
  /// the accepted jobs.
  bool waits_for_folder() const { return service_.tiers().waits_for_folder() || jobs_.waits_for_folder(); }
  /// Tries to take over the folder. Returns false while the other server holds it; call again later. Returns
  /// kFileAccess if the folder cannot be used any more. Blocks; call from one thread at a time.
  Expected<bool> take_folder();
  /// Stops the jobs that were started with Prefer: respond-async. Jobs on disk continue after a restart; the
  /// others are cancelled.
  void stop_jobs() { jobs_.stop(); }
  /// Returns when the outcomes of all jobs have been written to disk.
  void flush_jobs() { jobs_.flush(); }

  /// Sets whether browsers get the page. Call before the first request.
  void show_page(bool shown) { page_ = shown; }
  bool shows_page() const { return page_; }
  /// Sets the sample files that the page offers in addition to its own shapes. Call before the first request.
  void offer(page::Samples samples) { samples_ = std::move(samples); }
  /// Makes the server not ready. Jobs from an earlier process that have not started yet are left for the next
  /// process.
  void set_draining() {
    draining_ = true;
    jobs_.stop_resuming();
  }
  bool draining() const { return draining_; }
  bool ready() const { return !draining() && !waits_for_folder(); }
  /// Returns the refusal for a reservation that could not grow.
  Problem no_memory(const MemoryBudget::Reservation& reservation) const;
  /// Counts an answer's bytes as held by this client (client_of() its address) until `hold` is destroyed.
  /// `hold` must be empty. Returns a refusal if the client may not hold that much. Small answers are not
  /// counted.
  std::optional<Problem> hold_answer(const std::string& address, const void* owner, std::uint64_t bytes,
                                     HeldBuffers::Hold& hold);
  ClientShares& bodies() { return bodies_; }
  HeldBuffers& answers() { return answers_; }
  const MeshStore& meshes() const { return meshes_; }
  const Jobs& jobs() const { return jobs_; }
  const tenants::AnswerLedger& ledger() const { return ledger_; }
  ops::Metrics& metrics() { return metrics_; }
  const HttpLimits& limits() const { return limits_; }

 private:
  /// Runs a handler and replies with what it returns, if anything; exceptions become problems.
  void answering(const Request& request, const Reply& reply,
                 const std::function<Answered()>& handle) noexcept;
  /// A step of a request that runs on a thread of the pool when its turn comes. The request is answered
  /// there, or earlier if its deadline passes or its client leaves.
  using Step = std::function<Answered(const Execution&)>;
  Answered on_pool(const ExpectedWork& work, const std::shared_ptr<Request>& request, const Terms& terms,
                   const Reply& reply, Step step);
  /// Runs `go_on`: on this thread if there are at most `most` bytes of parameters, else on the pool.
  Answered with_parameters(std::uint64_t bytes, std::uint64_t most, const std::shared_ptr<Request>& request,
                           const Terms& terms, const Reply& reply, std::function<Answered()> go_on);
  /// The steps that prepare a body: hashing, decoding and parsing.
  struct Preparation {
    std::string digest{};  ///< Content-Digest of the bytes as sent; empty: no check
    ContentCoding coding = ContentCoding::kIdentity;
    std::uint64_t expected = 0;  ///< decoded size for which the body is admitted
  };
  /// Prepares the body in one step on the pool, then continues with the request. If a body decodes to more
  /// bytes than expected, it is admitted again with a larger size.
  Answered prepare_body(const std::shared_ptr<Request>& request, const Preparation& preparation,
                        const std::stop_token& gone, const Reply& reply);
  Answered prepared_body(const std::shared_ptr<Request>& request, const Preparation& preparation,
                         const Execution& execution, const std::stop_token& gone, const Reply& reply);
  void write_metrics(ops::MetricWriter& writer) const;
  Answered dispatch(const std::shared_ptr<Request>& request, const std::stop_token& gone, const Reply& reply);

  /// Reads the mesh from the body and continues with it. This runs on the pool unless the body is small and
  /// is not a form.
  using WithMesh =
      std::function<Answered(FractureRequest input, std::shared_ptr<Body> body, const Terms& terms)>;
  Answered with_mesh_input(const std::shared_ptr<Request>& request, const std::stop_token& gone,
                           const Reply& reply, WithMesh go_on);
  Answered post_fracture(const std::shared_ptr<Request>& request, const std::stop_token& gone,
                         const Reply& reply);
  /// Computes a fracture. All kinds of fracture requests end here.
  Answered fracture(const std::shared_ptr<Request>& request, FractureRequest asked, Terms terms,
                    const Reply& reply);
  /// Answers with a computed result in the representation that the client requests. `applied`:
  /// Preference-Applied.
  Answered answer_fracture(const std::shared_ptr<Request>& request, const FractureAnswer& answer,
                           const Terms& terms, const Reply& reply, const std::string& applied = "");
  Answered get_fracture(const std::shared_ptr<Request>& request, const std::stop_token& gone,
                        const Reply& reply);
  Answered found_result(const std::shared_ptr<Request>& request,
                        const std::shared_ptr<const FractureResult>& result, std::string_view cache_status,
                        const Reply& reply);
  /// Builds the answer in the coding that the client prefers, then replies with the result of `finish`. If
  /// the compressed answer is not cached, it is compressed on the pool. `is_computed`: this request waited for
  /// the computation. Then the compression takes turns with the client's further computations, so that results
  /// do not pile up behind them. A request for a cached result waits in the queue instead, and is limited by it.
  using Finish = std::function<Answered(Response)>;
  Answered send_result(const std::shared_ptr<Request>& request, std::shared_ptr<const FractureResult> result,
                       const Representation& representation, const Terms& terms, const Reply& reply,
                       Finish finish, bool is_computed = false);

  Answered put_mesh(const std::shared_ptr<Request>& request, const std::stop_token& gone, const Reply& reply);
  /// Stores a prepared mesh and reuses the memory of its body. Throws Interrupted.
  Answered store(const Request& request, const FractureRequest& asked, const MeshDescription& description,
                 Body& body, const Execution& execution);
  Answered get_mesh(const Request& request);
  Answered delete_mesh(const Request& request);
  OrProblem<std::shared_ptr<const StoredMesh>> stored_mesh(const Request& request, std::string_view id);
  /// Fractures a stored mesh, or estimates that. `text`: parameters as JSON. If `id` is empty, the JSON contains the id as
  /// "mesh".
  Answered fracture_stored(const std::shared_ptr<Request>& request, std::string_view text,
                           std::string_view id, const std::stop_token& gone, const Reply& reply);
  Answered fracture_stored_mesh(const std::shared_ptr<Request>& request,
                                const std::vector<RawParameter>& given, const std::string& id,
                                const Terms& terms, const Reply& reply);
  /// Prepares the mesh, unless it is prepared, and answers with an estimate. Nothing is fractured.
  Answered estimate(const std::shared_ptr<Request>& request, FractureRequest asked, const Terms& terms,
                    const Reply& reply);
  Problem mesh_is_not_held(HeldBuffers::Refusal refusal) const;

  /// Returns the owner of what this request creates. Empty without authentication, or if all names share
  /// everything.
  static std::string owner_of(const Request& request);
  /// Returns whose quota this request uses: the owner's or, if all names share everything, the client's.
  static std::string holder_of(const Request& request);
  static MeshStore::Whose whose(const Request& request);
  /// Returns whether this request may see the answer with this key: its name has made or received it (AnswerLedger), or
  /// has a job that is done with it. A job's result counts for the limits on jobs, so `cached_bytes` does not apply to it.
  bool may_see(const Request& request, const std::string& key);
  /// Lets the owner of this request see the requested answer once it is computed.
  void enter_in_ledger(const Request& request, Terms& terms);
  /// Lets this name see the answer with this key from now on.
  void enter_in_ledger(const tenants::Account& account, const std::string& owner, const std::string& key,
                       std::uint64_t bytes);

  /// Replies with 202 if the job is accepted, or with the answer itself if it is ready within `wait`.
  Answered start_job(const std::shared_ptr<Request>& request, FractureRequest asked, const Terms& terms,
                     const Reply& reply);
  static bool sees(const Payer& payer, const JobView& job);
  /// Returns the refusal for a result that is not found although a job of this name was done with it (Jobs::lost_result).
  std::optional<Problem> lost_result(const Request& request, const std::string& key, bool nowhere = false);
  std::optional<JobView> find_job(const Request& request);
  /// Returns the refusal for a job that is not found.
  Problem no_job() const;
  Answered get_jobs(const std::shared_ptr<Request>& request, const std::stop_token& gone, const Reply& reply);
  Response list_jobs(const Jobs::Filter& filter, std::size_t limit, const std::string& request_id);
  Answered get_job(const std::shared_ptr<Request>& request, const std::stop_token& gone, const Reply& reply);
  Answered delete_job(const Request& request);
  Answered get_job_events(const Request& request);
  Response get_index() const;
  /// Returns a file of client/page, or a refusal if there is none.
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

  /// Returns the deadline and class of a request from its header. The class is limited to what the name may
  /// use. `received`: start of the deadline.
  OrProblem<Terms> terms_of(
      const RequestHead& head, const Route& route, const Payer& payer,
      std::chrono::steady_clock::time_point received = std::chrono::steady_clock::now()) const;
  OrProblem<Terms> terms_of(const Request& request, const std::stop_token& gone = {}) const;
  /// If the deadline passed, the error says how much time the request had, and which setting or field limited it.
  /// `advice`: what the client can do.
  Error with_time(
      Error error, const Request& request,
      std::string_view advice = "Ask for fewer sites, send a smaller mesh, or allow more time.") const;
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
  HeldBuffers held_meshes_;  ///< stored meshes in use by requests, which the store cannot free
  tenants::AnswerLedger ledger_;
  Jobs jobs_;
  std::string limits_text_, patterns_text_;  ///< built once, because they are long and constant
  Compressions compressions_;
  bool page_ = true;
  page::Samples samples_;
  std::atomic<bool> draining_{false}, closing_{false};
  ops::Metrics metrics_;
};

/// Says that the body has more bytes than its path takes. `bytes`: nothing if the size is not known.
Problem body_too_large(const Admission& admission, std::optional<std::uint64_t> bytes);

/// Converts an error to an answer. Logs bugs of the server and lack of memory.
Response refusal(Error error, std::string_view request_id);

/// The OpenAPI document as JSON, generated from proto/openapi.yaml at build time.
std::string_view openapi_json();
/// interface.md, the operations and parameters.md in one text: all that is needed to write a client.
std::string_view llms_txt();

}  // namespace fracture::http
