#include "server/service/engine.hpp"

#include <utility>

#include "common/contacts/contacts.hpp"
#include "common/contacts/scenery.hpp"
#include "common/hollow/double_walls.hpp"
#include "server/import_worker/import_pool.hpp"
#include "server/service/worker_pool.hpp"

namespace fracture {
namespace {

/// Share of a mesh's preparation, for the progress, that is done before the search for contacts.
constexpr double kBeforeContacts = 0.8;

class LibraryEngine final : public FractureEngine {
 public:
  explicit LibraryEngine(Importer importer) : importer_(std::move(importer)) {}

  Expected<Mesh> import(std::span<const std::byte> bytes, MeshFormat format,
                        std::span<const ImportFile> files, std::string_view digest,
                        const ImportLimits& limits, const Execution& execution) const override {
    return importer_(bytes, format, files, digest, limits, execution);
  }
  Expected<Solid> prepare(std::shared_ptr<const Mesh> mesh, const SolidOptions& options,
                          const HollowOptions& hollow, const Execution& execution) const override {
    Expected<Solid> solid = [&] {
      const StageProgress::Part part(execution.within, hollow.any() ? 0.5 : kBeforeContacts);
      return make_solid(std::move(mesh), options, execution);
    }();
    if (!solid) return solid;
    warn_of_double_walls(*solid, execution);
    {
      const StageProgress::Part part(execution.within, kBeforeContacts);
      solid = hollowed(std::move(*solid), hollow, execution);
    }
    if (!solid) return solid;
    const StageProgress::Part part(execution.within, 1);
    keep_contacts(*solid, options.contact_gap, execution);
    keep_instances(*solid, execution);
    keep_scenery(*solid, options, execution);
    return solid;
  }
  Expected<CutBase> base(const Solid& solid, const FractureParameters& parameters, const Selection& selection,
                         const Execution& execution) const override {
    StageTimings timings;  // the service has its own
    if (!selection.new_hits) return make_diagram(solid, parameters, execution, timings);
    Expected<KeptAnswer> before =
        fracture_and_keep(solid, before_hits(parameters, selection.new_hits->count), execution, timings);
    if (!before) return tl::unexpected<Error>(std::move(before.error()));
    return std::move(before->base);
  }
  Expected<Cut> cut(const Solid& solid, const CutBase& base, const FractureParameters& parameters,
                    const Selection& selection, const Execution& execution) const override {
    if (selection.kept) return kept(cut_and_keep(solid, base, parameters, selection, execution));
    StageTimings timings;
    const Diagram& diagram = std::get<Diagram>(base);
    Expected<FracturedSolid> made =
        selection.refracture
            ? refracture(solid, diagram, parameters, *selection.refracture, execution, timings)
            : fracture(solid, diagram, parameters, execution, timings);
    if (!made) return tl::unexpected<Error>(std::move(made.error()));
    return Cut{std::move(*made)};
  }
  GltfFile encode(const FracturedSolid& fractured, const GltfOptions& options, OutputFormat format,
                  const Execution& execution) const override {
    return write_file(fractured, options, format, execution);
  }

 private:
  static Expected<KeptAnswer> cut_and_keep(const Solid& solid, const CutBase& base,
                                           const FractureParameters& parameters, const Selection& selection,
                                           const Execution& execution) {
    StageTimings timings;
    if (selection.new_hits)
      return fracture_delta(solid, std::get<FracturedBase>(base), parameters, *selection.new_hits, execution,
                            timings);
    return fracture_and_keep(solid, std::get<Diagram>(base), parameters, execution, timings);
  }
  static Expected<Cut> kept(Expected<KeptAnswer> answer) {
    if (!answer) return tl::unexpected<Error>(std::move(answer.error()));
    FracturedSolid& fractured = answer->fractured;
    if (!fractured.delta) fractured.delta.emplace();  // an empty delta
    return Cut{std::move(fractured), std::make_shared<const CutBase>(std::move(answer->base))};
  }

  const Importer importer_;
};

}  // namespace

std::unique_ptr<FractureEngine> make_engine(Importer importer) {
  return std::make_unique<LibraryEngine>(std::move(importer));
}

std::unique_ptr<FractureEngine> make_engine(std::shared_ptr<ImportPool> imports) {
  return make_engine(
      Importer([pool = std::move(imports)](std::span<const std::byte> bytes, MeshFormat format,
                                           std::span<const ImportFile> files, std::string_view digest,
                                           const ImportLimits& limits, const Execution& execution) {
        return pool->import(bytes, format, files, limits, execution, digest, &WorkerPool::stands_back,
                            WorkerPool::flow());
      }));
}

}  // namespace fracture
