#include "common/gltf/cut_detail.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <iterator>

#include "common/base/random.hpp"
#include "common/gltf/png.hpp"

namespace fracture {
namespace {

/// The appearance of a kind of relief: octaves of noise, depth and roughness.
struct Relief {
  std::array<std::uint32_t, 2> cells;  ///< number in the first octave's lattice, along u and v
  int octaves;
  double fade;       ///< amplitude of each octave relative to the previous one
  double height;     ///< amplitude, in widths of the texture
  double pits;       ///< how deep pits are: heights below -0.25 are deepened by 4 times this
  double roughness;  ///< at height 0
  double spread;     ///< decrease of the roughness per unit of height
};

constexpr Relief relief_of(CutDetail detail) {
  switch (detail) {
    case CutDetail::kConcrete:
      return {{6, 6}, 5, 0.6, 0.012, 0.6, 0.92, 0.10};
    case CutDetail::kWood:
      return {{48, 3}, 3, 0.5, 0.006, 0, 0.80, 0.20};
    case CutDetail::kBrick:
      return {{24, 24}, 3, 0.7, 0.010, 0.3, 0.95, 0.08};
    default:
      return {{5, 5}, 6, 0.55, 0.022, 0, 0.88, 0.15};
  }
}

/// Gradient noise: 0 at lattice points; repeats after `cells` lattice cells.
double noise(double x, double y, const std::array<std::uint32_t, 2>& cells, std::uint64_t seed) {
  const auto cx = static_cast<std::uint32_t>(x), cy = static_cast<std::uint32_t>(y);
  const double fx = x - cx, fy = y - cy;
  const auto corner = [&](std::uint32_t dx, std::uint32_t dy) {
    constexpr double kGradients[8][2] = {{1, 0},       {-1, 0},       {0, 1},        {0, -1},
                                         {0.75, 0.75}, {-0.75, 0.75}, {0.75, -0.75}, {-0.75, -0.75}};
    const auto& g = kGradients[mix64(mix64(seed, (cx + dx) % cells[0]), (cy + dy) % cells[1]) >> 61];
    return g[0] * (fx - dx) + g[1] * (fy - dy);
  };
  const auto smooth = [](double t) { return t * t * t * (t * (t * 6 - 15) + 10); };
  const double u = smooth(fx), v = smooth(fy);
  const double top = corner(0, 0) + u * (corner(1, 0) - corner(0, 0));
  const double bottom = corner(0, 1) + u * (corner(1, 1) - corner(0, 1));
  return top + v * (bottom - top);
}

/// Returns the heights of all pixels: -1 to 1, and down to -2 in pits.
std::vector<double> heights(const Relief& relief, std::uint64_t seed) {
  std::vector<double> height(std::size_t{kDetailSide} * kDetailSide, 0);
  double share = 1, all = 0;
  std::array<std::uint32_t, 2> cells = relief.cells;
  for (int octave = 0; octave < relief.octaves; ++octave) {
    for (std::uint32_t y = 0; y < kDetailSide; ++y)
      for (std::uint32_t x = 0; x < kDetailSide; ++x)
        height[std::size_t{y} * kDetailSide + x] +=
            share * noise((x + 0.5) * cells[0] / kDetailSide, (y + 0.5) * cells[1] / kDetailSide, cells,
                          seed + static_cast<std::uint64_t>(octave));
    all += share;
    share *= relief.fade;
    for (std::uint32_t& count : cells) count *= 2;
  }
  for (double& h : height) {
    h = std::clamp(1.6 * h / all, -1.0, 1.0);
    h = h < -0.25 ? h - relief.pits * (-0.25 - h) * 4 : h;
    h = std::max(h, -2.0);
  }
  return height;
}

std::uint8_t byte_of(double unit) {
  return static_cast<std::uint8_t>(std::nearbyint(255 * std::clamp(unit, 0.0, 1.0)));
}

DetailMaps make_maps(CutDetail detail) {
  const Relief relief = relief_of(detail);
  const std::vector<double> height = heights(relief, 0x51ab5eed + static_cast<std::uint64_t>(detail));
  const auto at = [&](std::uint32_t x, std::uint32_t y) {
    return height[std::size_t{y % kDetailSide} * kDetailSide + x % kDetailSide];
  };
  std::vector<std::array<std::uint8_t, 3>> normal, roughness;
  for (std::uint32_t y = 0; y < kDetailSide; ++y)
    for (std::uint32_t x = 0; x < kDetailSide; ++x) {
      // Slopes along u and along the texture's up direction, which is -v.
      const double scale = relief.height * kDetailSide / 2;
      const double du = scale * (at(x + 1, y) - at(x + kDetailSide - 1, y));
      const double dv = scale * (at(x, y + kDetailSide - 1) - at(x, y + 1));
      const double size = std::sqrt(du * du + dv * dv + 1);
      normal.push_back(
          {byte_of(0.5 - 0.5 * du / size), byte_of(0.5 - 0.5 * dv / size), byte_of(0.5 + 0.5 / size)});
      roughness.push_back({0, byte_of(relief.roughness - relief.spread * at(x, y)), 0});
    }
  return {write_png(normal, kDetailSide, kDetailSide), write_png(roughness, kDetailSide, kDetailSide)};
}

std::atomic<bool> made[std::size(kCutDetailNames)];

template <CutDetail kDetail>
const DetailMaps& made_once() {
  static const DetailMaps maps = make_maps(kDetail);
  made[static_cast<std::size_t>(kDetail)] = true;
  return maps;
}

}  // namespace

const DetailMaps& detail_maps(CutDetail detail) {
  switch (detail) {
    case CutDetail::kConcrete:
      return made_once<CutDetail::kConcrete>();
    case CutDetail::kWood:
      return made_once<CutDetail::kWood>();
    case CutDetail::kBrick:
      return made_once<CutDetail::kBrick>();
    default:
      return made_once<CutDetail::kStone>();
  }
}

bool has_detail_maps(CutDetail detail) { return made[static_cast<std::size_t>(detail)]; }

}  // namespace fracture
