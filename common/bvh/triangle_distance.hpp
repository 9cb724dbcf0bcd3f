// How near two triangles come to each other.
#pragma once

#include <array>

#include "common/base/vec.hpp"

namespace fracture {

/// Distance between the segments from a to b and from c to d, m (Ericson 2005, Real-Time Collision Detection, 5.1.9).
/// Where they are parallel but for rounding it may be that between other places of them, which the ends tell as well.
double distance_of_segments(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d);

/// Whether two triangles are nearer to each other than `distance`, m, or cross: by their corners, by their edges, or
/// because an edge of one pierces the other. The distance is far more than rounding does to coordinates.
bool are_within(const std::array<Vec3d, 3>& s, const std::array<Vec3d, 3>& t, double distance);

/// min(distance between two triangles, most), m; 0 where they cross.
double distance_of_triangles(const std::array<Vec3d, 3>& s, const std::array<Vec3d, 3>& t, double most);

}  // namespace fracture
