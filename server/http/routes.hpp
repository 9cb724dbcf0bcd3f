// The table of routes: every method and path, and what its requests may carry.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "server/service/worker_pool.hpp"

namespace fracture::http {

enum class Listener { kPublic, kAdmin };

/// The operationIds of the routes in proto/openapi.yaml.
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
  kPostMeshEstimate,
  kGetJobs,
  kGetJob,
  kDeleteJob,
  kGetJobEvents,
  kGetLivez,
  kGetReadyz,
  kGetMetrics,
};

/// The kind of body, which also decides the allowed query.
enum class Carries {
  kNothing,     ///< no body and no query
  kQuery,       ///< no body; the handler parses the query
  kMesh,        ///< a mesh; parameters in the query
  kMeshOrName,  ///< as kMesh, or a small JSON object with parameters and the name of a stored mesh
  kParameters,  ///< a small JSON object of parameters; further ones in the query
};

struct Route {
  Operation operation;
  Listener listener;
  std::string_view method;
  std::string_view path;  ///< a segment in braces matches any single segment; at most one per path
  Carries carries;
  std::span<const std::string_view> offers;  ///< media types of the answer, in order of preference
  std::string_view summary;
  Priority priority = Priority::kBatch;  ///< class of its work if the request gives none
};

/// Returns all routes. Every GET route also answers HEAD. proto/openapi.yaml describes exactly these.
std::span<const Route> routes();

/// Returns the text that matches the segment in braces (empty if the route has none), or nothing if the path
/// differs.
std::optional<std::string> match(const Route& route, std::string_view path);

/// Meshes and results are named "sha256:" followed by 64 lower-case hex digits. digest_in() returns these
/// digits, or nothing if the segment has another form.
inline constexpr std::string_view kDigestScheme = "sha256:";
std::optional<std::string> digest_in(std::string_view segment);

/// Offers of GET /: JSON for programs and for clients that accept everything; browsers request HTML.
inline constexpr std::string_view kIndexTypes[] = {"application/json", "text/html"};
inline constexpr std::size_t kIndexAsHtml = 1;

/// Indices into the offers of routes that answer with a result.
inline constexpr std::size_t kAsGlb = 0, kAsFigures = 1, kAsGltf = 2;
/// Indices into the offers of the pages about problems.
inline constexpr std::size_t kAsText = 0, kAsHtml = 1;

}  // namespace fracture::http
