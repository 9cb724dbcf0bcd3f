// Divides polygons as most tools do: a fan from the first corner, like common OBJ readers. Flat polygons with a reflex corner
// are the exception, because a fan is wrong for them.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/vec.hpp"

namespace fracture {

/// Whether the polygon is flat (within kFlat of its extent) and has a reflex corner, so that a fan would fold over itself.
inline constexpr double kFlat = 1e-3;
bool flat_with_reflex_corner(std::span<const Vec3d> corners);

/// Appends the n - 2 triangles of a polygon with n >= 3 corners, in its direction: corner k has the number first + k. Flat
/// polygons with a reflex corner are divided like holes (solid/loop_triangulation.hpp; Barequet & Sharir 1995, Meisters 1975).
/// Corners that are not finite give a fan.
void append_polygon(std::span<const Vec3d> corners, std::uint32_t first,
                    std::vector<std::array<std::uint32_t, 3>>& triangles);

}  // namespace fracture
