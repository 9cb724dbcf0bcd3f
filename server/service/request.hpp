// One request of the service, and the keys that it has in the caches.
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

/// Names of a request's values in the caches. Keys hash the algorithm version and everything that determines the
/// value, so an entry is never stale.
struct RequestKeys {
  std::string digest;  ///< digest_of() in hex
  std::string mesh;    ///< bytes, format and everything that decides the solid
  /// The solid and the sites: every dual and output format shares it. With new hits: the answer without them.
  std::string diagram;
  std::string kept;  ///< of an answer that is kept: what hits on it start from, a `diagram` of theirs
  /// 64 hex digits, the whole request. The first 16 are the mesh digest's, so that a proxy can route every
  /// request that concerns one mesh to one server.
  std::string result;
};

/// The mesh and its further files are borrowed: from `owner` when there is one, else from the caller for the
/// duration of the call.
struct FractureRequest {
  std::span<const std::byte> mesh;
  MeshFormat format = MeshFormat::kGlb;
  RequestParameters parameters;
  std::vector<ImportFile> files{};  ///< what the mesh may name; their order does not matter
  OutputFormat output = OutputFormat::kGlb;
  std::shared_ptr<const void> owner{};
  std::string digest{};         ///< digest_of() in hex, when it is known already
  std::uint64_t triangles = 0;  ///< of the solid, when they were counted before
  /// keys_of() of this request, if already known. The members that they hash must not change afterwards.
  std::shared_ptr<const RequestKeys> keys{};
};

/// The digest of an input: of the mesh's bytes when it is alone; with further files, of a fixed line and the
/// digest of a text that lists the digest of the mesh and then name and digest of each file, ordered by name.
/// No mesh alone has the digest of one with files.
Digest digest_of(const FractureRequest& request, const Execution& execution = kUninterrupted);

RequestKeys keys_of(const FractureRequest& request);

/// Where `of` names an answer to another mesh: kBadParameter.
std::optional<Error> wrong_mesh(const FractureRequest& request, const RequestKeys& keys);

}  // namespace fracture
