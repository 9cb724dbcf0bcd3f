// The table of routes: every method and path there is, and what a request of each may carry.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "server/service/worker_pool.hpp"

namespace fracture::http {

enum class Listener { kPublic, kAdmin };

/// The operationId of each route in proto/openapi.yaml.
enum class Operation {
  kGetIndex,
  kGetDocs,
  kGetPageFile,
  kGetVersion,
  kGetLimits,
  kGetPatterns,
  kGetOpenapi,
  kGetLlms,
  kGetProblem,
  kPostFracture,
  kGetFracture,
  kPostMesh,
  kPutMesh,
  kGetMesh,
  kDeleteMesh,
  kPostMeshFracture,
  kGetJobs,
  kGetJob,
  kDeleteJob,
  kGetJobEvents,
  kGetLivez,
  kGetReadyz,
  kGetMetrics,
};

/// What the body of a request is, and with it what its query may hold.
enum class Carries {
  kNothing,     ///< no body and no query
  kQuery,       ///< no body; a query that its handler reads
  kMesh,        ///< a mesh, parameters in the query
  kMeshOrName,  ///< the same, or a small JSON object that names a stored mesh beside parameters
  kParameters,  ///< a small JSON object of parameters; more of them in the query
};

struct Route {
  Operation operation;
  Listener listener;
  std::string_view method;
  std::string_view path;  ///< a segment in braces matches any one segment; at most one in a path
  Carries carries;
  std::span<const std::string_view> offers;  ///< media types of the answer, in order of preference
  std::string_view summary;
  Priority priority = Priority::kBatch;  ///< of its work, where the request does not say
};

/// Every method and path there is. HEAD is answered wherever GET is. proto/openapi.yaml describes exactly
/// these.
std::span<const Route> routes();

/// What the segment in braces stands for (empty when the route has none); nothing when the path is another.
std::optional<std::string> match(const Route& route, std::string_view path);

/// Meshes and results are named "sha256:" and 64 lower-case hex digits. Those digits; nothing for anything
/// else.
inline constexpr std::string_view kDigestScheme = "sha256:";
std::optional<std::string> digest_in(std::string_view segment);

/// Of GET /: programs get JSON, and so does who takes anything; browsers ask for HTML.
inline constexpr std::string_view kIndexTypes[] = {"application/json", "text/html"};
inline constexpr std::size_t kIndexAsHtml = 1;

/// Of the offers of the routes that answer with a result.
inline constexpr std::size_t kAsGlb = 0, kAsFigures = 1, kAsGltf = 2;
/// Of those of the pages about problems.
inline constexpr std::size_t kAsText = 0, kAsHtml = 1;

}  // namespace fracture::http
