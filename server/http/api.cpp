#include "server/http/api.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <exception>
#include <new>

#include "server/http/accept.hpp"
#include "server/http/multipart.hpp"

namespace fracture::http {
namespace {

constexpr std::size_t kMaxParams = 64u << 10;  // bytes of the `params` part
constexpr std::size_t kMaxField = 16u << 10;   // bytes of a parameter as a field of its own
constexpr std::string_view kAcceptPost =
    "model/gltf-binary, model/gltf+json, model/obj, model/stl, application/octet-stream, multipart/form-data";
constexpr std::string_view kResultTypes[] = {"model/gltf-binary", "application/json", "model/gltf+json"};
constexpr std::string_view kStoredTypes[] = {"model/gltf-binary", "model/gltf+json"};
constexpr std::size_t kAsFigures = 1, kAsGltf = 2;  // of kResultTypes
constexpr std::string_view kJsonTypes[] = {"application/json"};
constexpr std::string_view kTextTypes[] = {"text/plain"};

constexpr Route kRoutes[] = {
    {Listener::kPublic, "GET", "/", Route::Runs::kInline, "What this is"},
    {Listener::kPublic, "GET", "/version", Route::Runs::kInline,
     "Versions of the server and of the algorithm"},
    {Listener::kPublic, "GET", "/limits", Route::Runs::kInline, "Limits, parameters and formats"},
    {Listener::kPublic, "GET", "/openapi.json", Route::Runs::kInline, "This interface as OpenAPI 3.1"},
    {Listener::kPublic, "POST", "/fracture", Route::Runs::kOnPool, "Fracture a mesh"},
    {Listener::kPublic, "GET", "/fractures/{id}", Route::Runs::kInline,
     "A result that is still in the cache"},
    {Listener::kAdmin, "GET", "/livez", Route::Runs::kInline, "The process answers"},
    {Listener::kAdmin, "GET", "/readyz", Route::Runs::kInline, "The server takes requests"},
};

bool matches(const Route& route, std::string_view path, std::string* segment) {
  const std::size_t brace = route.path.find('{');
  if (brace == std::string_view::npos) return route.path == path;
  if (path.size() <= brace || path.substr(0, brace) != route.path.substr(0, brace)) return false;
  const std::string_view rest = path.substr(brace);
  if (rest.find('/') != std::string_view::npos) return false;
  if (segment) *segment = rest;
  return true;
}

/// The media types a route can answer with, in order of preference.
std::span<const std::string_view> offers(const Route& route) {
  if (route.path == "/fracture") return kResultTypes;
  if (route.path == "/fractures/{id}") return kStoredTypes;
  if (route.path == "/livez" || route.path == "/readyz") return kTextTypes;
  return kJsonTypes;
}

Response json_response(const nlohmann::ordered_json& document) {
  return Response::text(200, "application/json", document.dump(2) + "\n");
}

std::string milliseconds(double ms) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f", ms);
  return text;
}

/// RFC 9211: the caches in the order the request meets them, nearest to the computation first.
std::string cache_status(const FractureAnswer& answer) {
  std::string value;
  const auto add = [&](const char* name, CacheOutcome outcome) {
    if (outcome == CacheOutcome::kNotConsulted) return;
    if (!value.empty()) value += ", ";
    value += name;
    if (outcome == CacheOutcome::kHit) value += "; hit";
    if (outcome == CacheOutcome::kMissStored) value += "; fwd=miss; stored";
    if (outcome == CacheOutcome::kMissNotStored) value += "; fwd=miss";
  };
  add("mesh", answer.mesh_cache);
  add("diagram", answer.diagram_cache);
  add("result", answer.result_cache);
  return value;
}

std::string server_timing(double queue, const StageTimings& timings) {
  std::string value = "queue;dur=" + milliseconds(queue);
  for (const char* stage : {"import", "prepare", "tetrahedralize", "clip", "encode"})
    value += std::string(", ") + stage + ";dur=" + milliseconds(timings.milliseconds(stage));
  return value;
}

/// Names and values of a JSON object. Refuses what is not one object, deep nesting, and a member given twice
/// (of which a JSON parser would silently keep one).
Expected<std::vector<RawParameter>> parse_params(std::string_view text) {
  if (text.size() > kMaxParams)
    return fail(ErrorCode::kBadJson, "The part 'params' is over " + std::to_string(kMaxParams) + " bytes.",
                "params");
  std::vector<std::string> names;
  bool too_deep = false;
  const auto watch = [&](int depth, nlohmann::json::parse_event_t event, nlohmann::json& parsed) {
    if (event == nlohmann::json::parse_event_t::key && depth == 1) names.push_back(parsed.get<std::string>());
    if (depth > 8) too_deep = true;
    return depth <= 8;
  };
  const nlohmann::json document =
      nlohmann::json::parse(text.begin(), text.end(), watch, /*allow_exceptions=*/false);
  if (document.is_discarded() || too_deep || !document.is_object())
    return fail(ErrorCode::kBadJson,
                "The part 'params' is not one JSON object such as {\"sites\": 50, \"seed\": 1}.", "params");
  std::vector<RawParameter> given;
  for (const std::string& name : names)
    given.push_back({name, document.value(name, nlohmann::json()), false});
  return given;
}

/// A filename as an asset would write it: forward slashes, no leading "./".
std::string file_name(std::string name) {
  std::replace(name.begin(), name.end(), '\\', '/');
  while (name.substr(0, 2) == "./") name.erase(0, 2);
  return name;
}

std::vector<RawParameter> raw_parameters(const std::vector<std::pair<std::string, std::string>>& query) {
  std::vector<RawParameter> given;
  given.reserve(query.size());
  for (const auto& [name, value] : query) given.push_back({name, value, true});
  return given;
}

Problem to_problem(Error error) {
  const ErrorCode code = error.code;
  Problem problem(std::move(error));
  if (code == ErrorCode::kUnknownFormat) problem.headers.emplace_back("Accept-Post", kAcceptPost);
  if (code == ErrorCode::kCancelled) problem.headers.emplace_back("Retry-After", "5");
  return problem;
}

Problem unknown_format(const FormatSet& formats, std::string_view given) {
  std::string names;
  for (const std::string& name : formats.names()) names += (names.empty() ? "" : ", ") + name;
  std::string detail = given.empty()
                           ? "The request does not say what format the mesh has."
                           : "'" + std::string(given) + "' names no mesh format that this server reads.";
  return to_problem(
      {ErrorCode::kUnknownFormat,
       detail + " Say it in Content-Type (for example model/gltf-binary) or as ?format= with one of " +
           names + ".",
       "format"});
}

}  // namespace

