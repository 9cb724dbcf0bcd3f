// How far and whereto a point of a cut moves: several octaves of noise, faded out towards the outer surface.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/cell_map.hpp"
#include "common/rough/noise.hpp"

namespace fracture {

/// A function of position alone.
class Displacement {
 public:
  /// `amplitude` in metres, `frequency` in waves per metre; `map`: waves are counted in its image (scaled so
  /// that none is shorter than without it).
  Displacement(double amplitude, double frequency, std::uint32_t octaves, std::uint64_t seed,
               const CellMap& map);

  /// The distance to the surface from which on the movement is not faded, m: the most that matters.
  double reach() const;
  /// `surface`: min(distance from p to the surface, reach()). `frame`: of the map, where it has several.
  Vec3d at(const Vec3d& p, double surface, std::size_t frame = 0) const;

 private:
  double amplitude_, frequency_;
  std::uint32_t octaves_;
  std::uint64_t seed_;
  std::vector<Matrix3> to_waves_;  ///< one for each frame of the map
};

}  // namespace fracture
