// The tetrahedron that contains everything (paper, section 2.2). Its corners are (±K, ±K, ±K) with an even
// sign product, about the centre of U, the box of mesh and sites. It contains the octahedron |x| + |y| + |z|
// <= K. So it contains U if K >= 1.5 longest sides. In fact, K is at least 2 longest sides. So every corner
// is more than a diagonal of U away from U. Then the Voronoi diagram of sites and corners equals that of the
// sites inside U, and N = 1, coplanar and collinear sets need no special case.
//
// K is a power of two, and the centre is a multiple of K / 256, so the corners do not make the exact integers
// wider. If the sites are on a power-of-two lattice in which U is n bits wide, the corners have n + 2 bits on
// the same lattice.
#pragma once

#include <array>

#include "common/base/vec.hpp"

namespace fracture {

struct BigTetrahedron {
  Box domain;  ///< U: contains every site
  Vec3d center;
  double half = 1;  ///< K

  /// Positive order: orient3d(corners) > 0.
  std::array<Vec3d, 4> corners() const;
  /// Whether p is in U; false for NaN.
  bool contains(const Vec3d& p) const {
    return p.x >= domain.min.x && p.x <= domain.max.x && p.y >= domain.min.y && p.y <= domain.max.y &&
           p.z >= domain.min.z && p.z <= domain.max.z;
  }
};

/// Returns it for any finite box, possibly empty or flat, with |coordinates| <= 1e12.
BigTetrahedron big_tetrahedron(const Box& domain);

}  // namespace fracture
