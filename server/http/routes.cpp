#include "server/http/routes.hpp"

#include <algorithm>

namespace fracture::http {
namespace {

constexpr std::string_view kResultTypes[] = {"model/gltf-binary", "application/json", "model/gltf+json"};
constexpr std::string_view kJsonTypes[] = {"application/json"};
constexpr std::string_view kEventTypes[] = {"text/event-stream"};
constexpr std::string_view kTextTypes[] = {"text/plain"};
constexpr std::string_view kPageTypes[] = {"text/plain", "text/html"};
constexpr std::string_view kHtmlTypes[] = {"text/html"};
/// The type of a page's file depends on its name, whatever the Accept field of the loading element says.
constexpr std::string_view kAnyTypes[] = {"*/*"};

using enum Operation;
using enum Listener;

constexpr Route kRoutes[] = {
    {kGetIndex, kPublic, "GET", "/", Carries::kNothing, kIndexTypes,
     "The server's name and addresses, or the web page"},
    {kGetDocs, kPublic, "GET", "/docs", Carries::kNothing, kHtmlTypes,
     "The documentation, including this interface"},
    {kGetPageFile, kPublic, "GET", "/page/{file}", Carries::kNothing, kAnyTypes,
     "A file that the page loads"},
    {kGetVersion, kPublic, "GET", "/version", Carries::kNothing, kJsonTypes,
     "Server version and algorithm version"},
    {kGetLimits, kPublic, "GET", "/limits", Carries::kNothing, kJsonTypes, "Limits, parameters and formats"},
    {kGetPatterns, kPublic, "GET", "/patterns", Carries::kNothing, kJsonTypes,
     "Patterns, materials and their parameters"},
    {kGetOpenapi, kPublic, "GET", "/openapi.json", Carries::kNothing, kJsonTypes,
     "This interface as OpenAPI 3.1"},
    {kGetLlms, kPublic, "GET", "/llms.txt", Carries::kNothing, kTextTypes,
     "This interface as a single text file"},
    {kGetProblem, kPublic, "GET", "/problems/{name}", Carries::kNothing, kPageTypes,
     "The meaning of a problem type and how to solve the problem"},
    {kPostFracture, kPublic, "POST", "/fracture", Carries::kMeshOrName, kResultTypes, "Fracture a mesh"},
    {kGetFracture, kPublic, "GET", "/fractures/{id}", Carries::kNothing, kResultTypes, "A cached result"},
    {kPostMesh, kPublic, "POST", "/meshes", Carries::kMesh, kJsonTypes, "Store a mesh"},
    {kPutMesh, kPublic, "PUT", "/meshes/{id}", Carries::kMesh, kJsonTypes, "Store a mesh under its digest"},
    {kGetMesh, kPublic, "GET", "/meshes/{id}", Carries::kNothing, kJsonTypes, "The report on a stored mesh"},
    {kDeleteMesh, kPublic, "DELETE", "/meshes/{id}", Carries::kNothing, kJsonTypes, "Delete a stored mesh"},
    {kPostMeshFracture, kPublic, "POST", "/meshes/{id}/fracture", Carries::kParameters, kResultTypes,
     "Fracture a stored mesh", Priority::kRealtime},
    {kPostMeshEstimate, kPublic, "POST", "/meshes/{id}/estimate", Carries::kParameters, kJsonTypes,
     "Estimate the result and the cost of a fracture"},
    {kGetJobs, kPublic, "GET", "/jobs", Carries::kQuery, kJsonTypes, "The client's jobs, newest first"},
    {kGetJob, kPublic, "GET", "/jobs/{id}", Carries::kNothing, kJsonTypes, "A job's progress"},
    {kDeleteJob, kPublic, "DELETE", "/jobs/{id}", Carries::kNothing, kJsonTypes, "Cancel or delete a job"},
    {kGetJobEvents, kPublic, "GET", "/jobs/{id}/events", Carries::kNothing, kEventTypes,
     "A job's progress as server-sent events"},
    {kGetLivez, kAdmin, "GET", "/livez", Carries::kNothing, kTextTypes, "Whether the process responds"},
    {kGetReadyz, kAdmin, "GET", "/readyz", Carries::kNothing, kTextTypes,
     "Whether the server accepts requests"},
    {kGetMetrics, kAdmin, "GET", "/metrics", Carries::kNothing, kTextTypes, "Metrics for Prometheus"},
};

}  // namespace

std::span<const Route> routes() { return kRoutes; }

std::optional<std::string> match(const Route& route, std::string_view path) {
  const std::size_t open = route.path.find('{');
  if (open == std::string_view::npos) return route.path == path ? std::optional(std::string()) : std::nullopt;
  const std::string_view before = route.path.substr(0, open),
                         after = route.path.substr(route.path.find('}') + 1);
  if (path.size() <= before.size() + after.size() || path.substr(0, before.size()) != before ||
      path.substr(path.size() - after.size()) != after)
    return std::nullopt;
  const std::string_view segment = path.substr(open, path.size() - before.size() - after.size());
  if (segment.find('/') != std::string_view::npos) return std::nullopt;
  return std::string(segment);
}

std::optional<std::string> digest_in(std::string_view segment) {
  if (segment.size() != kDigestScheme.size() + 64 || !segment.starts_with(kDigestScheme)) return std::nullopt;
  segment.remove_prefix(kDigestScheme.size());
  const auto is_digit = [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); };
  if (!std::all_of(segment.begin(), segment.end(), is_digit)) return std::nullopt;
  return std::string(segment);
}

}  // namespace fracture::http
