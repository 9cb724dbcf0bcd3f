#include "server/bake/flip_engine.hpp"

#include <utility>
#include <variant>

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
    const SeenSolid seen(solid, diagram->map, silent);
    FlipCounts counts;
    Expected<Tetrahedralization> flipped =
        tetrahedralize_by_flips(diagram->sites, seen.seen().box, silent, &counts);
    if (!flipped) return tl::unexpected<Error>(std::move(flipped.error()));
    canonicalize(*flipped, silent);
    diagram->tetrahedralization = std::move(*flipped);
    tally_->add(counts);
    return made;
  }

 private:
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
