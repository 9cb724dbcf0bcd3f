#include "server/bake/remote_baker.hpp"

#include <condition_variable>
#include <mutex>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "common/base/json_reader.hpp"
#include "common/base/json_text.hpp"
#include "common/exchange/headers.hpp"
#include "common/exchange/stored_meshes.hpp"
#include "common/pipeline/algorithm_version.hpp"
#include "server/bake/failure.hpp"
#include "server/bake/form.hpp"

namespace fracture::bake {
namespace {

using protocol::Exchange;
using protocol::HttpRequest;
using protocol::ProblemDocument;
using protocol::PutOnce;
using Clock = std::chrono::steady_clock;

/// Timeouts in milliseconds. kLong: an upload, a download or a fracture request that is waited for. kEvents:
/// an event stream, in which the server sends something every ten seconds.
constexpr std::chrono::milliseconds kLong{180'000}, kEvents{30'000};
/// Maximum attempts for one output: a mesh may have to be uploaded, a server may restart or forget a job or
/// result.
constexpr int kMostTries = 30;
/// Few attempts after a passed deadline: either the farm was full, or the mesh needs more time than allowed.
constexpr int kMostDeadlines = 3;
/// Limits for JSON from a server, which may be any program. GET /limits is the deepest document.
constexpr JsonLimits kOfAServer{.depth = 16};

tl::unexpected<Error> broken(std::string detail) { return fail(ErrorCode::kInternal, std::move(detail)); }

tl::unexpected<Error> refused(int status, const ProblemDocument& problem) {
  return tl::unexpected<Error>(to_error(status, problem));
}
tl::unexpected<Error> refused(const Exchange& exchange) {
  return refused(exchange.status, problem_of(exchange));
}

/// Returns the data of the last event in a stream (server-sent events as our server writes them), or null if
/// there is none.
nlohmann::json last_event(std::string_view stream) {
  constexpr std::string_view kData = "data: ";
  for (std::size_t at = stream.rfind(kData); at != std::string_view::npos; at = stream.rfind(kData, at - 1)) {
    if (at == 0 || stream[at - 1] == '\n') {
      const std::string_view line =
          stream.substr(at + kData.size(), stream.find('\n', at) - at - kData.size());
      return json_or_null(line, kOfAServer);
    }
    if (at == 0) break;
  }
  return nullptr;
}

const char* type_of(OutputFormat format) {
  return format == OutputFormat::kGltf ? "model/gltf+json" : "model/gltf-binary";
}

/// PutOnce for threads that block.
class Puts {
 public:
  /// Called for a mesh that was missing when a thread asked at `asked`. Returns true if the caller must
  /// upload it and then call done(); false if another thread has uploaded it in the meantime, perhaps before
  /// the reply arrived.
  bool begin(const std::string& mesh, Clock::time_point asked, const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    const PutOnce::Role role = puts_.begin(mesh, asked);
    if (role == PutOnce::Role::kWait) changed_.wait(lock, stop, [&] { return !puts_.pending(mesh); });
    return role == PutOnce::Role::kPut;
  }
  void done(const std::string& mesh, bool stored) {
    const std::lock_guard lock(mutex_);
    puts_.done(mesh, stored);
    changed_.notify_all();
  }

 private:
  std::mutex mutex_;
  std::condition_variable_any changed_;
  PutOnce puts_;
};

/// Handles one output, from the first request to the verified file.
class Conversation {
 public:
  Conversation(PatientCaller& caller, Puts& puts, const FractureRequest& request, const std::stop_token& stop)
      : caller_(caller),
        puts_(puts),
        request_(request),
        stop_(stop),
        keys_(keys_of(request)),
        mesh_("sha256:" + keys_.digest),
        result_("/fractures/sha256:" + keys_.result),
        parameters_(canonical_parameters(request.parameters)) {}

  Expected<Baked> operator()() {
    bool whole = json_text(parameters_).size() > protocol::kMaxParameterBytes;
    for (int tries = 0, deadlines = 0; tries < kMostTries; ++tries) {
      // The first two retries supply something that was missing. Later ones mean trouble, so wait first.
      if (tries > 2) caller_.pause(caller_.patience().first_pause * tries, stop_);
      Expected<Step> step = whole ? ask_with_mesh() : ask_by_job();
      if (!step) return tl::unexpected<Error>(std::move(step.error()));
      if (step->baked) return std::move(*step->baked);
      trouble_ = std::move(step->trouble);
      if (step->next == Next::kWhole) {
        if (whole) return broken(trouble_);
        whole = true;
      }
      if (step->next == Next::kDeadline && ++deadlines == kMostDeadlines)
        return tl::unexpected<Error>(std::move(*step->error));
    }
    // Not kUnavailable, because the server does respond: only this job fails.
    return broken("Tried " + std::to_string(kMostTries) + " times. " + trouble_);
  }

