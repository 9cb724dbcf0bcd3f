// What is asked of rough cuts.
#pragma once

#include <cstdint>

namespace fracture {

/// In terms of the solid's size: the cube root of the volume of its largest part, m.
struct Roughness {
  double amplitude = 0;  ///< of the size: the most a vertex moves along each axis (along fibres four
                         ///< times as much, rough/displacement.hpp); 0: flat cuts
  double frequency = 5;  ///< waves of the coarsest octave along the size
  std::uint32_t octaves =
      2;  ///< 1 to 6; each has twice the frequency and half the amplitude of the one before
  friend bool operator==(const Roughness&, const Roughness&) = default;
};

}  // namespace fracture
