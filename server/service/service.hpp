// The service without HTTP: a mesh and parameters in, a finished GLB out, with caches between the steps. The
// HTTP adapter and `fracture-server bake` are two faces of this one class, which is why their answers have
// the same bytes.
//
//   bytes ──import──> Mesh ──prepare──> Solid ──diagram──> Diagram ──cut──> FragmentSet ──encode──> GLB
//                          [mesh cache]          [diagram cache]                          [result cache]
//
// Keys are SHA-256 over what determines the value and the algorithm version, so an entry is never stale.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "common/base/digest.hpp"
#include "common/base/error.hpp"
#include "common/base/execution.hpp"
#include "common/base/timings.hpp"
#include "common/fragment/fragments.hpp"
#include "server/service/engine.hpp"
#include "server/service/lru_cache.hpp"
#include "server/service/parameters.hpp"

namespace fracture {

struct ServiceConfig {
  ImportLimits import_limits;
  std::uint32_t max_sites = 100'000;
  FormatSet formats;
  std::size_t mesh_cache_bytes = 256u << 20;
  std::size_t diagram_cache_bytes = 64u << 20;
  std::size_t result_cache_bytes = 256u << 20;
};

/// The mesh and its further files are borrowed for the duration of the call.
struct FractureRequest {
  std::span<const std::byte> mesh;
  MeshFormat format = MeshFormat::kGlb;
  RequestParameters parameters;
  std::vector<ImportFile> files{};  ///< what the mesh may name; their order does not matter
  OutputFormat output = OutputFormat::kGlb;
};

/// The digest of an input: of the mesh's bytes when it is alone; with further files, of a text that lists the
/// digest of the mesh and then name and digest of each file, ordered by name.
Digest digest_of(const FractureRequest& request);

/// A mesh made ready for any number of fractures.
struct PreparedMesh {
  Solid solid;
  nlohmann::json frame;  ///< units and axes: what was assumed (mesh/frame.hpp)
};

/// Immutable and shared: by the cache and by every response that is being written from it.
struct FractureResult {
  /// 64 hex digits. The first 16 are the mesh digest's, so that a proxy can route every request that concerns
  /// one mesh to one server; the rest hashes the whole request and the algorithm version.
  std::string key;
  std::string mesh_digest;  ///< "sha256:<hex>", digest_of(the request)
  OutputFormat format = OutputFormat::kGlb;
  std::vector<std::uint8_t> file;
  Certificate certificate;
};

enum class CacheOutcome { kNotConsulted, kHit, kMissStored, kMissNotStored };

struct FractureAnswer {
  std::shared_ptr<const FractureResult> result;
  CacheOutcome result_cache = CacheOutcome::kNotConsulted;
  CacheOutcome diagram_cache = CacheOutcome::kNotConsulted;
  CacheOutcome mesh_cache = CacheOutcome::kNotConsulted;
  StageTimings timings;  ///< import, prepare, tetrahedralize, clip, encode: those that ran
  StageTimings inner;    ///< the pipeline's own finer stages
};

class FractureService {
 public:
  FractureService(const ServiceConfig& config, std::unique_ptr<FractureEngine> engine);

  /// Thread-safe and synchronous. All bad input, cancellation (kCancelled) and a passed deadline
  /// (kDeadlineExceeded) come back as errors; a broken invariant or lack of memory throws.
  Expected<FractureAnswer> fracture(const FractureRequest& request, const Execution& execution);

  /// The first two steps alone, for a report on the mesh without fracturing it. Errors as fracture().
  Expected<std::shared_ptr<const PreparedMesh>> prepare(const FractureRequest& request,
                                                        const Execution& execution);

  /// A result that is still in the cache, by FractureResult::key; null when it is not.
  std::shared_ptr<const FractureResult> find_result(const std::string& key) { return results_.find(key); }

  const ServiceConfig& config() const { return config_; }
  const ParameterTable& parameters() const { return parameters_; }

 private:
  Expected<std::shared_ptr<const PreparedMesh>> prepared(const FractureRequest& request,
                                                         const std::string& mesh_key,
                                                         const Execution& execution, FractureAnswer& answer);
  Expected<FractureAnswer> compute(const FractureRequest& request, const Execution& execution);

  const ServiceConfig config_;
  const ParameterTable parameters_;
  const std::unique_ptr<FractureEngine> engine_;
  LruCache<PreparedMesh> meshes_;
  LruCache<Diagram> diagrams_;
  LruCache<FractureResult> results_;
};

/// Bytes of heap behind a value, close enough to budget a cache with.
std::size_t memory_size(const PreparedMesh& mesh);
std::size_t memory_size(const Diagram& diagram);

/// The `extras.fracture` object of a GLB that this service made (parameters, report, certificate, bonds);
/// throws InternalError for a result of another format.
nlohmann::json figures_of(const FractureResult& result);

}  // namespace fracture
