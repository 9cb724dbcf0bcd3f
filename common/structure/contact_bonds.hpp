// Bonds across parts. The contact of two parts is divided among their fragments, by each fragment's surface
// in the contact (contacts/DECISION.md). Fragments of one part are bonded by caps (fragment/bonds.hpp).
#pragma once

#include <span>
#include <vector>

#include "common/base/cell_map.hpp"
#include "common/base/execution.hpp"
#include "common/fragment/fragments.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

/// Whether any contact of two parts has an area.
bool parts_hold_together(const Solid& solid);

/// The sites that decide which cell contains a point.
struct CellSites {
  std::span<const Vec3d> points;  ///< per site, in the map's image
  const CellMap& map;
};

/// Inputs for bonds across parts, other than the fragments. Borrows all.
struct ContactBonds {
  const Solid& solid;  ///< with its contacts
  CellSites cells;
  Vec3d lattice_step;   ///< FragmentSet::lattice_step
  double strength = 1;  ///< Bond::strength of each bond
};

/// Returns all bonds between fragments across parts, ascending by (a, b), which are indices into
/// `fragments`. `fragments` must contain all fragments of the parts in contact. `wanted` (per fragment):
/// only bonds with at least one wanted fragment are returned; empty: all. A bond's bits depend only on its
/// fragments, the solid, the lattice and the sites that bound its cells at the contact. Near-linear in
/// fragments, in the contact pieces of parts that are cut, and in the regions into which cells divide these
/// pieces. Throws Interrupted.
std::vector<Bond> find_contact_bonds(const ContactBonds& with, std::span<const Fragment* const> fragments,
                                     std::span<const char> wanted, const Execution& execution);

/// Merges the bonds by shared caps and the bonds across parts, each ascending by (a, b). If two fragments have both, their
/// areas and the forces that they withstand (area × strength) add up; centroid and normal are means weighted by area. If the
/// normals cancel, that of the larger area stays. Linear. Throws Interrupted.
std::vector<Bond> with_contact_bonds(std::span<const Bond> caps, std::span<const Bond> contacts,
                                     const Execution& execution);

/// Adds the bonds across parts to those of the set, for all fragments. Throws Interrupted.
void add_contact_bonds(FragmentSet& set, const Solid& solid, const CellSites& cells, double strength,
                       const Execution& execution);

}  // namespace fracture
