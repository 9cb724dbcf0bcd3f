// Bonds across parts: the contact of two parts is divided among their fragments, by the surface that each fragment has in it
// (contacts/DECISION.md). Caps bond the fragments of one part (fragment/bonds.hpp).
#pragma once

#include <span>
#include <vector>

#include "common/base/cell_map.hpp"
#include "common/base/execution.hpp"
#include "common/fragment/fragments.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

/// Does any contact of two parts have an area?
bool parts_hold_together(const Solid& solid);

/// The sites that decide which cell contains a place.
struct CellSites {
  std::span<const Vec3d> points;  ///< per site, in the image under the map
  const CellMap& map;
};

/// Inputs for bonds across parts, apart from the fragments. Borrows all.
struct ContactBonds {
  const Solid& solid;  ///< with its contacts
  CellSites cells;
  Vec3d lattice_step;   ///< FragmentSet::lattice_step
  double strength = 1;  ///< Bond::strength of each bond
};

/// All bonds between fragments across parts, ascending by (a, b), which are indices into `fragments`. `fragments` must
/// contain all fragments of the parts in contact. `wanted` (per fragment): only bonds with at least one wanted fragment are
/// returned; empty: all. The bits of a bond depend only on its fragments, the solid, the lattice and the sites that bound its
/// cells at the contact. Near-linear in fragments, in the contact pieces of parts that are cut, and in the regions into which
/// cells divide these. Throws Interrupted.
std::vector<Bond> find_contact_bonds(const ContactBonds& with, std::span<const Fragment* const> fragments,
                                     std::span<const char> wanted, const Execution& execution);

/// Adds these bonds for all fragments to the set. Throws Interrupted.
void add_contact_bonds(FragmentSet& set, const Solid& solid, const CellSites& cells, double strength,
                       const Execution& execution);

}  // namespace fracture
