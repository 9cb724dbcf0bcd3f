#include "common/rough/displacement.hpp"

#include <cmath>

#include "common/base/long_axis.hpp"
#include "common/base/random.hpp"

namespace fracture {
namespace {

/// Distance over which movement fades, in amplitudes. It can be this short because noise rarely exceeds half
/// of its bound.
constexpr double kFade = 1.2;
/// No point moves by more than this share of its distance to the surface, so no point reaches the surface.
constexpr double kMostOfDistance = 0.6;

/// Maximum ratio of the movement along a grain to the movement across it.
constexpr double kMostAlong = 4;
/// Cells that are shorter than this many widths do not count as fibres. Otherwise, strips of metal, which
/// have fine waves, would take a third longer to compute.
constexpr double kLeastStretch = 6;

/// An upper bound of the factor by which the map lengthens a vector: sqrt(largest row sum · largest column
/// sum).
double bound_of_norm(const Matrix3& m) {
  double rows = 0, columns = 0;
  for (int k = 0; k < 3; ++k) {
    double row = 0, column = 0;
    for (int a = 0; a < 3; ++a) {
      row += std::fabs(m.rows[static_cast<std::size_t>(k)][a]);
      column += std::fabs(m.rows[static_cast<std::size_t>(a)][k]);
    }
    rows = std::fmax(rows, row);
    columns = std::fmax(columns, column);
  }
  return std::sqrt(rows * columns);
}

}  // namespace

// The change is dot(g, d). d is in a cube, and so also in the ball around this cube.
double Movement::along(const Vec3d& n) const {
  const Vec3d g = n + (further * dot(n, grain)) * grain;
  const double sum = std::fabs(g.x) + std::fabs(g.y) + std::fabs(g.z);
  return each * std::fmin(sum, std::sqrt(3.0) * length(g));
}

Displacement::Displacement(double amplitude, double frequency, std::uint32_t octaves, std::uint64_t seed,
                           const CellMap& map, double still)
    : most_(amplitude),
      amplitude_(amplitude),
      frequency_(frequency),
      fading_(fading(amplitude)),
      still_(still),
      octaves_(octaves),
      seed_(seed) {
  double sum = 0, share = 1;
  for (std::uint32_t o = 0; o < octaves; ++o, share *= 0.5) sum += share;
  amplitude_ /= sum * kNoiseBound;
  for (const CellMap::Frame& frame : map.frames()) {
    const double scale = 1 / bound_of_norm(frame.matrix);
    Matrix3& to_waves = to_waves_.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) to_waves.rows[k] = scale * frame.matrix.rows[k];
    Grain& grain = grain_.emplace_back();
    // N Nᵀ of the inverse map N, which shapes the cells: its eigenvalues are their squared lengths
    Matrix3 lengths;
    for (std::size_t i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        lengths.rows[i][j] = dot(frame.inverse.rows[i], frame.inverse.rows[static_cast<std::size_t>(j)]);
    const std::optional<LongAxis> longest = long_axis(lengths);
    if (!longest || !(longest->ratio > kLeastStretch * kLeastStretch)) continue;
    grain = {longest->axis, std::fmin(std::sqrt(longest->ratio), kMostAlong) - 1};
  }
  if (to_waves_.empty()) {
    to_waves_.emplace_back();
    grain_.emplace_back();
  }
}

Movement Displacement::most(std::size_t frame) const {
  return {most_, grain_[frame].direction, grain_[frame].further};
}

double Displacement::fading(double amplitude) { return kFade * amplitude; }

double Displacement::reach() const {
  double further = 0;
  for (const Grain& grain : grain_) further = std::fmax(further, grain.further);
  return still_ + (1 + further) * fading_;
}

Vec3d Displacement::at(const Vec3d& p, double surface, std::size_t frame) const {
  if (surface <= still_) return {};
  const Vec3d q = to_waves_[frame] * p;
  Vec3d d;
  double share = 1, frequency = frequency_;
  for (std::uint32_t o = 0; o < octaves_; ++o, share *= 0.5, frequency *= 2)
    d = d + share * gradient_noise(frequency * q, seed_ * kGoldenGamma + o);
  // Along the grain, the movement is larger, so it also fades over a longer distance.
  const Grain& grain = grain_[frame];
  const double faded = (surface - still_) / fading_, across = std::fmin(1, faded),
               along = std::fmin(1 + grain.further, faded);
  d = amplitude_ * (across * d + ((along - across) * dot(grain.direction, d)) * grain.direction);
  const double l = length(d), most = kMostOfDistance * surface;
  return l > most ? (most / l) * d : d;
}

}  // namespace fracture
