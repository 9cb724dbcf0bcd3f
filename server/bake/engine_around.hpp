// An engine that forwards every step to another engine. Derived classes override single steps.
#pragma once

#include <memory>
#include <utility>

#include "server/service/engine.hpp"

namespace fracture::bake {

class EngineAround : public FractureEngine {
 public:
  explicit EngineAround(std::unique_ptr<FractureEngine> inner) : inner_(std::move(inner)) {}

  Expected<Mesh> import(std::span<const std::byte> bytes, MeshFormat format,
                        std::span<const ImportFile> files, std::string_view digest,
                        const ImportLimits& limits, const Execution& execution) const override {
    return inner_->import(bytes, format, files, digest, limits, execution);
  }
  Expected<Solid> prepare(std::shared_ptr<const Mesh> mesh, const SolidOptions& options,
                          const HollowOptions& hollow, const Execution& execution) const override {
    return inner_->prepare(std::move(mesh), options, hollow, execution);
  }
  Expected<CutBase> base(const Solid& solid, const FractureParameters& parameters, const Selection& selection,
                         const Execution& execution) const override {
    return inner_->base(solid, parameters, selection, execution);
  }
  Expected<Cut> cut(const Solid& solid, const CutBase& base, const FractureParameters& parameters,
                    const Selection& selection, const Execution& execution) const override {
    return inner_->cut(solid, base, parameters, selection, execution);
  }
  GltfFile encode(const FracturedSolid& fractured, const GltfOptions& options, OutputFormat format,
                  const Execution& execution) const override {
    return inner_->encode(fractured, options, format, execution);
  }

 private:
  const std::unique_ptr<FractureEngine> inner_;
};

}  // namespace fracture::bake
