// An engine that computes nothing: it counts its calls, and does what a test tells it to do.
#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "server/service/engine.hpp"

namespace fracture::test {

/// Counters and hooks, shared between the test and the engine that the service owns.
struct FakeControl {
  std::atomic<int> imports{0}, prepares{0}, diagrams{0}, cuts{0}, cancelled{0};
  /// Runs inside cut(); may block, throw, or poll the execution.
  std::function<void(const Execution&)> during_cut;
  std::function<std::optional<Error>()> cut_error;  ///< result of cut(), after during_cut
  /// Runs inside import(); an error is returned unchanged.
  std::function<Expected<Mesh>(std::string_view bytes)> import;
  std::function<void(const Execution&)> during_import;
  /// Receives the additional files of import().
  std::function<void(std::span<const ImportFile>)> files;
  std::size_t glb_padding = 0;  ///< extra bytes in the answer
};

class FakeEngine final : public FractureEngine {
 public:
  explicit FakeEngine(std::shared_ptr<FakeControl> control);

  Expected<Mesh> import(std::span<const std::byte> bytes, MeshFormat, std::span<const ImportFile> files,
                        std::string_view, const ImportLimits&, const Execution& execution) const override;
  Expected<Solid> prepare(std::shared_ptr<const Mesh> mesh, const SolidOptions&, const HollowOptions&,
                          const Execution&) const override;
  Expected<CutBase> base(const Solid&, const FractureParameters& parameters, const Selection&,
                         const Execution&) const override;
  Expected<Cut> cut(const Solid&, const CutBase& base, const FractureParameters&, const Selection&,
                    const Execution& execution) const override;
  /// Returns a GLB or glTF without geometry whose JSON repeats the request.
  GltfFile encode(const FracturedSolid& fractured, const GltfOptions& options, OutputFormat format,
                  const Execution&) const override;

 private:
  std::shared_ptr<FakeControl> control_;
};

}  // namespace fracture::test
