#include "server/service/engine.hpp"

#include <utility>

#include "common/pipeline/delta.hpp"
#include "server/import_worker/import_pool.hpp"

namespace fracture {
namespace {

class LibraryEngine final : public FractureEngine {
 public:
  explicit LibraryEngine(std::shared_ptr<ImportPool> imports) : imports_(std::move(imports)) {}

  Expected<Mesh> import(std::span<const std::byte> bytes, MeshFormat format,
                        std::span<const ImportFile> files, std::string_view digest,
                        const ImportLimits& limits, const Execution& execution) const override {
    if (imports_) return imports_->import(bytes, format, files, limits, execution, digest);
    execution.poll();
    return import_mesh(bytes, format, limits, files);
  }
  Expected<Solid> prepare(std::shared_ptr<const Mesh> mesh, const SolidOptions& options,
                          const Execution& execution) const override {
    return make_solid(std::move(mesh), options, execution);
  }
  Expected<Diagram> diagram(const Solid& solid, const FractureParameters& parameters,
                            const Execution& execution, StageTimings& timings) const override {
    if (parameters.new_hits == 0) return make_diagram(solid, parameters, execution, timings);
    Expected<KeptAnswer> before = fracture_and_keep(solid, before_hits(parameters), execution, timings);
    if (!before) return tl::unexpected<Error>(std::move(before.error()));
    Diagram diagram;
    diagram.fractured = std::move(before->base);
    return diagram;
  }
  Expected<FragmentSet> cut(const Solid& solid, const Diagram& diagram, const FractureParameters& parameters,
                            const Execution& execution, StageTimings& timings,
                            std::shared_ptr<const Diagram>& kept) const override {
    if (!parameters.kept) return fracture(solid, diagram, parameters, execution, timings);
    if (parameters.new_hits > 0 && !diagram.fractured)
      throw InternalError("new hits on a diagram that is not fractured");
    Expected<KeptAnswer> after =
        parameters.new_hits > 0 ? fracture_delta(solid, *diagram.fractured, parameters, execution, timings)
                                : fracture_and_keep(solid, diagram, parameters, execution, timings);
    if (!after) return tl::unexpected<Error>(std::move(after.error()));
    auto next = std::make_shared<Diagram>();
    next->fractured = std::move(after->base);
    kept = std::move(next);
    if (!after->set.delta) after->set.delta.emplace();  // nothing is new
    return std::move(after->set);
  }
  std::vector<std::uint8_t> encode(const FragmentSet& fragments, const GltfOptions& options,
                                   OutputFormat format, const Execution& execution) const override {
    return format == OutputFormat::kGltf ? write_gltf(fragments, options, execution)
                                         : write_glb(fragments, options, execution);
  }

 private:
  const std::shared_ptr<ImportPool> imports_;
};

}  // namespace

std::unique_ptr<FractureEngine> make_engine(std::shared_ptr<ImportPool> imports) {
  return std::make_unique<LibraryEngine>(std::move(imports));
}

}  // namespace fracture
