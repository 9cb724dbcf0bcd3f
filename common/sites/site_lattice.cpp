#include <cmath>

#include "common/sites/sites.hpp"

namespace fracture {

Vec3d SiteLattice::snap(const Vec3d& p) const {
  // step is a power of two, so the quotient and the product are exact (if p is below 2^53 steps).
  return {std::nearbyint(p.x / step) * step + 0.0, std::nearbyint(p.y / step) * step + 0.0,
          std::nearbyint(p.z / step) * step + 0.0};
}

SiteLattice site_lattice(const Box& box) {
  const double side = box.longest_side();
  if (!(side > 0)) return {};
  int exponent = 0;
  const double mantissa = std::frexp(side, &exponent);  // side = mantissa * 2^exponent, mantissa in [1/2, 1)
  if (mantissa == 0.5) --exponent;                      // a power of two is its own width
  return {std::ldexp(1.0, exponent - 21)};
}

}  // namespace fracture
