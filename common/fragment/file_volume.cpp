#include "common/fragment/file_volume.hpp"

#include <algorithm>
#include <cmath>

#include "common/base/pacer.hpp"
#include "common/exact/binary_scale.hpp"
#include "common/exact/number_types.hpp"

namespace fracture {

FileVolume file_volume(const Fragment& f, const Execution& execution) {
  Pacer pacer(execution);
  double six = 0;
  Vec3d reach;
  for (const Vec3f& p : f.positions) {
    pacer.step();
    for (int a = 0; a < 3; ++a) reach[a] = std::max(reach[a], std::fabs(to_double(p)[a]));
  }
  const auto term = [&](std::size_t k) {
    return dot(to_double(f.positions[f.indices[k]]),
               cross(to_double(f.positions[f.indices[k + 1]]), to_double(f.positions[f.indices[k + 2]])));
  };
  const std::size_t triangles = f.indices.size() / 3;
  pacer.each(0, triangles, [&](std::size_t t) { six += term(3 * t); });
  // Floats are exact in double. A term is at most 6 r with r = reach.x reach.y reach.z, and is off by fewer
  // than 8 roundings. The k-th partial sum is at most k times that and is rounded once. Together, the error
  // is less than n (n + 16) 2^-53 times that. Long, thin fragments need no better sum.
  const auto n = static_cast<double>(triangles);
  const double r = reach.x * reach.y * reach.z;
  if (std::fabs(six) > n * (n + 16) * 0x1.0p-52 * 6 * r + 1e-300) return {six / 6, six > 0 ? 1 : -1};

  // Compensated summation (Neumaier 1974): `lost` sums up what rounding takes from the partial sums. The
  // remaining error is that of the terms, n 48 2^-53 r, and less than as much again of second order.
  double sum = 0, lost = 0;
  for (std::size_t k = 0; k < f.indices.size(); k += 3) {
    const double t = term(k), next = sum + t;
    lost += std::fabs(sum) >= std::fabs(t) ? (sum - next) + t : (t - next) + sum;
    sum = next;
    pacer.step();
  }
  if (std::fabs(sum + lost) > n * 0x1.0p-46 * r + 1e-300) return {(sum + lost) / 6, sum + lost > 0 ? 1 : -1};

  exact::BinaryScale scale;
  for (const Vec3f& p : f.positions) scale.include(to_double(p));
  exact::BigInt exactly = 0;
  for (std::size_t k = 0; k < f.indices.size(); k += 3) {
    pacer.step(64);
    const auto at = [&](std::size_t m) {
      return scale.scaled<exact::BigInt>(to_double(f.positions[f.indices[m]]));
    };
    exactly += dot(at(k), cross(at(k + 1), at(k + 2)));
    pacer.step(64);
  }
  return {std::ldexp(static_cast<double>(exactly), 3 * scale.lowest_bit()) / 6, exact::sign_of(exactly)};
}

}  // namespace fracture
