// The service without HTTP: a mesh and parameters in, a finished GLB out, with caches between the steps. The
// HTTP adapter and `fracture-server bake` are two faces of this one class, which is why their answers have
// the same bytes.
//
//   bytes ──import──> Mesh ──prepare──> Solid ──diagram──> Diagram ──cut──> FracturedSolid ──encode──> GLB
//                          [mesh cache]          [diagram cache]                             [result cache]
//
// Everything here is synchronous, on the caller's thread. The server arranges the steps on its worker pool
// and shares them between requests (dispatcher.hpp); `bake` and `inspect` call them as they are.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/execution.hpp"
#include "common/base/timings.hpp"
#include "common/fragment/fragments.hpp"
#include "common/parameters/parameters.hpp"
#include "server/cache/memory_cache.hpp"
#include "server/service/engine.hpp"
#include "server/service/failure_memo.hpp"
#include "server/service/request.hpp"
#include "server/service/result.hpp"
#include "server/service/result_tiers.hpp"

namespace fracture {

struct ServiceConfig {
  ImportLimits import_limits;
  std::uint32_t max_sites = kMaxPatternSites;
  FormatSet formats;
  std::size_t mesh_cache_bytes = 256u << 20;
  std::size_t diagram_cache_bytes = 64u << 20;
  std::size_t result_cache_bytes = 256u << 20;
  std::uint64_t max_bytes_per_job = 0;  ///< of memory that one computation may hold; 0: no limit
  TiersConfig tiers;                    ///< below the result cache
};

/// A mesh made ready for any number of fractures.
struct PreparedMesh {
  Solid solid;
  FrameReport frame;  ///< units and axes: what was assumed
};

/// What one step made, or found.
template <class Value>
struct Step {
  std::shared_ptr<const Value> value;
  CacheOutcome cache = CacheOutcome::kNotConsulted;
  StageTimings timings;          ///< import, prepare, tetrahedralize, clip, encode: those that ran
  double processor_seconds = 0;  ///< what it took of all threads, where that was measured
};

struct FractureAnswer {
  std::shared_ptr<const FractureResult> result;
  CacheOutcome result_cache = CacheOutcome::kNotConsulted;
  CacheOutcome disk_cache = CacheOutcome::kNotConsulted, redis_cache = CacheOutcome::kNotConsulted;
  CacheOutcome diagram_cache = CacheOutcome::kNotConsulted;
  CacheOutcome mesh_cache = CacheOutcome::kNotConsulted;
  double queue_milliseconds = -1;  ///< waiting for a computing thread; -1: never did
  double work_milliseconds = 0;  ///< from then on until the result was there: the stages and what is between
  StageTimings timings;          ///< as in Step, of all steps
};

class FractureService {
 public:
  /// May the caller use the answer of this key? Empty: any.
  using MaySee = std::function<bool(const std::string& key)>;

  FractureService(const ServiceConfig& config, std::unique_ptr<FractureEngine> engine);

  /// Parses what is asked; where it names an earlier answer, with the parameters of that. Errors of
  /// ParameterTable::parse() and on_earlier_answer(); kNoSuchAnswer, also for an answer that the caller may
  /// not see. Asks memory alone.
  Expected<RequestParameters> parse(const std::vector<RawParameter>& given, const MaySee& may_see = {});
  /// How many bytes of parameters parse() takes over from the earlier answer that is named, about; 0: none is.
  std::uint64_t earlier_bytes(const std::vector<RawParameter>& given) const;

  /// Thread-safe and synchronous. All bad input, cancellation (kCancelled) and a passed deadline
  /// (kDeadlineExceeded) come back as errors; a broken invariant or lack of memory throws.
  Expected<FractureAnswer> fracture(const FractureRequest& request, const Execution& execution);

  /// The first two steps alone, for a report on the mesh without fracturing it. Errors as fracture().
  Expected<std::shared_ptr<const PreparedMesh>> prepare(const FractureRequest& request,
                                                        const Execution& execution);

