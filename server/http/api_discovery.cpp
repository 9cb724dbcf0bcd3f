// Describes the interface: index, limits, patterns, OpenAPI and problem pages. Also the health probes.
#include <algorithm>

#include "common/parameters/groups.hpp"
#include "common/pipeline/algorithm_version.hpp"
#include "server/http/api.hpp"
#include "server/http/prefer.hpp"

namespace fracture::http {
namespace {

std::string escaped(std::string_view text) {
  std::string html;
  for (const char c : text)
    if (c == '<' || c == '>' || c == '&')
      html += c == '<' ? "&lt;" : c == '>' ? "&gt;" : "&amp;";
    else
      html += c;
  return html;
}

/// Returns a response that refers to text which lives as long as the server.
Response lasting(std::string_view text, std::string content_type = "application/json") {
  Response response;
  response.content_type = std::move(content_type);
  response.body = {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
  return response;
}

}  // namespace

Response Api::get_index() const {
  return Response::json(
      {{"name", "fracture-server"},
       {"about", "POST a mesh to /fracture and get exact, watertight fragments back as one GLB."},
       {"version", FRACTURE_VERSION},
       {"algorithm", kAlgorithmVersion},
       {"links",
        {{"interface", "/openapi.json"},
         {"text", "/llms.txt"},
         {"limits", "/limits"},
         {"patterns", "/patterns"},
         {"version", "/version"}}}});
}

Response Api::get_version() const {
  return Response::json(
      {{"name", "fracture-server"}, {"version", FRACTURE_VERSION}, {"algorithm", kAlgorithmVersion}});
}

Response Api::get_limits() const { return lasting(limits_text_); }

nlohmann::ordered_json Api::describe_limits() const {
  const ServiceConfig& config = service_.config();
  return {{"max_body_bytes", limits_.max_body},
          {"max_bodies_bytes", limits_.max_bodies},
          {"max_small_bodies_bytes", limits_.max_small_bodies},
          {"max_bodies_per_address_bytes", limits_.body_share()},
          {"max_answers_bytes", limits_.max_answers},
          {"max_answers_per_address_bytes", limits_.answer_share()},
          {"max_header_bytes", limits_.max_header},
          {"max_header_fields", kMaxFields},
          {"max_header_members", kMaxMembers},
          {"max_uri_bytes", limits_.max_uri},
          {"header_timeout_ms", limits_.header_timeout.count()},
          {"body_grace_ms", limits_.body_grace.count()},
          {"body_bytes_per_second", limits_.body_rate},
          {"body_timeout_ms", limits_.body_timeout.count()},
          {"answer_bytes_per_second", limits_.answer_rate},
          {"write_stall_ms", limits_.write_stall.count()},
          {"idle_ms", limits_.idle.count()},
          {"max_connections", limits_.max_connections},
          {"max_connections_per_address", limits_.max_connections_per_address},
          {"max_triangles", config.import_limits.max_triangles},
          {"max_decoded_bytes", config.import_limits.max_decoded_bytes},
          {"max_json_depth", config.import_limits.max_json_depth},
          {"deadline_ms", limits_.deadline.count()},
          {"realtime_deadline_ms", limits_.realtime_deadline.count()},
          {"max_stored_mesh_bytes", meshes_.config().quota_bytes},
          {"mesh_ttl_ms", meshes_.config().ttl.count()},
          {"max_jobs", jobs_.config().max_jobs},
          {"max_job_result_bytes", jobs_.config().max_result_bytes},
          {"job_ttl_ms", jobs_.config().ttl.count()},
          {"job_deadline_ms", jobs_.config().deadline.count()},
          {"max_wait_s", kLongestWait.count()},
          {"max_parameters_bytes", kMaxSmallBody},
          {"formats", service_.parameters().formats().names()},
          {"parameters", service_.parameters().to_json()},
          {"parameter_groups", parameter_groups_json()}};
}

Response Api::get_patterns() const { return lasting(patterns_text_); }

Response Api::get_openapi() const { return lasting(openapi_json()); }

Response Api::get_llms() const { return lasting(llms_txt(), "text/plain; charset=utf-8"); }

OrProblem<Response> Api::get_problem(const Request& request) const {
  const std::span<const ProblemType> types = problem_types();
  const auto type = std::find_if(types.begin(), types.end(),
                                 [&](const ProblemType& t) { return t.slug == request.admission.segment; });
  if (type == types.end())
    return refuse(HttpProblem::kNotFound,
                  "No problem type has this name. GET /openapi.json lists the problem types.");
  const std::string title(type->title), advice(type->advice), status = std::to_string(type->status);
  Response response;
  if (request.admission.representation == kAsHtml) {
    response = Response::text(
        200, "text/html; charset=utf-8",
        "<!DOCTYPE html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<title>" + escaped(title) +
            "</title>\n<h1>" + escaped(title) + "</h1>\n<p>HTTP status " + status + ", type <code>" +
            std::string(type->slug) + "</code></p>\n<p>" + escaped(advice) + "</p>\n</html>\n");
    response.headers.emplace_back("Content-Security-Policy", "default-src 'none'");
  } else {
    response = Response::text(
        200, "text/plain; charset=utf-8",
        title + "\n(HTTP status " + status + ", type " + std::string(type->slug) + ")\n\n" + advice + "\n");
  }
  response.headers.emplace_back("Vary", "Accept");
  return response;
}

OrProblem<Response> Api::get_readyz() const {
  if (draining())
    return tl::unexpected<Problem>(
        Problem(HttpProblem::kDraining, "The server is stopping; send requests elsewhere.")
            .with("Retry-After", "5"));
  if (waits_for_folder())
    return tl::unexpected<Problem>(to_problem(overloaded(
        "Another server is using the --cache-dir folder. This server takes over the folder and its jobs "
        "when the other server ends. Until then, this server answers requests without the folder.",
        std::chrono::seconds(2))));
  return Response::text(200, "text/plain", "ready\n");
}

}  // namespace fracture::http
