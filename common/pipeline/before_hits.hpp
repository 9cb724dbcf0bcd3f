// Computes what the pattern makes without hits, so that a hit changes only what is near it. Which cells
// grow together, and which pieces are united because of the size limits, is decided as if there were no
// hits.
#pragma once

#include <vector>

#include "common/fragment/unions.hpp"
#include "common/pipeline/fracture.hpp"
#include "common/rough/restraint.hpp"

namespace fracture {

/// Replaces the plan's groups by those of aggregate(). The plan must contain only the pattern's points, and
/// the pattern's impacts must be on the solid;
/// max_volume adds further points. Errors: those of tetrahedralize() and split_large(). Throws Interrupted.
Expected<SplitFigures> aggregate_before_hits(const SeenSolid& seen, const FractureParameters& parameters,
                                             SitePlan& plan, const Execution& execution);

/// Adds the points that max_volume needs to the plan, which must contain only the pattern's points and no
/// groups. Errors as above.
Expected<SplitFigures> split_before_hits(const SeenSolid& seen, const FractureParameters& parameters,
                                         SitePlan& plan, const Execution& execution);

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

/// Returns flat cuts for the kept cells and for cells whose rough cuts might enter the region. Empty if cuts
/// are flat anyway. Throws Interrupted.
Restraints flat_near_kept(const SeenSolid& seen, const VoronoiDiagram& diagram,
                          const FractureParameters& parameters, const std::vector<SiteId>& kept,
                          const Execution& execution);

/// Keeps these cells together, whatever their groups are. (Empty `groups`: each cell is its own group.)
void keep_together(std::uint32_t sites, const std::vector<SiteId>& kept, std::vector<std::uint32_t>& groups);

/// Number of sites that belong to the pattern; these come first.
std::uint32_t sites_of_pattern(const Diagram& diagram);

/// Returns the limits for uniting pieces before their cuts become rough: all limits except the triangle
/// budget, with a margin for the volume that the noise removes.
SizeLimits limits_of_flat_pieces(const FractureParameters& parameters);

/// Returns the unions of the pattern's pieces because of the size limits, or across parts. Errors: those of
/// tetrahedralize(). Throws Interrupted.
Expected<std::vector<Union>> unions_before_hits(const SeenSolid& seen, const Diagram& diagram,
                                                const FractureParameters& parameters,
                                                const Execution& execution);

/// Returns the pattern's unions that have no site of a hit as a neighbour.
std::vector<Union> unions_beside_hits(const std::vector<Union>& unions, const Diagram& diagram,
                                      const Ownership& ownership, const Execution& execution);

}  // namespace fracture
