// Gradient noise: Perlin 2002, "Improving noise", with his twelve gradients. The hash of a lattice point is
// the finalizer of SplitMix64 instead of his table of 256 entries, so the noise does not repeat. It depends
// only on position and uses only + - * and floor, so its bits are the same on every system.
#pragma once

#include <cstdint>

#include "common/base/vec.hpp"

namespace fracture {

/// Three independent noises. Each is 0 at lattice points (integer coordinates) and twice continuously
/// differentiable. |coordinates of p| < 2^52.
Vec3d gradient_noise(const Vec3d& p, std::uint64_t seed);

/// Bound on the absolute value of each noise. (The largest value is 1.0364, near the middle of a cell with
/// all gradients towards it.)
inline constexpr double kNoiseBound = 1.04;
/// Bound of the length of each noise's gradient. (Measured: 2.4 over 10^8 points and seeds; the margin covers
/// points that were not measured.)
inline constexpr double kNoiseSlope = 3;

}  // namespace fracture
