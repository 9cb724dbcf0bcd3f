#include "common/delaunay/big_tetrahedron.hpp"

#include <algorithm>
#include <cmath>

namespace fracture {

std::array<Vec3d, 4> BigTetrahedron::corners() const {
  const Vec3d& c = center;
  return {Vec3d{c.x + half, c.y + half, c.z + half}, Vec3d{c.x + half, c.y - half, c.z - half},
          Vec3d{c.x - half, c.y - half, c.z + half}, Vec3d{c.x - half, c.y + half, c.z - half}};
}

BigTetrahedron big_tetrahedron(const Box& domain) {
  BigTetrahedron big;
  big.domain = domain;
  if (domain.empty()) return big;
  double magnitude = 0;
  for (int a = 0; a < 3; ++a)
    magnitude = std::max(magnitude, std::max(std::fabs(domain.min[a]), std::fabs(domain.max[a])));
  if (magnitude == 0) return big;
  // K is at least 2^-40 of the coordinates' magnitude, so that center ± K are exact doubles (8 + 40 bits),
  // and is far from the subnormals.
  const double least = std::max({2 * domain.longest_side(), 0x1p-40 * magnitude, 0x1p-900});
  int exponent;
  const double mantissa =
      std::frexp(least, &exponent);  // least = mantissa * 2^exponent, mantissa in [0.5, 1)
  big.half = std::ldexp(1.0, mantissa == 0.5 ? exponent - 1 : exponent);
  const double grid = big.half / 256;
  for (int a = 0; a < 3; ++a) big.center[a] = std::nearbyint(domain.center()[a] / grid) * grid;
  return big;
}

}  // namespace fracture