  /// What is still in memory; null when it is not.
  std::shared_ptr<const PreparedMesh> find_mesh(const RequestKeys& keys) { return meshes_.find(keys.mesh); }
  std::shared_ptr<const CutBase> find_diagram(const RequestKeys& keys) {
    return diagrams_.find(keys.diagram);
  }
  /// The same for a second look, which the caches do not count.
  std::shared_ptr<const PreparedMesh> peek_mesh(const RequestKeys& keys) const {
    return meshes_.peek(keys.mesh);
  }
  std::shared_ptr<const CutBase> peek_diagram(const RequestKeys& keys) const {
    return diagrams_.peek(keys.diagram);
  }
  std::shared_ptr<const FractureResult> find_result(const std::string& key) { return results_.find(key); }
  /// Nobody may have it any more.
  void forget_result(const std::string& key) {
    results_.erase(key);
    answers_.erase(key);
  }
  /// What was made of a result (compressed), found again by its own key while there is room for it.
  void keep_variant(std::shared_ptr<const FractureResult> variant);
  /// Why this request had no answer lately (kUnsound); nothing when that is not known.
  std::optional<Error> find_failure(const std::string& key) const { return failures_.find(key); }

  /// Are there tiers below memory? fetch_result() looks into them, which blocks, and takes what it finds into
  /// memory: `answer` gets the result (null: nowhere) and the caches. False: it is there, and there is no
  /// `room` to read it.
  bool has_tiers() const { return tiers_.any(); }
  bool fetch_result(const std::string& key, FractureAnswer& answer, const Room& room = {},
                    const Execution& execution = kUninterrupted);

  /// Each step by itself: computes without looking into the cache, and stores. Errors as fracture(), but an
  /// interruption is thrown (Interrupted).
  Expected<Step<PreparedMesh>> make_mesh(const FractureRequest& request, const RequestKeys& keys,
                                         const Execution& execution);
  Expected<Step<CutBase>> make_diagram(const PreparedMesh& mesh, const FractureRequest& request,
                                       const RequestKeys& keys, const Execution& execution);
  /// `answer` gets the result, its cache and timings. Returns what the result was made of, only
  /// so that the caller may reply before it lets go: freeing some ten thousand arrays takes a third of a
  /// millisecond.
  Expected<FracturedSolid> make_result(const PreparedMesh& mesh, const CutBase& diagram,
                                       const FractureRequest& request, const RequestKeys& keys,
                                       const Execution& execution, FractureAnswer& answer);

  struct Figures {
    CacheFigures meshes, diagrams, results;
    TiersFigures tiers;
    std::uint64_t unsound = 0;  ///< answers that did not prove themselves
  };
  Figures figures() const {
    return {meshes_.figures(), diagrams_.figures(), results_.figures(), tiers_.figures(), failures_.count()};
  }
  ResultTiers& tiers() { return tiers_; }
  const ServiceConfig& config() const { return config_; }
  const ParameterTable& parameters() const { return parameters_; }

 private:
  /// What is in no cache.
  Expected<FractureAnswer> fracture(const FractureRequest& request, const RequestKeys& keys,
                                    const Execution& execution, FractureAnswer answer);

  const ServiceConfig config_;
  const ParameterTable parameters_;
  const std::unique_ptr<FractureEngine> engine_;
  MemoryCache<PreparedMesh> meshes_;
  MemoryCache<CutBase> diagrams_;
  MemoryCache<FractureResult> results_;
  MemoryCache<nlohmann::json> answers_;  ///< canonical parameters, by RequestKeys::result
  FailureMemo failures_;
  ResultTiers tiers_;
};

/// The error that an interruption is for a client.
Error to_error(const Interrupted& interrupted);

/// Bytes of heap behind a value, close enough to budget a cache with.
std::size_t memory_size(const Mesh& mesh);
std::size_t memory_size(const PreparedMesh& mesh);
std::size_t memory_size(const CutBase& diagram);

}  // namespace fracture
