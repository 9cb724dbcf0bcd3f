// Cuts one fragment by the cells of a hit. Its pieces are intersections of the fragment with these cells. The cells of
// the guards together cut off the rest, which is the fragment that remains.
//
// Neighbouring fragments are cut separately, and their common faces must still match. Both get the same
// points on these faces, because a point is the exact value of a formula, rounded once to the lattice of the whole. They also get
// the same triangles (fragment/mirrored_ring.hpp). Triangles that no cell cuts stay as they are.
#pragma once

#include <optional>
#include <vector>

#include "common/pipeline/fracture.hpp"
#include "common/pipeline/fracture_steps.hpp"
#include "common/pipeline/kept_fragment.hpp"
#include "common/voronoi/voronoi_diagram.hpp"

namespace fracture {

/// The pieces of a fragment. Without ids; other fields are complete, except Fragment::density_share.
struct PiecesOfFragment {
  std::vector<KeptFragment> pieces;
  std::vector<char> is_rest;  ///< per piece: whether a guard's cell is part of it
  /// Per piece: a number that depends on its sites of the hit and its parts
  std::vector<std::uint64_t> names;
  /// Per piece: its triangles that the fragment had as cuts already, and that another fragment has mirrored.
  std::vector<std::vector<IndexRange>> earlier_caps;
  std::vector<Bond> bonds;  ///< between the pieces
  Certificate certificate;  ///< of the pieces as a partition of the fragment
  SizeFigures size;
  RoughReport rough;
  std::uint32_t restrained_cells = 0;
  bool all_flat = false;
};

/// The same for all fragments that a hit cuts. Borrows all.
struct HitOnFragments {
  const Solid& solid;  ///< the whole
  const HitCells& cells;
  const VoronoiDiagram& diagram;         ///< of the cells
  const FractureParameters& parameters;  ///< with at least one hit
  const SizeLimits& limits;              ///< for pieces that the hit breaks off
};

/// The limits for pieces that hits break off a solid of this volume (m³).
SizeLimits limits_of_hits(const FractureParameters& parameters, double volume);

/// Returns nothing if no cut goes through the fragment: it is in the rest, or in one cell of the hit. Pieces of different
/// parts that touch in one cell stay together, if the parts do (Parts::kTogether). Error: kUnsound. Throws Interrupted.
Expected<std::optional<PiecesOfFragment>> cut_again(const HitOnFragments& hit, const KeptFragment& fragment,
                                                    const Execution& execution);

}  // namespace fracture
