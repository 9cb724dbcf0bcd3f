// Results as resources, and the header fields that every answer with a result has.
#include "server/http/result_response.hpp"

#include <algorithm>
#include <cstdio>

#include "server/http/api.hpp"

namespace fracture::http {
namespace {

std::string milliseconds(double ms) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f", ms);
  return text;
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

std::string cache_status(const FractureAnswer& answer) {
  std::string value;
  const auto add = [&](const char* name, CacheOutcome outcome) {
    if (outcome == CacheOutcome::kNotConsulted) return;
    if (!value.empty()) value += ", ";
    value += name;
    if (outcome == CacheOutcome::kHit) value += "; hit";
    if (outcome == CacheOutcome::kMissStored) value += "; fwd=miss; stored";
    if (outcome == CacheOutcome::kMissNotStored) value += "; fwd=miss";
    if (outcome == CacheOutcome::kCollapsed) value += "; fwd=miss; collapsed";
  };
  add("mesh", answer.mesh_cache);
  add("diagram", answer.diagram_cache);
  add("result", answer.result_cache);
  return value;
}

std::string server_timing(const FractureAnswer& answer) {
  std::string value = "queue;dur=" + milliseconds(std::max(0.0, answer.queue_milliseconds));
  for (const char* stage : {"import", "prepare", "tetrahedralize", "clip", "encode"})
    value += std::string(", ") + stage + ";dur=" + milliseconds(answer.timings.milliseconds(stage));
  return value;
}

OrProblem<Response> Api::get_fracture(const Request& request) {
  constexpr std::string_view kPrefix = "sha256:";
  const std::string& id = request.admission.segment;
  const auto result =
      id.substr(0, kPrefix.size()) == kPrefix ? service_.find_result(id.substr(kPrefix.size())) : nullptr;
  if (!result)
    return refuse(HttpProblem::kNotFound,
                  "This result is not (or no longer) in the cache. POST /fracture makes it again.");
  Response response = result_response(result, kAsGlb);
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
