#include "server/service/engine.hpp"

#include <utility>

namespace fracture {
namespace {

class LibraryEngine final : public FractureEngine {
 public:
  Expected<Mesh> import(std::span<const std::byte> bytes, MeshFormat format,
                        std::span<const ImportFile> files, const ImportLimits& limits,
                        const Execution& execution) const override {
    execution.poll();
    return import_mesh(bytes, format, limits, files);
  }
  Expected<Solid> prepare(std::shared_ptr<const Mesh> mesh, const SolidOptions& options,
                          const Execution& execution) const override {
    return make_solid(std::move(mesh), options, execution);
  }
  Expected<Diagram> diagram(const Solid& solid, const FractureParameters& parameters,
                            const Execution& execution, StageTimings& timings) const override {
    return make_diagram(solid, parameters, execution, timings);
  }
  Expected<FragmentSet> cut(const Solid& solid, const Diagram& diagram, const FractureParameters& parameters,
                            const Execution& execution, StageTimings& timings) const override {
    return fracture(solid, diagram, parameters, execution, timings);
  }
  std::vector<std::uint8_t> encode(const FragmentSet& fragments, const GltfOptions& options,
                                   OutputFormat format) const override {
    return format == OutputFormat::kGltf ? write_gltf(fragments, options) : write_glb(fragments, options);
  }
};

}  // namespace

std::unique_ptr<FractureEngine> make_engine() { return std::make_unique<LibraryEngine>(); }

}  // namespace fracture
