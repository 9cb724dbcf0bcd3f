// A request to the service, and its keys in the caches.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/base/execution.hpp"
#include "common/digest/digest.hpp"
#include "common/parameters/parameters.hpp"
#include "server/service/engine.hpp"

namespace fracture {

/// The cache keys of a request's values. A key covers everything that determines the value, and the algorithm version
/// where it matters, so an entry is never stale.
struct RequestKeys {
  std::string digest;  ///< digest_of() in hex
  std::string mesh;    ///< input bytes, format and all parameters that affect the solid
  /// The solid and its sites; all duals and output formats share the value. With new hits: the answer without these hits.
  std::string diagram;
  /// Key of a kept answer. A later request that applies hits to it has this key as its `diagram`.
  std::string kept;
  /// 64 hex digits for the whole request. The first 16 come from the mesh digest, so that a proxy can route all requests
  /// for one mesh to the same server.
  std::string result;
};

/// The mesh and its additional files are borrowed: from `owner` if there is one, otherwise from the caller for the duration
/// of the call.
struct FractureRequest {
  std::span<const std::byte> mesh;
  MeshFormat format = MeshFormat::kGlb;
  RequestParameters parameters;
  std::vector<ImportFile> files{};  ///< files that the mesh may refer to, in any order
  OutputFormat output = OutputFormat::kGlb;
  std::shared_ptr<const void> owner{};
  std::string digest{};         ///< digest_of() in hex, if it is already known
  std::uint64_t triangles = 0;  ///< number of the solid's triangles, if it is already known
  /// keys_of() of this request, if already known. Members that the keys depend on must not change afterwards.
  std::shared_ptr<const RequestKeys> keys{};
};

/// Returns the digest of an input. For a mesh without additional files, it is the digest of the mesh's bytes. With files, a list
/// is made of the mesh's digest and each file's name and digest, ordered by name. The result is then the digest of a fixed
/// line and the list's digest, so that it never equals the digest of a mesh without files.
Digest digest_of(const FractureRequest& request, const Execution& execution = kUninterrupted);

RequestKeys keys_of(const FractureRequest& request);

/// Returns kBadParameter if `of` names an answer for another mesh.
std::optional<Error> wrong_mesh(const FractureRequest& request, const RequestKeys& keys);

}  // namespace fracture
