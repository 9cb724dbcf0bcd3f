#include "server/bake/flip_engine.hpp"

#include <utility>
#include <variant>

#include "common/pipeline/part_sets.hpp"
#include "common/solid/image.hpp"
#include "server/bake/engine_around.hpp"

namespace fracture::bake {
namespace {

class FlipEngine final : public EngineAround {
 public:
  FlipEngine(std::unique_ptr<FractureEngine> inner, std::shared_ptr<FlipTally> tally)
      : EngineAround(std::move(inner)), tally_(std::move(tally)) {}

  Expected<CutBase> base(const Solid& solid, const FractureParameters& parameters, const Selection& selection,
                         const Execution& execution) const override {
    Expected<CutBase> made = EngineAround::base(solid, parameters, selection, execution);
    Diagram* const diagram = made ? std::get_if<Diagram>(&*made) : nullptr;
    if (!diagram) return made;
    Execution silent = execution;  // progress for this stage has already been reported
    silent.within = nullptr;
    if (diagram->sets.empty()) {
      if (auto flipped = flip(solid, *diagram, silent); !flipped)
        return tl::unexpected<Error>(std::move(flipped.error()));
      return made;
    }
    const std::vector<PartSet> sets = part_sets(solid, parameters, silent);
    for (std::size_t k = 0; k < sets.size(); ++k)
      if (auto flipped = flip(sets[k].solid_in(solid), diagram->sets[k], silent); !flipped)
        return tl::unexpected<Error>(std::move(flipped.error()));
    return made;
  }

 private:
  Expected<void> flip(const Solid& solid, Diagram& diagram, const Execution& execution) const {
    const SeenSolid seen(solid, diagram.map, execution);
    FlipCounts counts;
    Expected<Tetrahedralization> flipped =
        tetrahedralize_by_flips(diagram.sites, seen.seen().box, execution, &counts);
    if (!flipped) return tl::unexpected<Error>(std::move(flipped.error()));
    canonicalize(*flipped, execution);
    diagram.tetrahedralization = std::move(*flipped);
    tally_->add(counts);
    return {};
  }

  const std::shared_ptr<FlipTally> tally_;
};

}  // namespace

std::string FlipTally::sentence() const {
  const FlipCounts c = counts();
  return "inserted by flips: " + std::to_string(c.flip14) + " flip14, " + std::to_string(c.flip26) +
         " flip26, " + std::to_string(c.flip_n2n) + " flip n-2n; " + std::to_string(c.flip23) + " flip23, " +
         std::to_string(c.flip32) + " flip32, " + std::to_string(c.flip44) + " flip44";
}

std::unique_ptr<FractureEngine> flip_engine(std::unique_ptr<FractureEngine> inner,
                                            std::shared_ptr<FlipTally> tally) {
  return std::make_unique<FlipEngine>(std::move(inner), std::move(tally));
}

}  // namespace fracture::bake