std::span<const Route> routes() { return kRoutes; }

Response Response::text(int status, std::string content_type, std::string body) {
  Response response;
  response.status = status;
  response.content_type = std::move(content_type);
  const auto text = std::make_shared<const std::string>(std::move(body));
  response.body = {reinterpret_cast<const std::uint8_t*>(text->data()), text->size()};
  response.owner = text;
  return response;
}

Response Response::problem(const Problem& problem, std::string_view request_id) {
  Response response = text(problem.type->status, "application/problem+json", problem.body(request_id));
  response.headers = problem.headers;
  return response;
}

Problem Api::overloaded() const {
  return Problem(HttpProblem::kOverloaded, "The queue is full: " + std::to_string(pool_.queued()) +
                                               " jobs wait and " + std::to_string(pool_.running()) +
                                               " run. Try again after Retry-After.")
      .with("Retry-After", std::to_string(pool_.retry_after().count()));
}

Problem Api::no_memory() const {
  return Problem(HttpProblem::kOverloaded, "The requests in progress hold " + std::to_string(bodies_.used()) +
                                               " bytes; there is no room for this body now.")
      .with("Retry-After", std::to_string(pool_.retry_after().count()));
}

OrProblem<Admission> Api::admit(Listener listener, const RequestHead& head) const {
  Admission admission;
  std::string allow;
  const bool is_head = head.method == "HEAD";
  for (const Route& route : kRoutes) {
    if (route.listener != listener || !matches(route, head.path, nullptr)) continue;
    allow +=
        (allow.empty() ? "" : ", ") + std::string(route.method) + (route.method == "GET" ? ", HEAD" : "");
    if (route.method == head.method || (is_head && route.method == "GET")) admission.route = &route;
  }
  if (!admission.route) {
    for (const std::string_view known :
         {"GET", "HEAD", "POST", "PUT", "DELETE", "PATCH", "OPTIONS", "TRACE", "CONNECT"})
      if (head.method == known)
        return allow.empty() ? tl::unexpected<Problem>(Problem(
                                   HttpProblem::kNotFound, "There is no path '" + head.path.substr(0, 100) +
                                                               "'. GET /openapi.json lists them."))
                             : tl::unexpected<Problem>(
                                   Problem(HttpProblem::kMethodNotAllowed, "This path answers " + allow + ".")
                                       .with("Allow", allow));
    return refuse(HttpProblem::kNotImplemented, "The method is not known here.");
  }
  matches(*admission.route, head.path, &admission.segment);
  admission.head_only = is_head;
  admission.max_body = head.method == "POST" ? limits_.max_body : 0;

  auto query = parse_query(head.query);
  if (!query) return refuse(HttpProblem::kMalformedRequest, "The query has a malformed percent escape.");
  admission.query = std::move(*query);
  const bool is_post = head.method == "POST";
  if (is_post) {
    // Parameters first: their errors are the most useful ones.
    if (auto parsed = service_.parameters().parse(raw_parameters(admission.query)); !parsed)
      return tl::unexpected<Problem>(to_problem(std::move(parsed.error())));
  } else if (!admission.query.empty()) {
    return tl::unexpected<Problem>(to_problem(
        {ErrorCode::kUnknownParameter, "This path takes no parameters.", admission.query.front().first}));
  }

  const auto representation = negotiate(head.field("accept"), offers(*admission.route));
  if (!representation) {
    std::string list;
    for (const std::string_view offer : offers(*admission.route))
      list += (list.empty() ? "" : ", ") + std::string(offer);
    return refuse(HttpProblem::kNotAcceptable, "This path can answer with " + list + ".");
  }
  admission.representation = *representation;

  if (head.content_length.value_or(0) > admission.max_body)
    return refuse(HttpProblem::kBodyTooLarge, "The body has " + std::to_string(*head.content_length) +
                                                  " bytes; the limit here is " +
                                                  std::to_string(admission.max_body) + ".");
  if (is_post) {
    if (!head.has_body())
      return tl::unexpected<Problem>(
          to_problem({ErrorCode::kEmptyBody,
                      "The body is empty. Send the mesh file as the body, or as the part 'mesh' of a "
                      "multipart/form-data body.",
                      "mesh"}));
    const std::string coding = head.field("content-encoding");
    if (!coding.empty() && !equals_ignoring_case(coding, "identity"))
      return refuse(HttpProblem::kUnsupportedCoding,
                    "Content-Encoding is not supported; send the body as it is.");
    if (auto problem = refuse_media_type(head, admission))
      return tl::unexpected<Problem>(std::move(*problem));
    if (pool_.full()) return tl::unexpected<Problem>(overloaded());
  }
  return admission;
}

