// Decisions made from the header alone, before any of the body is read.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <stop_token>

#include "common/base/printable.hpp"
#include "common/base/words.hpp"
#include "server/http/accept.hpp"
#include "server/http/api.hpp"
#include "server/http/content_coding.hpp"
#include "server/http/mesh_input.hpp"
#include "server/http/multipart.hpp"
#include "server/http/parameter_weight.hpp"
#include "server/http/prefer.hpp"

namespace fracture::http {
namespace {

/// Requests whose Priority field (RFC 9218) has an urgency up to this are realtime. 0 is the most urgent, 3
/// the default.
constexpr int kRealtimeUrgency = 2;

bool is_json(std::string_view content_type) { return media_type_of(content_type) == "application/json"; }

/// Returns the member u of the field, a dictionary such as "u=1, i". Returns nothing if it is absent or
/// malformed, because RFC 9218 requires malformed values to be ignored.
std::optional<int> urgency_of(std::string_view field) {
  while (!field.empty()) {
    std::string_view item = field.substr(0, field.find(','));
    field.remove_prefix(std::min(field.size(), item.size() + 1));
    while (!item.empty() && (item.front() == ' ' || item.front() == '\t')) item.remove_prefix(1);
    if (item.size() >= 3 && item.substr(0, 2) == "u=" && item[2] >= '0' && item[2] <= '7' &&
        (item.size() == 3 || item[3] == ' ' || item[3] == ';'))
      return item[2] - '0';
  }
  return std::nullopt;
}

/// Says if the path is on the other listener.
Problem no_path(Listener listener, const std::string& path) {
  const std::string what = "The path '" + printable(path.substr(0, 100)) + "' does not exist";
  const bool elsewhere = std::any_of(routes().begin(), routes().end(), [&](const Route& route) {
    return route.listener != listener && match(route, path).has_value();
  });
  if (elsewhere)
    return Problem(
        HttpProblem::kNotFound,
        what + (listener == Listener::kPublic ? " on the public port. Use the admin port (--admin-port)."
                                              : " on the admin port. Use the public port (--port)."));
  return Problem(HttpProblem::kNotFound, what + ". GET /openapi.json lists all paths.");
}

}  // namespace

Problem body_too_large(const Admission& admission, std::optional<std::uint64_t> bytes) {
  const std::string body =
      bytes ? "The body has " + counted(*bytes, "byte", "bytes") : "The body is too large";
  const std::string limit = grouped(admission.max_body);
  const Carries carries = admission.route->carries;
  if (carries == Carries::kNothing || carries == Carries::kQuery)
    return Problem(HttpProblem::kBodyTooLarge,
                   (bytes ? body : std::string("The request has a body")) +
                       ", but this path takes none. Send the request without a body.");
  if (admission.max_body == kMaxSmallBody)
    return Problem(HttpProblem::kBodyTooLarge, body + "; the limit for parameters is " + limit +
                                                   " bytes. Send fewer or shorter parameters.");
  return Problem(
      HttpProblem::kBodyTooLarge,
      body + "; the limit is " + limit + " bytes (--max-body). Send a smaller mesh, or raise the limit.");
}

Error Api::with_time(Error error, const Request& request, std::string_view advice) const {
  if (error.code != ErrorCode::kDeadlineExceeded) return error;
  if (const OrProblem<Terms> terms = terms_of(request))
    error.detail = "The work was stopped after " + terms->allowed + ". " + std::string(advice);
  return error;
}

bool makes_job(Operation operation, const RequestHead& head) {
  return (operation == Operation::kPostFracture || operation == Operation::kPostMeshFracture) &&
         preferences_of(head).respond_async;
}

bool goes_on_alone(Operation operation, const RequestHead& head) {
  return operation == Operation::kPutMesh || operation == Operation::kPostMesh || makes_job(operation, head);
}

Problem Api::no_memory(const MemoryBudget::Reservation& reservation) const {
  if (reservation.over_share())
    return Problem(ErrorCode::kOverShare,
                   "This client's other requests use up its share of the memory for bodies, so this body "
                   "does not fit. Send the request again when those requests are finished.")
        .with("Retry-After", "2");
  return Problem(
             ErrorCode::kOverloaded,
             "The requests in progress hold " + data_size(bodies_.whole().used()) +
                 " of the memory for bodies (--max-bodies), so this body does not fit now. Try again after "
                 "Retry-After.")
      .with("Retry-After", "2");
}

OrProblem<Admission> Api::admit(Listener listener, const RequestHead& head, const Payer& payer) const {
  Admission admission;
  std::string allow;
  const bool is_head = head.method == "HEAD";
  for (const Route& route : routes()) {
    if (route.listener != listener) continue;
    auto segment = match(route, head.path);
    if (!segment) continue;
    allow +=
        (allow.empty() ? "" : ", ") + std::string(route.method) + (route.method == "GET" ? ", HEAD" : "");
    if (route.method == head.method || (is_head && route.method == "GET")) {
      admission.route = &route;
      admission.segment = std::move(*segment);
    }
  }
  if (!admission.route) {
    for (const std::string_view known :
         {"GET", "HEAD", "POST", "PUT", "DELETE", "PATCH", "OPTIONS", "TRACE", "CONNECT"})
      if (head.method == known)
        return allow.empty() ? tl::unexpected<Problem>(no_path(listener, head.path))
                             : tl::unexpected<Problem>(Problem(HttpProblem::kMethodNotAllowed,
                                                               "This path supports only " + allow + ".")
                                                           .with("Allow", allow));
    return refuse(HttpProblem::kNotImplemented, "This server does not know the method '" +
                                                    shortened(printable(head.method)) +
                                                    "'. GET /openapi.json lists all paths and methods.");
  }
  admission.head_only = is_head;
  const Carries carries = admission.route->carries;
  const bool small = carries == Carries::kParameters ||
                     (carries == Carries::kMeshOrName && is_json(head.field("content-type")));
  admission.max_body = carries == Carries::kNothing || carries == Carries::kQuery ? 0
                       : small                                                    ? kMaxSmallBody
                                                                                  : limits_.max_body;

  auto query = parse_query(head.query);
  if (!query)
    return refuse(
        HttpProblem::kMalformedRequest,
        "The query has a malformed percent escape. Two hex digits must follow '%'; write %25 for a percent sign.");
  admission.query = std::move(*query);
  if (carries == Carries::kQuery) {
    // The handler checks the query itself.
  } else if (carries != Carries::kNothing) {
    // Check the parameters first, because their errors help the client most. A query that takes long is parsed
    // later, on the pool, with the body.
    const std::vector<RawParameter> given = raw_parameters(admission.query);
    if (parse_weight(head.query.size(), given, service_.parameters()) <= kParseInline)
      if (auto parsed = service_.parameters().parse(given); !parsed)
        return tl::unexpected<Problem>(to_problem(std::move(parsed.error())));
  } else if (!admission.query.empty()) {
    return tl::unexpected<Problem>(to_problem(
        {ErrorCode::kUnknownParameter, "This path takes no parameters.", admission.query.front().first}));
  }

  const auto representation = negotiate(head.field("accept"), admission.route->offers);
  if (!representation) {
    std::string list;
    for (const std::string_view offer : admission.route->offers)
      list += (list.empty() ? "" : ", ") + std::string(offer);
    return refuse(HttpProblem::kNotAcceptable,
                  "This path returns " + list + "; Accept must allow one of these types.");
  }
  admission.representation = *representation;

  if (head.content_length.value_or(0) > admission.max_body)
    return tl::unexpected<Problem>(body_too_large(admission, head.content_length));
  if (auto problem = refuse_body(head, admission, payer)) return tl::unexpected<Problem>(std::move(*problem));
  return admission;
}

std::optional<Problem> Api::refuse_body(const RequestHead& head, const Admission& admission,
                                        const Payer& payer) const {
  const Carries carries = admission.route->carries;
  if (carries == Carries::kNothing || carries == Carries::kQuery) return std::nullopt;
  if (!head.has_body()) {
    if (carries == Carries::kParameters) return std::nullopt;  // all parameters have defaults
    return to_problem({ErrorCode::kEmptyBody,
                       "The body is empty. Send the mesh file as the body, or as the part 'mesh' of a "
                       "multipart/form-data body.",
                       "mesh"});
  }
  if (auto coding = content_coding(head.field("content-encoding")); !coding) return std::move(coding.error());
  const std::string type = head.field("content-type");
  if (carries == Carries::kParameters) {
    if (is_json(type)) return std::nullopt;
    return Problem(HttpProblem::kUnsupportedMediaType,
                   "Send parameters as JSON, with Content-Type: application/json.")
        .with("Accept-Post", "application/json");
  }
  if (carries == Carries::kMeshOrName && is_json(type)) return std::nullopt;
  if (auto problem = refuse_media_type(head, admission)) return problem;
  return refuse_overload(head, admission, payer);
}

/// Refuses a large body that could not be processed in time, before it is read. A small body is always read,
/// because its answer may already be cached.
std::optional<Problem> Api::refuse_overload(const RequestHead& head, const Admission& admission,
                                            const Payer& payer) const {
  const std::uint64_t bytes = head.content_length.value_or(kSmallBody);
  OrProblem<Terms> terms = terms_of(head, *admission.route, payer);
  if (!terms) return std::move(terms.error());
  if (bytes <= kSmallBody) return std::nullopt;
  const std::vector<RawParameter> given = raw_parameters(admission.query);
  const auto parsed = parse_weight(head.query.size(), given, service_.parameters()) <= kParseInline
                          ? service_.parameters().parse(given)
                          : Expected<RequestParameters>();
  const ExpectedWork work =
      parsed ? expected_work(parsed->fracture, bytes, nullptr, 0, parsed->selection) : expected_work(bytes);
  std::optional<Error> overload = dispatcher_.refuses(work, *terms);
  if (overload) return to_problem(std::move(*overload));
  return std::nullopt;
}

OrProblem<Terms> Api::terms_of(const RequestHead& head, const Route& route, const Payer& payer,
                               std::chrono::steady_clock::time_point received) const {
  Terms terms;
  terms.priority = route.priority;
  if (const std::optional<int> urgency = urgency_of(head.field("priority")))
    terms.priority = *urgency <= kRealtimeUrgency ? Priority::kRealtime : Priority::kBatch;
  if (payer.account && !payer.account->shares().realtime) terms.priority = Priority::kBatch;
  // Jobs are less urgent than requests that a client waits for, so they have their own class and deadline.
  const bool job = makes_job(route.operation, head);
  if (job) terms.priority = Priority::kBackground;
  terms.payer = payer;
  std::chrono::milliseconds time = job                                     ? jobs_.config().deadline
                                   : terms.priority == Priority::kRealtime ? limits_.realtime_deadline
                                                                           : limits_.deadline;
  const char* setting = job                                     ? "--job-deadline"
                        : terms.priority == Priority::kRealtime ? "--realtime-deadline"
                                                                : "--deadline";
  if (const std::string given = head.field("request-timeout"); !given.empty()) {
    double seconds = 0;
    const auto [end, error] = std::from_chars(given.data(), given.data() + given.size(), seconds);
    if (error != std::errc{} || end != given.data() + given.size() || !(seconds > 0) || seconds > 86400)
      return tl::unexpected<Problem>(to_problem(
          {ErrorCode::kBadParameter,
           "Request-Timeout must be a number of seconds, more than 0 and at most 86,400; it was '" +
               shortened(printable(given)) + "'.",
           "Request-Timeout"}));
    const std::chrono::milliseconds own(static_cast<std::int64_t>(std::ceil(seconds * 1000)));
    if (own < time) setting = "the request's Request-Timeout";
    time = std::min(time, own);
  }
  terms.allowed = short_number(static_cast<double>(time.count()) / 1000) + " s (" + setting + ")";
  terms.deadline = received + time;
  return terms;
}

OrProblem<Terms> Api::terms_of(const Request& request, const std::stop_token& gone) const {
  OrProblem<Terms> terms = terms_of(request.head, *request.admission.route, request.payer, request.received);
  if (terms) {
    terms->gone = gone;
    terms->seat = request.seat;
  }
  return terms;
}

/// Refuses a raw body of unknown format before it is read.
std::optional<Problem> Api::refuse_media_type(const RequestHead& head, const Admission& admission) const {
  const std::string content_type = head.field("content-type"), type = media_type_of(content_type);
  if (type == "multipart/form-data") {
    if (multipart_boundary(content_type)) return std::nullopt;
    return Problem(
        HttpProblem::kMalformedMultipart,
        "The Content-Type has no valid boundary. HTTP libraries add the boundary if you do not set Content-Type "
        "yourself.");
  }
  for (const auto& [name, value] : admission.query)
    if (name == "format") return std::nullopt;
  const auto format = format_from_media_type(type);
  if (format && service_.parameters().formats().contains(*format)) return std::nullopt;
  return unknown_format(service_.parameters().formats(), type == "application/octet-stream" ? "" : type);
}

}  // namespace fracture::http