 private:
  enum class Next { kAgain, kWhole, kDeadline };
  /// The output, or how to continue.
  struct Step {
    std::optional<Baked> baked{};
    Next next = Next::kAgain;
    std::string trouble{};
    std::optional<Error> error{};  ///< for kDeadline
  };
  static Step again(std::string trouble) { return {.trouble = std::move(trouble)}; }
  static Step otherwise(const std::string& key) {
    return {
        .next = Next::kWhole,
        .trouble =
            "The server's response contains the address " + key +
            ", but this program expects a different one. The server may have stored the mesh in another format, or "
            "may run another version."};
  }

  std::vector<std::pair<std::string, std::string>> fields() const {
    return {{"Accept", type_of(request_.output)}, {"Priority", "u=5"}};  // batch work (RFC 9218)
  }

  Expected<Step> ask_by_job() {
    HttpRequest ask = protocol::fracture_request(mesh_, json_text(parameters_));
    ask.fields = fields();
    ask.fields.emplace_back("Prefer", "respond-async");
    const Clock::time_point asked = Clock::now();
    const Expected<Exchange> started = caller_.ask(ask, stop_);
    if (!started) return tl::unexpected(started.error());
    if (protocol::mesh_is_missing(started->status, problem_of(*started).slug())) return put_mesh(asked);
    if (started->status == 200) return file_of(*started);  // the server does not support respond-async
    if (started->status == 504) return late(problem_of(*started));
    if (started->status != 202) return refused(*started);
    nlohmann::json job = json_or_null(started->body, kOfAServer);
    const std::string id = job.is_object() ? job.value("id", "") : "";
    if (id.empty()) return again("The server responded with status 202, but its response contains no job.");
    if (const std::string state = job.value("state", ""); state == "queued" || state == "running") {
      const Expected<Exchange> events = caller_.ask({.target = "/jobs/" + id + "/events",
                                                     .fields = {{"Accept", "text/event-stream"}},
                                                     .answer_timeout = kEvents},
                                                    stop_);
      if (!events) {
        if (events.error().code == ErrorCode::kCancelled)
          caller_.tell(
              {.method = "DELETE", .target = "/jobs/" + id, .answer_timeout = std::chrono::seconds(1)});
        return tl::unexpected(events.error());
      }
      if (events->status != 200) return again("The server no longer has job " + id + ".");
      job = last_event(events->body);
    }
    return end_of(job);
  }

  Expected<Step> end_of(const nlohmann::json& job) {
    const std::string state = job.is_object() ? job.value("state", "") : "";
    if (state == "done") {
      if (job.value("result", "") != result_) return otherwise(job.value("result", ""));
      const Expected<Exchange> result =
          caller_.ask({.target = result_, .fields = fields(), .answer_timeout = kLong}, stop_);
      if (!result) return tl::unexpected(result.error());
      if (result->status == 200) return file_of(*result);
      if (result->status == 404) return again("The server no longer has the result of a job.");
      return refused(*result);
    }
    if (state != "failed" || !job.contains("error"))
      return again("A job ended without a result or an error.");
    const nlohmann::json& error = job.at("error");
    const int status = error.is_object() ? error.value("status", 500) : 500;
    const ProblemDocument problem = protocol::problem_in(error);
    if (status == 503) return again(problem.detail);
    if (status == 504) return late(problem);
    return refused(status, problem);
  }

  static Step late(const ProblemDocument& problem) {
    return {.next = Next::kDeadline, .trouble = problem.detail, .error = to_error(504, problem)};
  }

  Expected<Step> file_of(const Exchange& exchange) {
    if (!protocol::digest_matches(exchange.repr_digest, exchange.body))
      return again("The digest of an answer does not match its Repr-Digest header.");
    if (!exchange.content_location.empty() && exchange.content_location != result_)
      return otherwise(exchange.content_location);
    auto file = std::make_shared<const std::vector<std::uint8_t>>(exchange.body.begin(), exchange.body.end());
    AnswerSummary summary = summary_in(*file, request_.output);
    return Step{.baked = Baked{std::move(file), sha256(exchange.body), std::move(summary)}};
  }

  /// Builds the form with the mesh, its additional files and these parameters.
  Expected<Form> form(nlohmann::json parameters) const {
    const char* extension = extension_of(request_.format);
    parameters["format"] = extension;
    const std::string params = json_text(parameters);
    const auto text = [](std::span<const std::byte> bytes) {
      return std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    };
    std::vector<FormPart> parts{
        {.name = "mesh", .filename = std::string("mesh.") + extension, .body = text(request_.mesh)},
        {.name = "params", .body = params}};
    for (const ImportFile& file : request_.files)
      parts.push_back({.name = "file", .filename = file.name, .body = text(file.bytes)});
    return write_form(parts);
  }

