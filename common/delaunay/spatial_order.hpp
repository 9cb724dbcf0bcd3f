// The order of insertion: biased randomized insertion order (Amenta, Choi & Rote 2003), with every round
// along a Hilbert curve (base/hilbert_curve.hpp). Each point is in the last round with probability 7/8,
// otherwise in an earlier one by the same rule. So neighbours in the order are neighbours in space (short
// walks, warm caches), while the order is random enough for the expected bounds of incremental construction.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/execution.hpp"
#include "common/base/vec.hpp"

namespace fracture {

/// Returns a permutation of 0..points.size()-1, a deterministic function of the points in their order. Throws
/// Interrupted.
std::vector<std::uint32_t> spatial_order(std::span<const Vec3d> points,
                                         const Execution& execution = kUninterrupted);

}  // namespace fracture