/// A raw body whose format cannot be known is refused before it is read.
std::optional<Problem> Api::refuse_media_type(const RequestHead& head, const Admission& admission) const {
  const std::string content_type = head.field("content-type"), type = media_type_of(content_type);
  if (type == "multipart/form-data") {
    if (multipart_boundary(content_type)) return std::nullopt;
    return Problem(HttpProblem::kMalformedMultipart, "The Content-Type has no usable boundary.");
  }
  for (const auto& [name, value] : admission.query)
    if (name == "format") return std::nullopt;
  const auto format = format_from_media_type(type);
  if (format && service_.parameters().formats().contains(*format)) return std::nullopt;
  return unknown_format(service_.parameters().formats(), type == "application/octet-stream" ? "" : type);
}

Response Api::answer(const Request& request, const Execution& execution) noexcept {
  try {
    OrProblem<Response> response = dispatch(request, execution);
    if (response) return std::move(*response);
    return Response::problem(response.error(), request.id);
  } catch (const std::bad_alloc&) {
    spdlog::error("{} out of memory", request.id);
    return Response::problem(
        Problem(HttpProblem::kOverloaded, "There is not enough memory for this request now.")
            .with("Retry-After", "10"),
        request.id);
  } catch (const std::exception& e) {
    spdlog::error("{} broken invariant: {}", request.id, e.what());
  } catch (...) {
    spdlog::error("{} an exception of unknown type", request.id);
  }
  return Response::problem(Problem(Error{ErrorCode::kInternal,
                                         "This is a bug of the server, not of the request. Please report it "
                                         "with the request_id."}),
                           request.id);
}

