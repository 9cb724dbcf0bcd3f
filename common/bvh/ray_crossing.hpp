// Winding numbers of closed triangle surfaces by rays, in doubles. Closedness must not depend on them.
#pragma once

#include "common/base/vec.hpp"

namespace fracture {

/// Returns how the ray from the origin towards +x passes through the triangle (a, b, c): 1 outwards, -1
/// inwards, 0 not at all. The sum over a closed surface is its winding number around the origin. In the
/// yz-plane, each edge counts for only one of its two sides (half-open), so a ray through an edge is
/// counted once.
inline int ray_crossing(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const Vec3d corners[3] = {a, b, c};
  int crossings = 0;
  for (int k = 0; k < 3; ++k) {
    const Vec3d &p = corners[k], &q = corners[(k + 1) % 3];
    const bool up = p.y <= 0 && q.y > 0, down = q.y <= 0 && p.y > 0;
    if (!up && !down) continue;
    const double z = up ? p.z * (q.y - p.y) - p.y * (q.z - p.z) : q.z * (p.y - q.y) - q.y * (p.z - q.z);
    if (z > 0) crossings += up ? 1 : -1;
  }
  if (crossings == 0) return 0;
  const Vec3d n = cross(b - a, c - a);
  if (n.x == 0 || !(dot(n, a) / n.x > 0)) return 0;
  return n.x > 0 ? 1 : -1;
}

}  // namespace fracture
