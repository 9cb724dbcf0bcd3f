#include "common/rough/shortest_triangulation.hpp"

#include <cmath>
#include <cstddef>
#include <utility>

namespace fracture {

const std::vector<std::array<std::uint32_t, 3>>& ShortestTriangulation::build(std::span<const Vec2d> polygon,
                                                                              Pacer& pacer) {
  triangles_.clear();
  const std::size_t n = polygon.size();
  least_.assign(n * n, 0);
  middle_.assign(n * n, 0);
  for (std::size_t gap = 2; gap < n; ++gap)
    for (std::size_t i = 0; i + gap < n; ++i) {
      const std::size_t j = i + gap;
      pacer.step(gap);
      double best = HUGE_VAL;
      for (std::size_t k = i + 1; k < j; ++k) {
        const double sum = least_[i * n + k] + least_[k * n + j];
        if (sum < best) {
          best = sum;
          middle_[i * n + j] = static_cast<std::uint32_t>(k);
        }
      }
      least_[i * n + j] = best + square_distance(polygon[i], polygon[j]);
    }
  std::vector<std::pair<std::uint32_t, std::uint32_t>> sides{{0, static_cast<std::uint32_t>(n - 1)}};
  while (!sides.empty()) {
    const auto [i, j] = sides.back();
    sides.pop_back();
    if (j - i < 2) continue;
    const std::uint32_t k = middle_[i * n + j];
    triangles_.push_back({i, k, j});
    sides.push_back({i, k});
    sides.push_back({k, j});
  }
  return triangles_;
}

}  // namespace fracture
