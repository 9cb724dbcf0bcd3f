// One ring of points into triangles: balanced splitting where it is convex, ears where it is not.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/clip/triangulate.hpp"

namespace fracture {

/// True when the ring turns left (or not) at every point, at least once, and winds once.
bool is_convex(std::span<const LatticePoint> points, std::span<const std::uint32_t> ring);

/// Appends ring.size() - 2 triangles that use every edge of the ring exactly once (fewer where the ring
/// passes a point twice and an ear would use one edge both ways). `ring` holds indices into `points`. Where
/// no proper ear exists (the ring crosses itself after rounding) the ear of least |area| is cut: still
/// closed. O(n) for convex rings, O(n^2) otherwise: meant for rings of at most a few hundred points.
void clip_ears(std::span<const LatticePoint> points, std::span<const std::uint32_t> ring,
               std::vector<std::array<std::uint32_t, 3>>& triangles);

}  // namespace fracture
