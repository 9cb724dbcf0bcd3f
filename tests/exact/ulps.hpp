// Neighbouring doubles.
#pragma once

#include <cmath>

namespace fracture::test {

/// The n-th double after v, or before v if n is negative.
inline double ulps(double v, int n) {
  for (; n > 0; --n) v = std::nextafter(v, HUGE_VAL);
  for (; n < 0; ++n) v = std::nextafter(v, -HUGE_VAL);
  return v;
}

}  // namespace fracture::test
