// An answer without its companions, in a form that hits change. Copies share all fragments, and a hit replaces only those
// that it cuts. So the answer to some hits is the same, bit for bit, whether they came one by one or together.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "common/pipeline/fracture.hpp"
#include "common/pipeline/fracture_steps.hpp"
#include "common/pipeline/kept_fragment.hpp"

namespace fracture {

struct BrokenSolid {
  std::vector<SharedFragment> fragments;  ///< in the order of the answer
  /// Everything else of the answer before complete(); its set has no fragments and no hulls.
  CutCells cut;
  SiteNotes notes;
  /// The pattern's sites, which decide bonds across parts, and their map.
  std::shared_ptr<const std::vector<Vec3d>> points;
  CellMap map{};
  std::uint64_t of_pattern = 0;  ///< Diagram::of_pattern
  /// The instances that stayed whole before the first hit; null: none. `of_fragment` is empty, because each fragment has its
  /// own (KeptFragment::instance).
  std::shared_ptr<const InstancedBodies> instances{};
  bool with_hulls = false;
  double surface_area = 0;                 ///< m², of all fragments without caps
  std::size_t hits = 0;                    ///< number of hits so far
  LocalRest rest = LocalRest::kFractured;  ///< what the first hit broke
};

/// The parameters of the answer that the first hit breaks: without hits. With LocalRest::kWhole, the solid has one cell,
/// so each part is one fragment, or each instance that stays whole (kept_instances.hpp).
FractureParameters before_first_hit(const Solid& solid, const FractureParameters& parameters);

/// Makes the answer, with all hits. `diagram`: make_diagram() of the parameters. Errors: those of fracture(). Throws
/// Interrupted.
Expected<BrokenSolid> break_solid(const Solid& solid, const Diagram& diagram,
                                  const FractureParameters& parameters, const Execution& execution);

/// Applies the hits of the parameters that come after the first `broken.hits`. Fragments that no cell of a hit cuts stay
/// the same objects. The others are replaced by their pieces. The largest piece of the rest of a fragment keeps its id.
/// Further pieces of the rest are separate fragments, like the pieces that the hit breaks off. Afterwards, fragments are
/// in the order of their first sites, parts and ids. Errors: those of check_sites_of_hits(), cells_of_hit() and cut_again(). Throws Interrupted.
Expected<void> apply_hits(const Solid& solid, const FractureParameters& parameters, BrokenSolid& broken,
                          const Execution& execution);

/// Returns InstancedBodies::of_fragment for the whole answer, or an empty list if no instance is whole. Throws Interrupted.
std::vector<std::uint32_t> instances_of(const BrokenSolid& broken, const Execution& execution);

/// Completes the answer with copies of all fragments. Error: kUnsound. Throws Interrupted.
Expected<FracturedSolid> complete(const Solid& solid, const BrokenSolid& broken,
                                  const FractureParameters& parameters, const Execution& execution);

}  // namespace fracture
