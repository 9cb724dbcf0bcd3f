// What a pattern makes alone: no hit changes that where it is not near. Cells grown together, and pieces united because
// they were too small or too many, are decided on as if no hit had come.
#pragma once

#include <vector>

#include "common/fragment/unions.hpp"
#include "common/pipeline/fracture.hpp"

namespace fracture {

/// Replaces the plan's groups by those of aggregate(), where the plan has the pattern's points alone; with max_volume
/// it gets further points. Errors of tetrahedralize() and split_large(). Throws Interrupted.
Expected<SplitFigures> aggregate_before_hits(const SeenSolid& seen, const FractureParameters& parameters,
                                             SitePlan& plan, const Execution& execution);

/// Adds to the plan, which has the pattern's points alone and no groups, those of max_volume. Errors as above.
Expected<SplitFigures> split_before_hits(const SeenSolid& seen, const FractureParameters& parameters,
                                         SitePlan& plan, const Execution& execution);

/// The group of each site, from those of the input points; empty when each is for itself. Throws Interrupted.
std::vector<std::uint32_t> groups_of_sites(const Tetrahedralization& t,
                                           const std::vector<std::uint32_t>& groups_of_input,
                                           const Execution& execution);

/// The cells that FractureParameters::keep keeps together: those that meet the region, and those whose rough cuts might.
/// Ascending. Throws Interrupted.
std::vector<SiteId> kept_cells(const SeenSolid& seen, const VoronoiDiagram& diagram,
                               const FractureParameters& parameters, const Execution& execution);

/// Whatever the groups of these cells (none: each for itself), they stay together.
void keep_together(std::uint32_t sites, const std::vector<SiteId>& kept, std::vector<std::uint32_t>& groups);

/// How many sites are those of the pattern: the first ones.
std::uint32_t sites_of_pattern(const Diagram& diagram);

/// The limits that unite pieces before their cuts become rough: all but the budget of triangles, with room for what the
/// noise takes.
SizeLimits limits_of_flat_pieces(const FractureParameters& parameters);

/// The pattern's pieces that the size limits merge, or that join across parts. Errors of tetrahedralize(). Throws Interrupted.
Expected<std::vector<Union>> unions_before_hits(const SeenSolid& seen, const Diagram& diagram,
                                                const FractureParameters& parameters,
                                                const Execution& execution);

/// Those of the pattern's unions that no site of a hit is a neighbour of.
std::vector<Union> unions_beside_hits(const std::vector<Union>& unions, const Diagram& diagram,
                                      const Ownership& ownership, const Execution& execution);

}  // namespace fracture
