// How far and whereto a point of a cut moves: several octaves of noise, faded out towards the outer surface.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "common/base/cell_map.hpp"
#include "common/rough/noise.hpp"

namespace fracture {

/// How far points may move at most: by d + further · dot(d, grain) · grain, each coordinate of d at most `each`, m.
struct Movement {
  double each = 0;
  Vec3d grain{};  ///< of unit length, or zero
  double further = 0;
  /// The most by which dot(n, p) changes when p moves.
  double along(const Vec3d& n) const;
  /// The most by which p moves.
  double distance() const { return std::sqrt(3.0) * (1 + further) * each; }
};

/// A function of position alone.
class Displacement {
 public:
  /// `amplitude` in metres, `frequency` in waves per metre; `map`: waves are counted in its image (scaled so
  /// that none is shorter than without it). Where cells are longer along a grain points move as many times as far
  /// along it, up to four: what breaks across fibres ends in splinters. In the image, where waves are as long in all
  /// directions, that is no steeper than without. `still` (m): nothing moves that is nearer to the surface.
  Displacement(double amplitude, double frequency, std::uint32_t octaves, std::uint64_t seed,
               const CellMap& map, double still);

  /// Across a grain, movement fades over so many metres.
  static double fading(double amplitude);

  /// Of the points of a frame of the map.
  Movement most(std::size_t frame = 0) const;
  std::size_t frames() const { return grain_.size(); }
  /// The distance to the surface from which on the movement is not faded, m: the most that matters.
  double reach() const;
  /// `surface`: min(distance from p to the surface, reach()). `frame`: of the map, where it has several.
  Vec3d at(const Vec3d& p, double surface, std::size_t frame = 0) const;

 private:
  double most_;       // m, along each axis, but for grain
  double amplitude_;  // that of the coarsest octave of noise
  double frequency_, fading_, still_;
  std::uint32_t octaves_;
  std::uint64_t seed_;
  struct Grain {
    Vec3d direction{};
    double further = 0;  ///< how many times as far along it as without, less 1
  };
  std::vector<Matrix3> to_waves_;  ///< one for each frame of the map
  std::vector<Grain> grain_;       ///< the same
};

}  // namespace fracture
