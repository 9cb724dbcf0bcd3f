// The five steps of a fracture, as the service calls them. FractureEngine is an interface so that tests can replace it. Their
// fake answers at once, waits, or fails on demand, so the HTTP side can be tested without computing anything. The importer can
// also be replaced, by one that runs in another process.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/execution.hpp"
#include "common/base/timings.hpp"
#include "common/gltf/gltf_writer.hpp"
#include "common/hollow/hollow.hpp"
#include "common/import/import_input.hpp"
#include "common/mesh/mesh.hpp"
#include "common/parameters/selection.hpp"
#include "common/solid/solid.hpp"
#include "server/service/cut_base.hpp"

namespace fracture {

class ImportPool;

struct Cut {
  FracturedSolid fractured;
  std::shared_ptr<const CutBase> kept{};  ///< the base for further hits on this answer; null: not requested
};

/// Thread-safe: every method may be called from several threads at once. Each method returns the errors of its library
/// function (import_mesh, make_solid, make_diagram, fracture). Any of them may throw Interrupted.
class FractureEngine {
 public:
  virtual ~FractureEngine() = default;
  /// `digest`: the digest by which the service identifies the input, 64 hex digits.
  virtual Expected<Mesh> import(std::span<const std::byte> bytes, MeshFormat format,
                                std::span<const ImportFile> files, std::string_view digest,
                                const ImportLimits& limits, const Execution& execution) const = 0;
  virtual Expected<Solid> prepare(std::shared_ptr<const Mesh> mesh, const SolidOptions& options,
                                  const HollowOptions& hollow, const Execution& execution) const = 0;
  /// Returns the answer without the new hits, if there are any; otherwise the diagram.
  virtual Expected<CutBase> base(const Solid& solid, const FractureParameters& parameters,
                                 const Selection& selection, const Execution& execution) const = 0;
  virtual Expected<Cut> cut(const Solid& solid, const CutBase& base, const FractureParameters& parameters,
                            const Selection& selection, const Execution& execution) const = 0;
  virtual GltfFile encode(const FracturedSolid& fractured, const GltfOptions& options, OutputFormat format,
                          const Execution& execution) const = 0;
};

/// A function that does the work of FractureEngine::import().
using Importer = std::function<Expected<Mesh>(std::span<const std::byte> bytes, MeshFormat format,
                                              std::span<const ImportFile> files, std::string_view digest,
                                              const ImportLimits& limits, const Execution& execution)>;

/// Returns the real engine, which calls the libraries in common/. It calls `importer` instead of the file readers, because a
/// program that serves clients must not contain them.
std::unique_ptr<FractureEngine> make_engine(Importer importer);
/// Returns the real engine with an importer that uses the pool. The pool adds errors of its own
/// (import_worker/import_pool.hpp).
std::unique_ptr<FractureEngine> make_engine(std::shared_ptr<ImportPool> imports);

}  // namespace fracture
