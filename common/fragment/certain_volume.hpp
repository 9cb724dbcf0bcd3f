// The volume of a fragment where the sum in doubles cancels.
#pragma once

#include <cstdint>
#include <span>

#include "common/base/pacer.hpp"
#include "common/base/vec.hpp"

namespace fracture {

/// `volume` as MassIntegral found it, m³, from the first point of the first triangle; where that may be off by more
/// than 1e-10 of itself (exact::cancels), what VolumeSum finds. `box`: of the points, all of them in some of the
/// triangles (three indices each, counter-clockwise from outside). Throws Interrupted.
double certain_volume(double volume, std::span<const Vec3d> points, const Box& box,
                      std::span<const std::uint32_t> triangles, Pacer& pacer);

}  // namespace fracture
