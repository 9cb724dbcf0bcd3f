// Direction and distance by which a point of a cut moves: several octaves of noise, which fade out towards
// the outer surface.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "common/base/cell_map.hpp"
#include "common/rough/noise.hpp"

namespace fracture {

/// Maximum movement of a point: d + further · dot(d, grain) · grain, where each coordinate of d is at most
/// `each`, m.
struct Movement {
  double each = 0;
  Vec3d grain{};  ///< unit vector, or zero
  double further = 0;
  /// Maximum change of dot(n, p) when p moves.
  double along(const Vec3d& n) const;
  /// Maximum distance that p moves.
  double distance() const { return std::sqrt(3.0) * (1 + further) * each; }
};

/// A function of position only.
class Displacement {
 public:
  /// `amplitude` is in metres, `frequency` in waves per metre. `map`: waves are measured in its image (scaled
  /// so that none becomes shorter). If cells are longer along a grain, points move farther along it by the
  /// same factor, at most four. So a break across fibres ends in splinters. In the image, where waves are
  /// equally long in all directions, this does not make the surface steeper. `still` (m): points nearer to
  /// the surface than this do not move.
  Displacement(double amplitude, double frequency, std::uint32_t octaves, std::uint64_t seed,
               const CellMap& map, double still);

  /// Distance over which movement across a grain fades, m.
  static double fading(double amplitude);

  /// Maximum movement of the points in one frame of the map.
  Movement most(std::size_t frame = 0) const;
  std::size_t frames() const { return grain_.size(); }
  /// Distance to the surface beyond which the movement is not faded, m. Larger distances have no effect.
  double reach() const;
  /// `surface`: min(distance from p to the surface, reach()). `frame`: the frame of the map, if it has
  /// several.
  Vec3d at(const Vec3d& p, double surface, std::size_t frame = 0) const;

 private:
  double most_;       // maximum along each axis, without grain, m
  double amplitude_;  // amplitude of the coarsest octave
  double frequency_, fading_, still_;
  std::uint32_t octaves_;
  std::uint64_t seed_;
  struct Grain {
    Vec3d direction{};
    double further = 0;  ///< movement along the grain / movement across it, minus 1
  };
  std::vector<Matrix3> to_waves_;  ///< per frame of the map
  std::vector<Grain> grain_;       ///< per frame of the map
};

}  // namespace fracture
