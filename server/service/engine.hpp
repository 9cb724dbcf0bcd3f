// The five steps of the job as the service calls them. An interface because two things replace it: the tests
// (a fake that answers at once, waits, or fails on demand, so that the HTTP side is attacked without
// computing anything), and an importer that runs in another process.
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
  std::shared_ptr<const CutBase>
      kept{};  ///< what further hits on this answer start from; null: not asked for
};

/// Thread-safe: every method may be called from several threads at once. Errors are those of the function
/// each method stands for (import_mesh, make_solid, make_diagram, fracture); Interrupted may be thrown from
/// any of them.
class FractureEngine {
 public:
  virtual ~FractureEngine() = default;
  /// `digest`: what the service knows the input by, 64 hex digits.
  virtual Expected<Mesh> import(std::span<const std::byte> bytes, MeshFormat format,
                                std::span<const ImportFile> files, std::string_view digest,
                                const ImportLimits& limits, const Execution& execution) const = 0;
  virtual Expected<Solid> prepare(std::shared_ptr<const Mesh> mesh, const SolidOptions& options,
                                  const HollowOptions& hollow, const Execution& execution) const = 0;
  /// Where hits are new: the answer without them; else the diagram.
  virtual Expected<CutBase> base(const Solid& solid, const FractureParameters& parameters,
                                 const Selection& selection, const Execution& execution) const = 0;
  virtual Expected<Cut> cut(const Solid& solid, const CutBase& base, const FractureParameters& parameters,
                            const Selection& selection, const Execution& execution) const = 0;
  virtual GltfFile encode(const FracturedSolid& fractured, const GltfOptions& options, OutputFormat format,
                          const Execution& execution) const = 0;
};

/// FractureEngine::import().
using Importer = std::function<Expected<Mesh>(std::span<const std::byte> bytes, MeshFormat format,
                                              std::span<const ImportFile> files, std::string_view digest,
                                              const ImportLimits& limits, const Execution& execution)>;

/// The real one: calls the libraries of common/, but for those that read files: a program that serves others does
/// not contain them.
std::unique_ptr<FractureEngine> make_engine(Importer importer);
/// Imports go through the pool, which adds its errors (import_worker/import_pool.hpp).
std::unique_ptr<FractureEngine> make_engine(std::shared_ptr<ImportPool> imports);

}  // namespace fracture
