// Gradient noise: Perlin 2002, "Improving noise", with his twelve gradients; the hash of a lattice point is
// SplitMix64's finalizer in place of his table of 256, so that nothing repeats. A function of position alone,
// made of + - * and floor only: the same bits everywhere.
#pragma once

#include <cstdint>

#include "common/base/vec.hpp"

namespace fracture {

/// Three independent noises, each 0 at lattice points (whole coordinates) and twice continuously
/// differentiable. |coordinates of p| < 2^52.
Vec3d gradient_noise(const Vec3d& p, std::uint64_t seed);

/// None of them is farther from 0. (The largest value is 1.0364, near the middle of a cell with all gradients
/// towards it.)
inline constexpr double kNoiseBound = 1.04;
/// The gradient of one of them is nowhere longer than this. (Measured: 2.4 over 10^8 points and seeds; the
/// margin is for what they missed.)
inline constexpr double kNoiseSlope = 3;

}  // namespace fracture
