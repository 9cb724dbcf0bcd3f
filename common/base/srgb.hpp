// The transfer function of sRGB (IEC 61966-2-1).
#pragma once

#include <cmath>

namespace fracture {

/// Linear light of a component from 0 to 1. The last bits of pow() differ between C libraries, so round the result before it
/// decides bytes.
inline double linear_of_srgb(double srgb) {
  return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
}

/// The component in sRGB of linear light from 0 to 1.
inline double srgb_of_linear(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

}  // namespace fracture
