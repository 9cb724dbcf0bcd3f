// The requested roughness of cuts.
#pragma once

#include <cstdint>

namespace fracture {

/// Relative to the solid's size: the cube root of the volume of its largest part, m.
struct Roughness {
  double amplitude = 0;  ///< maximum movement of a vertex along each axis / size (along fibres up to four
                         ///< times as much, rough/displacement.hpp); 0: flat cuts
  double frequency = 5;  ///< number of waves of the coarsest octave in one size
  std::uint32_t octaves = 2;  ///< 1 to 6; each octave doubles the frequency and halves the amplitude
  friend bool operator==(const Roughness&, const Roughness&) = default;
};

}  // namespace fracture