OrProblem<Response> Api::dispatch(const Request& request, const Execution& execution) {
  const std::string_view path = request.admission.route->path;
  if (path == "/fracture") return post_fracture(request, execution);
  if (path == "/fractures/{id}") return get_fracture(request);
  if (path == "/livez") return Response::text(200, "text/plain", "alive\n");
  if (path == "/readyz") {
    if (draining())
      return tl::unexpected<Problem>(
          Problem(HttpProblem::kDraining, "The server is stopping; send requests elsewhere.")
              .with("Retry-After", "5"));
    return Response::text(200, "text/plain", "ready\n");
  }
  if (path == "/openapi.json") {
    Response response;
    response.content_type = "application/json";
    const std::string_view text = openapi_json();
    response.body = {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
    return response;
  }
  if (path == "/version")
    return json_response(
        {{"name", "fracture-server"}, {"version", FRACTURE_VERSION}, {"algorithm", kAlgorithmVersion}});
  if (path == "/limits") {
    const ServiceConfig& config = service_.config();
    return json_response({{"max_body_bytes", limits_.max_body},
                          {"max_bodies_bytes", limits_.max_bodies},
                          {"max_header_bytes", limits_.max_header},
                          {"max_uri_bytes", limits_.max_uri},
                          {"header_timeout_ms", limits_.header_timeout.count()},
                          {"body_grace_ms", limits_.body_grace.count()},
                          {"body_bytes_per_second", limits_.body_rate},
                          {"write_stall_ms", limits_.write_stall.count()},
                          {"idle_ms", limits_.idle.count()},
                          {"max_connections", limits_.max_connections},
                          {"max_connections_per_address", limits_.max_connections_per_address},
                          {"max_triangles", config.import_limits.max_triangles},
                          {"max_decoded_bytes", config.import_limits.max_decoded_bytes},
                          {"max_json_depth", config.import_limits.max_json_depth},
                          {"deadline_ms", limits_.deadline.count()},
                          {"formats", service_.parameters().formats().names()},
                          {"parameters", service_.parameters().to_json()}});
  }
  return json_response(
      {{"name", "fracture-server"},
       {"about", "POST a mesh to /fracture and get exact, watertight fragments back as one GLB."},
       {"version", FRACTURE_VERSION},
       {"algorithm", kAlgorithmVersion},
       {"links", {{"interface", "/openapi.json"}, {"limits", "/limits"}, {"version", "/version"}}}});
}

namespace {

/// The answer for a result in the negotiated representation, headers that depend on the result only.
Response result_response(const std::shared_ptr<const FractureResult>& result, std::size_t representation) {
  Response response;
  if (representation == kAsFigures) {
    response = Response::text(200, "application/json", figures_of(*result).dump() + "\n");
  } else {
    response.content_type = result->format == OutputFormat::kGltf ? "model/gltf+json" : "model/gltf-binary";
    response.body = result->file;
    response.owner = result;
  }
  response.headers.emplace_back("ETag",
                                "\"" + result->key + (representation == kAsFigures ? ".json\"" : "\""));
  if (representation != kAsFigures)
    response.headers.emplace_back("Content-Location", "/fractures/sha256:" + result->key);
  response.headers.emplace_back("Vary", "Accept");
  response.headers.emplace_back("Fracture-Algorithm", std::to_string(kAlgorithmVersion));
  return response;
}

/// If-None-Match (RFC 9110, section 13.1.2): weak comparison against a list, or '*'.
bool none_match_fails(std::string_view field, std::string_view etag) {
  while (!field.empty()) {
    std::string_view item = field.substr(0, field.find(','));
    field.remove_prefix(std::min(field.size(), item.size() + 1));
    while (!item.empty() && item.front() == ' ') item.remove_prefix(1);
    while (!item.empty() && item.back() == ' ') item.remove_suffix(1);
    if (item.substr(0, 2) == "W/") item.remove_prefix(2);
    if (item == "*" || item == etag) return true;
  }
  return false;
}

}  // namespace

OrProblem<Response> Api::post_fracture(const Request& request, const Execution& execution) {
  const ParameterTable& table = service_.parameters();
  std::vector<RawParameter> given = raw_parameters(request.admission.query);
  const std::string content_type = request.head.field("content-type");
  std::string_view mesh = request.body;
  std::string declared_type = media_type_of(content_type);
  std::string extension;
  std::vector<ImportFile> files;

  if (const auto boundary = multipart_boundary(content_type)) {
    auto parts = parse_multipart(request.body, *boundary);
    if (!parts) return tl::unexpected<Problem>(std::move(parts.error()));
    bool found = false;
    for (const FormPart& part : *parts) {
      if (part.name == "mesh") {
        if (found)
          return refuse(HttpProblem::kMalformedMultipart, "The part 'mesh' was given more than once.");
        found = true;
        mesh = part.body;
        declared_type = part.content_type;
        if (part.filename) extension = part.filename->substr(part.filename->rfind('.') + 1);
      } else if (part.name == "params") {
        Expected<std::vector<RawParameter>> params = parse_params(part.body);
        if (!params) return tl::unexpected<Problem>(to_problem(std::move(params.error())));
        given.insert(given.end(), params->begin(), params->end());
      } else if (part.filename) {
        const std::string name = file_name(*part.filename);
        if (name.empty())
          return refuse(HttpProblem::kMalformedMultipart, "A file part has an empty filename.");
        if (std::any_of(files.begin(), files.end(), [&](const ImportFile& f) { return f.name == name; }))
          return refuse(HttpProblem::kMalformedMultipart,
                        "Two file parts have the same filename: which one the mesh names cannot be known.");
        files.push_back({name, std::as_bytes(std::span(part.body.data(), part.body.size()))});
      } else if (part.body.size() > kMaxField) {
        return refuse(HttpProblem::kMalformedMultipart,
                      "A form field without a filename is over " + std::to_string(kMaxField) + " bytes.");
      } else {
        given.push_back({part.name, std::string(part.body), true});  // curl -F sites=50
      }
    }
    if (!found)
      return tl::unexpected<Problem>(
          to_problem({ErrorCode::kEmptyBody, "The form has no part named 'mesh'.", "mesh"}));
  }

  Expected<RequestParameters> parameters = table.parse(given);
  if (!parameters) return tl::unexpected<Problem>(to_problem(std::move(parameters.error())));
  std::optional<MeshFormat> format = parameters->format;
  if (!format) format = format_from_media_type(declared_type);
  if (!format) format = format_from_extension(extension);
  if (!format || !table.formats().contains(*format))
    return tl::unexpected<Problem>(
        unknown_format(table.formats(), extension.empty() ? declared_type : extension));

  Expected<FractureAnswer> answer = service_.fracture(
      {std::as_bytes(std::span(mesh.data(), mesh.size())), *format, std::move(*parameters), std::move(files),
       request.admission.representation == kAsGltf ? OutputFormat::kGltf : OutputFormat::kGlb},
      execution);
  if (!answer) return tl::unexpected<Problem>(to_problem(std::move(answer.error())));
  Response response = result_response(answer->result, request.admission.representation);
  response.headers.emplace_back("Cache-Status", cache_status(*answer));
  response.headers.emplace_back("Server-Timing", server_timing(request.queue_milliseconds, answer->timings));
  return response;
}

OrProblem<Response> Api::get_fracture(const Request& request) {
  constexpr std::string_view kPrefix = "sha256:";
  const std::string& id = request.admission.segment;
  const auto result =
      id.substr(0, kPrefix.size()) == kPrefix ? service_.find_result(id.substr(kPrefix.size())) : nullptr;
  if (!result)
    return refuse(HttpProblem::kNotFound,
                  "This result is not (or no longer) in the cache. POST /fracture makes it again.");
  Response response = result_response(result, 0);
  response.headers.emplace_back("Cache-Status", "result; hit");
  response.headers.emplace_back("Cache-Control", "public, max-age=31536000, immutable");
  const std::string none_match = request.head.field("if-none-match");
  if (!none_match.empty() && none_match_fails(none_match, response.headers.front().second)) {
    response.status = 304;
    response.content_type.clear();
    response.body = {};
  }
  return response;
}

}  // namespace fracture::http
