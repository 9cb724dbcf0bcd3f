// Finds parts that are thin shells around a hidden space. Such a shell is often a mistake of the program that made the mesh.
#pragma once

#include "common/base/execution.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

/// The mean thickness of a double wall is at most this share of the part's longest side.
inline constexpr double kThinWall = 0.04;
/// The inner side of a double wall has at least this share of the area of the outer side.
inline constexpr double kLeastInnerArea = 0.5;
/// A leak is an opening with at most this share of the area of the inner side. The necks of bottles are wider.
inline constexpr double kWidestLeak = 0.005;

/// Warns about parts that are double walls: their inner side follows the outer side at a small distance, so fragments are
/// shards of a thin wall. Programs that make meshes from images often write such parts, although a solid body is meant.
///
/// The mean distance of the two sides is the volume between them, divided by their mean area (Cavalieri's principle). It
/// can only be small if the sides are nearly parallel. If the inner side is a separate shell, its area is known. If a
/// leak connects it with the outer side, both are one shell. Then rays along the normals find the triangles that see the
/// outside. Their largest connected region is the outer side, and the largest region of all others is the inner side.
/// It is a double wall with a leak if its rim is short (kWidestLeak), and if it encloses more space than the wall fills.
/// Walls that SolidOptions::thickness made are none, because the request asks for them.
///
/// Cost: linear, and n log n for parts with one shell that are thin. Among these, parts with more than kMostLeakTriangles
/// triangles are not searched. Throws Interrupted.
void warn_of_double_walls(Solid& solid, const Execution& execution);
inline constexpr std::size_t kMostLeakTriangles = 200'000;

}  // namespace fracture
