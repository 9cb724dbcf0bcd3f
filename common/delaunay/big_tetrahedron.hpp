// The tetrahedron that contains everything (paper, section 2.2): corners (±K, ±K, ±K) with even sign product
// about the centre of U, the box of mesh and sites. It contains the octahedron |x| + |y| + |z| <= K, hence U
// for K >= 1.5 longest side. With K >= 2 longest sides every corner is more than a diagonal of U away from U,
// so that inside U the Voronoi diagram of sites and corners is that of the sites, and N = 1, coplanar and
// collinear sets need no special case.
//
// K is a power of two and the centre a multiple of K / 256, so that the corners do not widen the exact
// integers: sites on a power-of-two lattice in which U is n bits wide give corners of n + 2 bits on the same
// lattice.
#pragma once

#include <array>

#include "common/base/vec.hpp"

namespace fracture {

struct BigTetrahedron {
  Box domain;  ///< U: every site lies in it
  Vec3d center;
  double half = 1;  ///< K

  /// Positive order: orient3d(corners) > 0.
  std::array<Vec3d, 4> corners() const;
  /// p in U; false for NaN.
  bool contains(const Vec3d& p) const {
    return p.x >= domain.min.x && p.x <= domain.max.x && p.y >= domain.min.y && p.y <= domain.max.y &&
           p.z >= domain.min.z && p.z <= domain.max.z;
  }
};

/// For any finite, possibly empty or flat box with |coordinates| <= 1e12.
BigTetrahedron big_tetrahedron(const Box& domain);

}  // namespace fracture
