// Which cells stay together: those of one group of the pattern, and those that meet a region to keep.
#pragma once

#include <vector>

#include "common/pipeline/fracture.hpp"

namespace fracture {

/// Returns the group of each site, from the groups of the input points; empty if each site is its own
/// group. Throws Interrupted.
std::vector<std::uint32_t> groups_of_sites(const Tetrahedralization& t,
                                           const std::vector<std::uint32_t>& groups_of_input,
                                           const Execution& execution);

/// Returns the cells that FractureParameters::keep keeps together: those that meet the region, and those
/// whose rough cuts might. Ascending. Throws Interrupted.
std::vector<SiteId> kept_cells(const SeenSolid& seen, const VoronoiDiagram& diagram,
                               const FractureParameters& parameters, const Execution& execution);

/// Keeps these cells together, whatever their groups are. (Empty `groups`: each cell is its own group.)
void keep_together(std::uint32_t sites, const std::vector<SiteId>& kept, std::vector<std::uint32_t>& groups);

}  // namespace fracture
