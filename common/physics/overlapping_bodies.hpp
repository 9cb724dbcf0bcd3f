// Finds overlapping bodies among those that no diagram proves to be disjoint. Cells of one diagram are convex and disjoint,
// and a hull lies in the cells of its fragment. So only three kinds of pairs are tested: pieces of the same cell, hulls of whole
// parts in several cells, and pieces of parts with separate diagrams (base/cell_map.hpp). Other pairs cost nothing.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/cell_map.hpp"
#include "common/base/execution.hpp"
#include "common/fragment/fragments.hpp"
#include "common/physics/collision_filters.hpp"
#include "common/physics/collision_hulls.hpp"

namespace fracture {

/// Fragments with their hulls; borrowed. They are placed as in the file.
struct Bodies {
  std::vector<const Fragment*> fragments{};
  std::vector<const FragmentHulls*> hulls{};
  std::size_t size() const { return fragments.size(); }
};

/// Which fragments are known to have disjoint cells.
struct CellsOfBodies {
  const CellMap& map;     ///< by Fragment::part
  bool disjoint = true;   ///< false: cells may overlap, as barycentric ones do
  bool may_share = true;  ///< false: no two fragments have a piece of the same cell
};

struct Overlap {
  BodyPair pair;
  double depth = 0;                      ///< m, > 0: depth of the two hulls that overlap most
  Vec3d normal;                          ///< unit length, from a to b, of these hulls
  std::uint32_t hull_a = 0, hull_b = 0;  ///< indices of these hulls
};

/// Sorted by pair. Near-linear in the hulls, their points, and pairs of hulls whose boxes meet. Throws Interrupted.
std::vector<Overlap> find_overlaps(const Bodies& bodies, const CellsOfBodies& cells,
                                   const Execution& execution);

/// Returns the deepest overlap of two bodies; its depth is 0 if they are apart. Throws Interrupted.
Overlap deepest_overlap(const Bodies& bodies, const BodyPair& pair, const Execution& execution);

}  // namespace fracture
