// The service without HTTP: it takes a mesh and parameters, returns a finished GLB, and caches values between the steps.
// The HTTP adapter and `fracture-server bake` both use this class, so their answers have the same bytes.
//
//   bytes ──import──> Mesh ──prepare──> Solid ──diagram──> Diagram ──cut──> FracturedSolid ──encode──> GLB
//                          [mesh cache]          [diagram cache]                             [result cache]
//
// Everything here is synchronous, on the caller's thread. The server runs the steps on its worker pool and shares their
// values between requests (dispatcher.hpp). `bake` and `inspect` call them directly.
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
  /// Memory that one computation may hold, in bytes, if its execution has no allowance; 0: no limit. Readers of meshes
  /// get a share of it.
  std::uint64_t max_bytes_per_job = 0;
  std::string memory_setting = "--max-working";  ///< the flag that limits this memory, for error messages
  TiersConfig tiers;                             ///< the cache tiers below the result cache
};

/// A mesh that is ready for any number of fractures.
struct PreparedMesh {
  Solid solid;
  FrameReport frame;  ///< the assumed units and axes
};

/// A value that one step computed or found in a cache.
template <class Value>
struct Step {
  std::shared_ptr<const Value> value;
  CacheOutcome cache = CacheOutcome::kNotConsulted;
  StageTimings timings;          ///< of the stages that ran: import, prepare, tetrahedralize, clip, encode
  double processor_seconds = 0;  ///< processor time on all threads, if it was measured
};

struct FractureAnswer {
  std::shared_ptr<const FractureResult> result;
  CacheOutcome result_cache = CacheOutcome::kNotConsulted;
  CacheOutcome disk_cache = CacheOutcome::kNotConsulted, redis_cache = CacheOutcome::kNotConsulted;
  CacheOutcome diagram_cache = CacheOutcome::kNotConsulted;
  CacheOutcome mesh_cache = CacheOutcome::kNotConsulted;
  double queue_milliseconds = -1;  ///< time in the queue; -1: it was never queued
  double work_milliseconds = 0;    ///< time from the end of the queue to the result
  StageTimings timings;            ///< of all steps; see Step
};

class FractureService {
 public:
  /// Returns whether the caller may use the answer with this key. An empty function allows all answers.
  using MaySee = std::function<bool(const std::string& key)>;

  FractureService(const ServiceConfig& config, std::unique_ptr<FractureEngine> engine);

  /// Parses a request's parameters. If they name an earlier answer, that answer's parameters are added. Looks only into
  /// memory. Errors: those of ParameterTable::parse() and on_earlier_answer(); kNoSuchAnswer, even if the answer exists but
  /// the caller may not see it.
  Expected<RequestParameters> parse(const std::vector<RawParameter>& given, const MaySee& may_see = {});
  /// Returns roughly how many bytes of parameters parse() takes over from the earlier answer; 0 if `given` names none. An
  /// entry of `assign` counts as 100 bytes more, because it takes that long.
  std::uint64_t earlier_bytes(const std::vector<RawParameter>& given) const;

  /// Computes an answer, or finds it in a cache. Thread-safe and synchronous. Bad input, cancellation (kCancelled) and a
  /// passed deadline (kDeadlineExceeded) are returned as errors. A broken invariant or a lack of memory throws.
  Expected<FractureAnswer> fracture(const FractureRequest& request, const Execution& execution);

  /// Runs only the first two steps, for a report on the mesh without fracturing it. Errors: those of fracture().
  Expected<std::shared_ptr<const PreparedMesh>> prepare(const FractureRequest& request,
                                                        const Execution& execution);

