#include "common/clip/least_area.hpp"

#include <utility>

namespace fracture {

bool triangulate_least_area(std::span<const LatticePoint> points, std::span<const std::uint32_t> ring,
                            std::vector<std::array<std::uint32_t, 3>>& triangles) {
  const std::size_t n = ring.size();
  if (n < 3) return true;
  constexpr __int128 kNone = static_cast<__int128>(1) << 120;  // no triangulation; sums do not overflow
  struct Best {
    __int128 area = 0;
    std::size_t corner = 0;  ///< the third corner of the triangle at the chord
  };
  // The best triangulation of the sub-ring from corner i to corner j, whose last side is the chord from j to
  // i.
  std::vector<Best> table(n * n);
  const auto best = [&](std::size_t i, std::size_t j) -> Best& { return table[i * n + j]; };
  const auto area = [&](std::size_t i, std::size_t k, std::size_t j) -> __int128 {
    if (ring[i] == ring[k] || ring[k] == ring[j] || ring[j] == ring[i]) return kNone;
    const std::int64_t twice = orient2d(points[ring[i]], points[ring[k]], points[ring[j]]);
    return twice < 0 ? -twice : twice;
  };
  for (std::size_t width = 2; width < n; ++width)
    for (std::size_t i = 0; i + width < n; ++i) {
      const std::size_t j = i + width;
      Best least{kNone, i + 1};
      for (std::size_t k = i + 1; k < j; ++k)
        if (const __int128 sum = best(i, k).area + best(k, j).area + area(i, k, j); sum < least.area)
          least = {sum, k};
      best(i, j) = least;
    }
  if (best(0, n - 1).area >= kNone) return false;

  std::vector<std::pair<std::size_t, std::size_t>> chords{{0, n - 1}};
  while (!chords.empty()) {
    const auto [i, j] = chords.back();
    chords.pop_back();
    if (j - i < 2) continue;
    const std::size_t k = best(i, j).corner;
    triangles.push_back({ring[i], ring[k], ring[j]});
    chords.emplace_back(i, k);
    chords.emplace_back(k, j);
  }
  return true;
}

}  // namespace fracture
