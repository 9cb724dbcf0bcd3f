#include "common/pipeline/rough_cells.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "common/fragment/make_fragments.hpp"
#include "common/fragment/unite.hpp"
#include "common/pipeline/part_contacts.hpp"

namespace fracture {
namespace {

/// Rough cuts take less than half of nearly every piece that is as small as the limit. So with this factor
/// little is united after the noise. Of 252 results (seven assets, nine rough materials), 31 united something
/// then without this factor, and none with it.
constexpr double kTakenByNoise = 2;
/// The factor applies only up to this limit: larger limits are requests for larger fragments.
constexpr double kCrumbs = 0.05;

/// Returns the limits for uniting pieces before their cuts become rough: all limits except the triangle
/// budget, with a margin for the volume that the noise removes.
SizeLimits limits_of_flat_pieces(const FractureParameters& parameters) {
  SizeLimits limits = parameters.size;
  limits.max_triangles = 0;
  if (parameters.roughness.amplitude > 0)
    limits.min_of_mean = std::max(limits.min_of_mean, std::min(kTakenByNoise * limits.min_of_mean, kCrumbs));
  return limits;
}

/// Restrains the cells of these fragments. From the second time on, they and all cells restrained before
/// become flat.
void restrain(const FragmentSet& set, const std::vector<std::uint32_t>& fragments, std::uint32_t sites,
              Restraints& restraints) {
  const bool first = restraints.empty();
  restraints.resize(sites, Restraint::kNone);
  for (Restraint& r : restraints)
    if (r != Restraint::kNone) r = Restraint::kFlat;
  for (const std::uint32_t f : fragments)
    for (const SiteId s : set.fragments[f].sites) restraints[s] = first ? Restraint::kLess : Restraint::kFlat;
}

Restraints stronger_of(const Restraints& a, Restraints b) {
  if (b.empty()) return a;
  for (std::size_t s = 0; s < a.size(); ++s) b[s] = std::max(a[s], b[s]);
  return b;
}

/// Unites pieces with flat cuts, so that the noise does not decide which pieces unite.
SizeFigures unite_flat(const RestrictedDiagram& restricted, const Pieces& pieces, const Ownership& ownership,
                       const SizeLimits& limits, const PartContacts* across, std::vector<Union>& unions,
                       const Execution& execution) {
  PieceGroups groups(pieces.pieces.size());
  const SizeFigures figures = unite_by_size(restricted, pieces, limits, across, groups, execution);
  unions = name_unions(restricted, pieces, groups, lowest_cells(ownership), execution);
  return figures;
}

}  // namespace

void make_rough_fragments(RestrictedDiagram& restricted, const FractureParameters& parameters,
                          SizeLimits limits, const Ownership& ownership, const Restraints& always,
                          std::vector<Union> before, const std::function<Verdict(const FragmentSet&)>& judged,
                          const Execution& execution, CutCells& cut) {
  Roughness roughness = parameters.roughness;
  Restraints restraints;
  const bool with_hits = !parameters.hits.empty(), rough = roughness.amplitude > 0;
  SizeFigures of_flat;
  std::optional<Pieces> flat;
  std::optional<PartContacts> across;  // only pieces with flat cuts join across parts, and only without hits
  if (!with_hits && rough) {
    SizeLimits of_pieces = limits_of_flat_pieces(parameters);
    of_pieces.weights = limits.weights;
    of_pieces.kept_owner = limits.kept_owner;
    if (of_pieces.any() || joins_parts(restricted.solid, parameters)) {
      flat = gather_pieces(restricted, ownership, execution);
      across = find_part_contacts(restricted, ownership, *flat, parameters, execution);
      of_flat =
          unite_flat(restricted, *flat, ownership, of_pieces, across ? &*across : nullptr, before, execution);
      across.reset();
    }
    limits.fragments = 0;
  }
  bool touch_across = true;
  for (int restrained = 0;; ++restrained) {
    execution.reaches(0.7);
    cut.rough = roughen(restricted, ownership.owner_of_site, roughness, stronger_of(always, restraints),
                        parameters.seed, execution);
    execution.reaches(0.9);
    std::optional<Pieces> pieces;
    if (flat) pieces = with_finer_caps(*flat, restricted, execution);
    if (!pieces) pieces = gather_pieces(restricted, ownership, execution);
    if (!with_hits && !rough)
      across = find_part_contacts(restricted, ownership, *pieces, parameters, execution);
    cut.set = make_fragments(restricted, ownership, std::move(*pieces), parameters.pivot, limits, execution,
                             before, across ? &*across : nullptr, &touch_across);
    cut.set.size.parts += of_flat.parts;
    cut.set.size.inside_out = std::max(cut.set.size.inside_out, of_flat.inside_out);
    if (!(roughness.amplitude > 0)) break;
    const Verdict verdict = judged(cut.set);
    if (verdict.sound()) break;

    if (restrained < kMostRestraints && !verdict.fragments.empty())
      restrain(cut.set, verdict.fragments, restricted.diagram.dual().site_count(), restraints);
    else
      roughness.amplitude = 0;
    restricted.place_and_cap(execution);
  }
  cut.touch_across = touch_across;
  cut.restrained_cells = static_cast<std::uint32_t>(
      std::count_if(restraints.begin(), restraints.end(), [](Restraint r) { return r != Restraint::kNone; }));
  if (flat) clear_with_polls(execution, flat->pieces);
  cut.all_flat = roughness.amplitude != parameters.roughness.amplitude;
}

}  // namespace fracture