  /// Finds a value that is still in memory; null if there is none.
  std::shared_ptr<const PreparedMesh> find_mesh(const RequestKeys& keys) { return meshes_.find(keys.mesh); }
  std::shared_ptr<const CutBase> find_diagram(const RequestKeys& keys) {
    return diagrams_.find(keys.diagram);
  }
  /// As above, but does not count as a request in the cache.
  std::shared_ptr<const PreparedMesh> peek_mesh(const RequestKeys& keys) const {
    return meshes_.peek(keys.mesh);
  }
  std::shared_ptr<const CutBase> peek_diagram(const RequestKeys& keys) const {
    return diagrams_.peek(keys.diagram);
  }
  std::shared_ptr<const FractureResult> find_result(const std::string& key) { return results_.find(key); }
  /// Returns whether the result is in memory; does not count as a request in the cache.
  bool has_result(const std::string& key) const { return results_.size_of(key).has_value(); }
  /// Removes a result from memory, because nobody may use it any more.
  void forget_result(const std::string& key) {
    results_.erase(key);
    answers_.erase(key);
  }
  /// Caches a variant of a result (compressed, for example) under its own key, if there is room for it.
  void keep_variant(std::shared_ptr<const FractureResult> variant);
  /// Returns the error (kUnsound) with which this request failed recently; nothing if no failure is known.
  std::optional<Error> find_failure(const std::string& key) const { return failures_.find(key); }

  /// Returns whether there are cache tiers below memory.
  bool has_tiers() const { return tiers_.any(); }
  /// Looks for a result in the tiers and copies it to memory. Blocks. Sets the result in `answer` (null: not found) and the
  /// cache outcomes. Returns false if the result exists but `room` does not allow reading it. `client`: see ResultTiers.
  bool fetch_result(const std::string& key, FractureAnswer& answer, const Room& room = {},
                    const Execution& execution = kUninterrupted, const std::string& client = {});

  /// The single steps. Each computes its value without looking into the cache, and then stores it there. Errors: those of
  /// fracture(), but an interruption is thrown (Interrupted).
  Expected<Step<PreparedMesh>> make_mesh(const FractureRequest& request, const RequestKeys& keys,
                                         const Execution& execution);
  Expected<Step<CutBase>> make_diagram(const PreparedMesh& mesh, const FractureRequest& request,
                                       const RequestKeys& keys, const Execution& execution);
  /// Sets the result, its cache outcome and its timings in `answer`. Returns the fragments that the result was made from, so
  /// that the caller can reply before it frees them: freeing about ten thousand arrays takes a third of a millisecond.
  /// `client`: see ResultTiers.
  Expected<FracturedSolid> make_result(const PreparedMesh& mesh, const CutBase& diagram,
                                       const FractureRequest& request, const RequestKeys& keys,
                                       const Execution& execution, FractureAnswer& answer,
                                       const std::string& client = {});

  struct Figures {
    CacheFigures meshes, diagrams, results;
    TiersFigures tiers;
    std::uint64_t unsound = 0;  ///< answers that failed their own checks
  };
  Figures figures() const {
    return {meshes_.figures(), diagrams_.figures(), results_.figures(), tiers_.figures(), failures_.count()};
  }
  ResultTiers& tiers() { return tiers_; }
  const ServiceConfig& config() const { return config_; }
  const ParameterTable& parameters() const { return parameters_; }

 private:
  /// Computes an answer that is not in the caches.
  Expected<FractureAnswer> fracture(const FractureRequest& request, const RequestKeys& keys,
                                    const Execution& execution, FractureAnswer answer);

  const ServiceConfig config_;
  const ParameterTable parameters_;
  const std::unique_ptr<FractureEngine> engine_;
  MemoryCache<PreparedMesh> meshes_;
  MemoryCache<CutBase> diagrams_;
  MemoryCache<FractureResult> results_;
  MemoryCache<nlohmann::json> answers_;  ///< canonical parameters by RequestKeys::result
  FailureMemo failures_;
  ResultTiers tiers_;
};

/// Warns in an answer's report if the mesh is too large for its material (solid/size_check.hpp). Sizes that no object has are in
/// the report on the mesh.
void check_size_of_pieces(const PreparedMesh& mesh, const FractureRequest& request, Remarks& remarks,
                          std::vector<Choice>& choices);

/// Converts an interruption to the error that the client gets.
Error to_error(const Interrupted& interrupted);

/// Returns the approximate number of heap bytes that a value uses, for the budget of a cache.
std::size_t memory_size(const Mesh& mesh);
std::size_t memory_size(const PreparedMesh& mesh);
std::size_t memory_size(const CutBase& diagram);
std::size_t memory_size(const FractureResult& result);

}  // namespace fracture