  Expected<Step> put_mesh(Clock::time_point asked) {
    if (!puts_.begin(mesh_, asked, stop_))
      return again("This bake had uploaded the mesh for another job, but the server did not keep it.");
    const Expected<Exchange> put = send_mesh();
    puts_.done(mesh_, put && (put->status == 200 || put->status == 201));
    if (!put) return tl::unexpected(put.error());
    if (put->status == 504) return late(problem_of(*put));
    if (put->status != 200 && put->status != 201) return refused(*put);
    return again("The server did not keep the uploaded mesh.");
  }

  Expected<Exchange> send_mesh() {
    Expected<Form> body = form(canonical_solid_parameters(request_.parameters));
    if (!body) return tl::unexpected<Error>(body.error());
    HttpRequest put = protocol::put_request(mesh_, std::move(body->content_type),
                                            std::make_shared<const std::string>(std::move(body->body)));
    put.answer_timeout = kLong;
    return caller_.ask(put, stop_);
  }

  Expected<Step> ask_with_mesh() {
    Expected<Form> body = form(parameters_);
    if (!body) return tl::unexpected<Error>(body.error());
    const Expected<Exchange> answer =
        caller_.ask({.method = "POST",
                     .target = "/fracture",
                     .content_type = std::move(body->content_type),
                     .body = std::make_shared<const std::string>(std::move(body->body)),
                     .fields = fields(),
                     .answer_timeout = kLong},
                    stop_);
    if (!answer) return tl::unexpected(answer.error());
    if (answer->status == 200) return file_of(*answer);
    if (answer->status == 504) return late(problem_of(*answer));
    return refused(*answer);
  }

  PatientCaller& caller_;
  Puts& puts_;
  const FractureRequest& request_;
  const std::stop_token stop_;
  const RequestKeys keys_;
  const std::string mesh_;    ///< id
  const std::string result_;  ///< path
  const nlohmann::json parameters_;
  std::string trouble_;
};

class RemoteBaker : public Baker {
 public:
  explicit RemoteBaker(const RemoteConfig& config) : caller_(config.server, config.patience) {}

  Expected<void> greet(const std::string& server, const std::stop_token& stop) {
    const Expected<Exchange> version = caller_.ask({.target = "/version"}, stop);
    if (!version) return tl::unexpected(version.error());
    const nlohmann::json document = json_or_null(version->body, kOfAServer);
    const auto fail_with = [&](std::string why) {
      return fail(ErrorCode::kUnavailable, server + " " + std::move(why));
    };
    if (version->status != 200 || !document.is_object() || document.value("name", "") != "fracture-server")
      return fail_with("answers, but is not a fracture-server: GET /version returned status " +
                       std::to_string(version->status) + ".");
    const int algorithm = document.value("algorithm", 0);
    if (algorithm != kAlgorithmVersion)
      return fail_with("has algorithm version " + std::to_string(algorithm) +
                       ", and this program has version " + std::to_string(kAlgorithmVersion) +
                       ", so the same mesh would give different files. Use the same version.");
    const Expected<Exchange> limits = caller_.ask({.target = "/limits"}, stop);
    if (!limits) return tl::unexpected(limits.error());
    const nlohmann::json list = json_or_null(limits->body, kOfAServer);
    if (list.is_object() && list.contains("formats") && list.at("formats").is_array())
      for (const nlohmann::json& name : list.at("formats"))
        if (name.is_string()) formats_.insert(name.get<std::string>());
    return {};
  }

  /// Parses with this program's table. The server will check again with its own table, which has the same
  /// rows, so the result gets the same key.
  Expected<RequestParameters> parse(const std::vector<RawParameter>& given) override {
    return parse_parameters(table_, given);
  }

  Expected<Baked> bake(const FractureRequest& request, const Execution&,
                       const std::stop_token& stop) override {
    // Checked here because this message is clearer than the server's refusal of the parameter `format`.
    if (const std::string format = extension_of(request.format);
        !formats_.empty() && !formats_.contains(format))
      return fail(ErrorCode::kUnknownFormat, "The server does not read the format '" + format +
                                                 "': start the server with --enable-format " + format + ".");
    return Conversation(caller_, puts_, request, stop)();
  }

  void on_notice(std::function<void(const std::string&)> say) override { caller_.on_notice(std::move(say)); }

 private:
  PatientCaller caller_;
  Puts puts_;
  std::set<std::string> formats_;  ///< formats that the server reads; empty: unknown
  const ParameterTable table_{ServiceConfig{}.max_sites, FormatSet::all()};
};

}  // namespace

std::unique_ptr<Baker> unasked_remote_baker(const RemoteConfig& config) {
  return std::make_unique<RemoteBaker>(config);
}

Expected<std::unique_ptr<Baker>> remote_baker(const RemoteConfig& config, const std::stop_token& stop,
                                              const std::function<void(const std::string&)>& say) {
  auto baker = std::make_unique<RemoteBaker>(config);
  baker->on_notice(say);
  if (const Expected<void> greeted = baker->greet(config.server.url(), stop); !greeted)
    return tl::unexpected(greeted.error());
  return baker;
}

}  // namespace fracture::bake
