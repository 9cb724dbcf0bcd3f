#include "common/exact/wide_int.hpp"

#include <cmath>

namespace fracture::exact {

PointScale ScaleBuilder::scale() const {
  if (top_bit_ < lowest_bit_) return {1.0};  // only zeros
  if (top_bit_ - lowest_bit_ > PointScale::kMaxBits) return {};
  if (lowest_bit_ < -1000 || lowest_bit_ > 1000) return {};  // 2^-lowest_bit_ must be a normal double
  return {std::ldexp(1.0, -lowest_bit_)};
}

}  // namespace fracture::exact
