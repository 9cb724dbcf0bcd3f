// Distances between two triangles.
#pragma once

#include <array>

#include "common/base/vec.hpp"

namespace fracture {

/// Distance between the segments from a to b and from c to d, m (Ericson 2005, Real-Time Collision Detection,
/// 5.1.9). If they are parallel up to rounding, the distance may be between other points of them; distances
/// from the ends also cover this case.
double distance_of_segments(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d);

/// Whether two triangles are nearer to each other than `distance`, m, or cross. Tests their corners, their edges,
/// and whether an edge of one pierces the other. `distance` must be far larger than the rounding error of
/// coordinates.
bool are_within(const std::array<Vec3d, 3>& s, const std::array<Vec3d, 3>& t, double distance);

/// min(distance between two triangles, most), m; 0 if they cross.
double distance_of_triangles(const std::array<Vec3d, 3>& s, const std::array<Vec3d, 3>& t, double most);

}  // namespace fracture
