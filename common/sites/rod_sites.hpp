// The sites of a rod, which breaks across its axis.
#pragma once

#include <cstdint>

#include "common/sites/generators.hpp"
#include "common/sites/shapes.hpp"

namespace fracture::sites_detail {

/// Divides a rod across its axis into `count` pieces. `shape`: must have a rod. `hit`: the point near which
/// pieces are shorter, in the coordinates of the source; null: none. The sites are in the frame's image.
SitePlan across_rod(const Task& task, const RadialPattern& pattern, const PartShape& shape,
                    const CellMap::Frame& frame, const Vec3d* hit, std::uint32_t count, Random& random);

}  // namespace fracture::sites_detail
