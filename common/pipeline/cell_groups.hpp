// Which cells stay together: those of one group of the pattern, and those in a region to keep. Also: how much parts count
// when pieces unite by their size.
#pragma once

#include <vector>

#include "common/pipeline/fracture.hpp"
#include "common/rough/restraint.hpp"

namespace fracture {

/// Returns the group of each site, from the groups of the input points; empty if each site is its own
/// group. Throws Interrupted.
std::vector<std::uint32_t> groups_of_sites(const Tetrahedralization& t,
                                           const std::vector<std::uint32_t>& groups_of_input,
                                           const Execution& execution);

/// Returns SizeLimits::weights: the share of the pieces that a part should have because of impacts, divided by
/// its share of the volume. Empty if impacts do not decide. `impacts`: Diagram::impacts. Throws Interrupted.
std::vector<double> weights_of_parts(const Solid& solid, const FractureParameters& parameters,
                                     const std::vector<Vec3d>& impacts, const Execution& execution);

/// Returns the cells whose sites are in the region FractureParameters::keep, ascending. Throws Interrupted.
std::vector<SiteId> kept_cells(const SeenSolid& seen, const VoronoiDiagram& diagram,
                               const FractureParameters& parameters, const Execution& execution);

/// Returns the cells that meet the region FractureParameters::keep, and those whose rough cuts might. Ascending.
/// Throws Interrupted.
std::vector<SiteId> cells_near_kept(const SeenSolid& seen, const VoronoiDiagram& diagram,
                                    const FractureParameters& parameters, const Execution& execution);

/// Gives cells of a hit that meet the region to keep to the rest (hit_region.hpp leaves none, unless two sites are at one place), and
/// sets HitCells::flat. `parameters`: those of the hit. Throws Interrupted.
void spare_region(const Solid& solid, const FractureParameters& parameters, HitCells& cells,
                  const Execution& execution);

/// Returns flat cuts for the kept cells and for cells whose rough cuts might enter the region. Empty if cuts
/// are flat anyway. Throws Interrupted.
Restraints flat_near_kept(const SeenSolid& seen, const VoronoiDiagram& diagram,
                          const FractureParameters& parameters, const std::vector<SiteId>& kept,
                          const Execution& execution);

/// Keeps these cells together, whatever their groups are. (Empty `groups`: each cell is its own group.)
void keep_together(std::uint32_t sites, const std::vector<SiteId>& kept, std::vector<std::uint32_t>& groups);

}  // namespace fracture
