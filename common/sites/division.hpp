// Equal cells along an axis, from which product grids (grid, bricks) are built.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "common/base/random.hpp"
#include "common/sites/pattern.hpp"

namespace fracture::sites_detail {

/// `count` cells of equal size along one axis, from `start` in steps of `step`.
struct Division {
  double start, step;
  std::uint32_t count;
};

inline double whole(double x) { return std::fmax(1, std::nearbyint(x)); }

/// Divides the side into a whole number of cells of about `size`.
inline Division fitted(double min, double max, double size) {
  const double n = size > 0 ? whole((max - min) / size) : 1;
  return {min, (max - min) / n, static_cast<std::uint32_t>(std::fmin(n, 2.0 * kMaxPatternSites))};
}

/// Cells of exactly this size that cover the side. A remainder of less than a thousandth of a cell (rounding,
/// for example) belongs to its neighbour.
inline Division covering(double min, double max, double size) {
  const double n = std::fmax(1, std::ceil((max - min) / size - 1e-3));
  return {0.5 * (min + max) - 0.5 * n * size, size,
          static_cast<std::uint32_t>(std::fmin(n, 2.0 * kMaxPatternSites))};
}

/// Coordinates of the sites along one axis: the middles of the cells, each moved by up to half the jitter.
inline std::vector<double> coordinates(const Division& d, double jitter, Random& random) {
  std::vector<double> at;
  for (std::uint32_t k = 0; k < d.count; ++k)
    at.push_back(d.start + (k + 0.5 + jitter * (random.uniform() - 0.5)) * d.step);
  return at;
}

inline double product(const std::array<Division, 3>& d) {
  return static_cast<double>(d[0].count) * d[1].count * d[2].count;
}

}  // namespace fracture::sites_detail
