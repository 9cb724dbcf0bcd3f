#include "common/rough/displacement.hpp"

#include <cmath>

#include "common/base/random.hpp"

namespace fracture {
namespace {

/// Fading takes so many amplitudes: noise is rarely beyond half of what it can be.
constexpr double kFade = 1.2;
/// No point moves by more than this much of its distance from the surface, so that none reaches it.
constexpr double kMostOfDistance = 0.6;

/// At least the largest factor by which the map lengthens a vector: sqrt(largest row sum · largest column
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

Displacement::Displacement(double amplitude, double frequency, std::uint32_t octaves, std::uint64_t seed,
                           const CellMap& map)
    : amplitude_(amplitude), frequency_(frequency), octaves_(octaves), seed_(seed) {
  double sum = 0, share = 1;
  for (std::uint32_t o = 0; o < octaves; ++o, share *= 0.5) sum += share;
  amplitude_ /= sum * kNoiseBound;
  for (const CellMap::Frame& frame : map.frames()) {
    const double scale = 1 / bound_of_norm(frame.matrix);
    Matrix3& to_waves = to_waves_.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) to_waves.rows[k] = scale * frame.matrix.rows[k];
  }
  if (to_waves_.empty()) to_waves_.emplace_back();
}

double Displacement::reach() const {
  double sum = 0, share = 1;
  for (std::uint32_t o = 0; o < octaves_; ++o, share *= 0.5) sum += share;
  return kFade * amplitude_ * sum * kNoiseBound;
}

Vec3d Displacement::at(const Vec3d& p, double surface, std::size_t frame) const {
  if (surface == 0) return {};
  const Vec3d q = to_waves_[frame] * p;
  Vec3d d;
  double share = 1, frequency = frequency_;
  for (std::uint32_t o = 0; o < octaves_; ++o, share *= 0.5, frequency *= 2)
    d = d + share * gradient_noise(frequency * q, seed_ * kGoldenGamma + o);
  d = (amplitude_ * (surface / reach())) * d;
  const double l = length(d), most = kMostOfDistance * surface;
  return l > most ? (most / l) * d : d;
}

}  // namespace fracture
