// Accurate volume of a fragment, even if the sum in doubles cancels.
#pragma once

#include <cstdint>
#include <span>

#include "common/base/pacer.hpp"
#include "common/base/vec.hpp"

namespace fracture {

/// Returns `volume` (m³, computed by MassIntegral with the first point of the first triangle as origin) if
/// it is off by at most 1e-10 of itself (exact::cancels). Otherwise returns the volume computed by
/// VolumeSum. `box`: bounding box of the points. `triangles`: three indices each, counter-clockwise from
/// outside; every point is a corner of a triangle. Throws Interrupted.
double certain_volume(double volume, std::span<const Vec3d> points, const Box& box,
                      std::span<const std::uint32_t> triangles, Pacer& pacer);

}  // namespace fracture
