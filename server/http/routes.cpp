#include "server/http/routes.hpp"

namespace fracture::http {
namespace {

constexpr std::string_view kResultTypes[] = {"model/gltf-binary", "application/json", "model/gltf+json"};
constexpr std::string_view kStoredTypes[] = {"model/gltf-binary", "model/gltf+json"};
constexpr std::string_view kJsonTypes[] = {"application/json"};
constexpr std::string_view kTextTypes[] = {"text/plain"};

using enum Operation;
using enum Listener;

constexpr Route kRoutes[] = {
    {kGetIndex, kPublic, "GET", "/", kJsonTypes, "What this is"},
    {kGetVersion, kPublic, "GET", "/version", kJsonTypes, "Versions of the server and of the algorithm"},
    {kGetLimits, kPublic, "GET", "/limits", kJsonTypes, "Limits, parameters and formats"},
    {kGetOpenapi, kPublic, "GET", "/openapi.json", kJsonTypes, "This interface as OpenAPI 3.1"},
    {kPostFracture, kPublic, "POST", "/fracture", kResultTypes, "Fracture a mesh"},
    {kGetFracture, kPublic, "GET", "/fractures/{id}", kStoredTypes, "A result that is still in the cache"},
    {kGetLivez, kAdmin, "GET", "/livez", kTextTypes, "The process answers"},
    {kGetReadyz, kAdmin, "GET", "/readyz", kTextTypes, "The server takes requests"},
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

}  // namespace fracture::http
