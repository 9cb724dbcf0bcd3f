// Bonds between fragments and the nodes of the scene that are not fractured.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/execution.hpp"
#include "common/structure/contact_bonds.hpp"

namespace fracture {

/// A fragment that holds on to a node that stays whole, through all contacts with the node's parts.
struct WholeBond {
  std::uint32_t fragment = 0;  ///< index into FragmentSet::fragments
  std::uint32_t node = 0;      ///< index into Mesh::node_names
  double area = 0;             ///< m², > 0
  Vec3d centroid;              ///< m; mean of the contacts, weighted by area
  Vec3d normal;         ///< unit, from the fragment to the node; mean of the contacts, weighted by area
  double strength = 1;  ///< per area, as a multiple of the material's strength
};

/// Returns the bonds of the wanted fragments, ascending by fragment and node; none without Solid::scenery. `fragments` must
/// contain all fragments of the parts in contact. `wanted`: per fragment; empty: all. The bonds of a contact add up to its area,
/// as in find_contact_bonds(). Throws Interrupted.
std::vector<WholeBond> find_whole_bonds(const Solid& solid, const CellSites& cells, const Vec3d& lattice_step,
                                        double strength, std::span<const Fragment* const> fragments,
                                        std::span<const char> wanted, const Execution& execution);

}  // namespace fracture
