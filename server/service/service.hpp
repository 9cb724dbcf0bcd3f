// The service without HTTP: a mesh and parameters in, a finished GLB out, with caches between the steps. The
// HTTP adapter and `fracture-server bake` are two faces of this one class, which is why their answers have
// the same bytes.
//
//   bytes ──import──> Mesh ──prepare──> Solid ──diagram──> Diagram ──cut──> FragmentSet ──encode──> GLB
//                          [mesh cache]          [diagram cache]                          [result cache]
//
// Everything here is synchronous, on the caller's thread. The server arranges the steps on its worker pool
// and shares them between requests (dispatcher.hpp); `bake` and `inspect` call them as they are.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/execution.hpp"
#include "common/base/timings.hpp"
#include "common/fragment/fragments.hpp"
#include "server/cache/memory_cache.hpp"
#include "server/service/engine.hpp"
#include "server/service/parameters.hpp"
#include "server/service/request.hpp"

namespace fracture {

struct ServiceConfig {
  ImportLimits import_limits;
  std::uint32_t max_sites = 100'000;
  FormatSet formats;
  std::size_t mesh_cache_bytes = 256u << 20;
  std::size_t diagram_cache_bytes = 64u << 20;
  std::size_t result_cache_bytes = 256u << 20;
};

/// A mesh made ready for any number of fractures.
struct PreparedMesh {
  Solid solid;
  nlohmann::json frame;  ///< units and axes: what was assumed (mesh/frame.hpp)
};

/// Immutable and shared: by the caches and by every response that is being written from it.
struct FractureResult {
  std::string key;          ///< RequestKeys::result
  std::string mesh_digest;  ///< "sha256:<hex>", digest_of(the request)
  OutputFormat format = OutputFormat::kGlb;
  std::vector<std::uint8_t> file;
  Digest file_digest;  ///< SHA-256 of `file`
};

enum class CacheOutcome {
  kNotConsulted,
  kHit,
  kMissStored,
  kMissNotStored,
  kCollapsed,  ///< not there, but somebody else was computing it: waited for that
};

/// What one step made, or found.
template <class Value>
struct Step {
  std::shared_ptr<const Value> value;
  CacheOutcome cache = CacheOutcome::kNotConsulted;
  StageTimings timings;  ///< import, prepare, tetrahedralize, clip, encode: those that ran
  StageTimings inner;    ///< the pipeline's own finer stages
};

struct FractureAnswer {
  std::shared_ptr<const FractureResult> result;
  CacheOutcome result_cache = CacheOutcome::kNotConsulted;
  CacheOutcome diagram_cache = CacheOutcome::kNotConsulted;
  CacheOutcome mesh_cache = CacheOutcome::kNotConsulted;
  double queue_milliseconds = -1;  ///< waiting for a computing thread; -1: never did
  StageTimings timings, inner;  ///< as in Step, of all steps
  Certificate certificate;      ///< when it was computed now; a cached result has it in its file
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

  /// What is still in memory; null when it is not.
  std::shared_ptr<const PreparedMesh> find_mesh(const RequestKeys& keys) { return meshes_.find(keys.mesh); }
  std::shared_ptr<const Diagram> find_diagram(const RequestKeys& keys) {
    return diagrams_.find(keys.diagram);
  }
  std::shared_ptr<const FractureResult> find_result(const std::string& key) { return results_.find(key); }

  /// Each step by itself: computes without looking into the cache, and stores. Errors as fracture(), but an
  /// interruption is thrown (Interrupted).
  Expected<Step<PreparedMesh>> make_mesh(const FractureRequest& request, const RequestKeys& keys,
                                         const Execution& execution);
  Expected<Step<Diagram>> make_diagram(const PreparedMesh& mesh, const FractureRequest& request,
                                       const RequestKeys& keys, const Execution& execution);
  /// `answer` gets the result, its cache, timings and certificate.
  Expected<void> make_result(const PreparedMesh& mesh, const Diagram& diagram, const FractureRequest& request,
                             const RequestKeys& keys, const Execution& execution, FractureAnswer& answer);

  struct Figures {
    CacheFigures meshes, diagrams, results;
  };
  Figures figures() const { return {meshes_.figures(), diagrams_.figures(), results_.figures()}; }
  const ServiceConfig& config() const { return config_; }
  const ParameterTable& parameters() const { return parameters_; }

 private:
  const ServiceConfig config_;
  const ParameterTable parameters_;
  const std::unique_ptr<FractureEngine> engine_;
  MemoryCache<PreparedMesh> meshes_;
  MemoryCache<Diagram> diagrams_;
  MemoryCache<FractureResult> results_;
};

/// The error that an interruption is for a client.
Error to_error(const Interrupted& interrupted);

/// Bytes of heap behind a value, close enough to budget a cache with.
std::size_t memory_size(const PreparedMesh& mesh);
std::size_t memory_size(const Diagram& diagram);

/// The `extras.fracture` object of a GLB that this service made (parameters, report, certificate, bonds);
/// throws InternalError for a result of another format.
nlohmann::json figures_of(const FractureResult& result);

}  // namespace fracture
