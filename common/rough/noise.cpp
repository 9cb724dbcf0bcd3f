#include "common/rough/noise.hpp"

#include <cmath>

#include "common/base/random.hpp"

namespace fracture {
namespace {

/// Dot product of d with one of the twelve vectors from the middle of a cube to the middles of its edges.
double along_gradient(unsigned which, const Vec3d& d) {
  const double u = which < 8 ? d.x : d.y, v = which < 4 ? d.y : d.z;
  return (which & 1 ? -u : u) + (which & 2 ? -v : v);
}

double ease(double t) { return t * t * t * (t * (t * 6 - 15) + 10); }

}  // namespace

Vec3d gradient_noise(const Vec3d& p, std::uint64_t seed) {
  const Vec3d cell{std::floor(p.x), std::floor(p.y), std::floor(p.z)};
  const Vec3d d = p - cell, s{ease(d.x), ease(d.y), ease(d.z)};
  const auto bits = [](double whole) { return static_cast<std::uint64_t>(static_cast<std::int64_t>(whole)); };
  Vec3d sum;
  std::uint64_t by_x[2], by_xy[4];
  for (unsigned x = 0; x < 2; ++x) by_x[x] = mix64(seed ^ (bits(cell.x) + x));
  for (unsigned xy = 0; xy < 4; ++xy) by_xy[xy] = mix64(by_x[xy & 1] + bits(cell.y) + (xy >> 1));
  for (unsigned corner = 0; corner < 8; ++corner) {
    const unsigned x = corner & 1, y = corner >> 1 & 1, z = corner >> 2;
    const std::uint64_t hash = mix64(by_xy[corner & 3] + bits(cell.z) + z);
    const double weight = (x ? s.x : 1 - s.x) * (y ? s.y : 1 - s.y) * (z ? s.z : 1 - s.z);
    const Vec3d from{d.x - x, d.y - y, d.z - z};
    // Three independent choices out of twelve from one hash, each from sixteen of its bits.
    const auto pick = [&](unsigned shift) {
      return static_cast<unsigned>((hash >> shift & 0xffff) * 12 >> 16);
    };
    sum = sum + weight * Vec3d{along_gradient(pick(0), from), along_gradient(pick(16), from),
                               along_gradient(pick(32), from)};
  }
  return sum;
}

}  // namespace fracture
