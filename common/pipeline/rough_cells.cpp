#include "common/pipeline/rough_cells.hpp"

#include <algorithm>

#include "common/fragment/make_fragments.hpp"

namespace fracture {
namespace {

/// The cells of these fragments are restrained; at the second time those of the first one go flat.
void restrain(const FragmentSet& set, const std::vector<std::uint32_t>& fragments, std::uint32_t sites,
              Restraints& restraints) {
  const bool first = restraints.empty();
  restraints.resize(sites, Restraint::kNone);
  for (Restraint& r : restraints)
    if (r != Restraint::kNone) r = Restraint::kFlat;
  for (const std::uint32_t f : fragments)
    for (const SiteId s : set.fragments[f].sites) restraints[s] = first ? Restraint::kLess : Restraint::kFlat;
}

}  // namespace

void make_rough_fragments(RestrictedDiagram& restricted, const FractureParameters& parameters,
                          const Ownership& ownership,
                          const std::function<Verdict(const FragmentSet&)>& judged,
                          const Execution& execution, CutCells& cut, std::optional<RoughTrace>* trace) {
  Roughness roughness = parameters.roughness;
  Restraints restraints;
  for (int restrained = 0;; ++restrained) {
    execution.reaches(0.7);
    cut.rough = roughen(restricted, ownership.owner_of_site, roughness, restraints, parameters.seed,
                        execution, trace);
    execution.reaches(0.9);
    cut.set = make_fragments(restricted, ownership, parameters.pivot, limits_in_force(parameters), execution);
    if (!(roughness.amplitude > 0)) break;
    const Verdict verdict = judged(cut.set);
    if (verdict.sound()) break;

    if (restrained < kMostRestraints && !verdict.fragments.empty())
      restrain(cut.set, verdict.fragments, restricted.diagram.dual().site_count(), restraints);
    else
      roughness.amplitude = 0;
    restricted.place_and_cap(execution);
  }
  cut.restrained_cells = static_cast<std::uint32_t>(
      std::count_if(restraints.begin(), restraints.end(), [](Restraint r) { return r != Restraint::kNone; }));
  cut.all_flat = roughness.amplitude != parameters.roughness.amplitude;
}

}  // namespace fracture
