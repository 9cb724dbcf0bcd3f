#include "common/exact/wide_int.hpp"

#include <bit>

namespace fracture::exact {

void ScaleBuilder::include(double v) {
  const auto bits = std::bit_cast<std::uint64_t>(v);
  const int biased = static_cast<int>(bits >> 52 & 0x7ff);
  std::uint64_t mantissa = bits & ((std::uint64_t{1} << 52) - 1);
  if (biased != 0) mantissa |= std::uint64_t{1} << 52;
  if (mantissa == 0) return;
  const int unit = (biased != 0 ? biased : 1) - 1075;  // v = ± mantissa * 2^unit
  const int low = unit + std::countr_zero(mantissa);
  const int top = unit + std::bit_width(mantissa);
  if (low < lowest_bit_) lowest_bit_ = low;
  if (top > top_bit_) top_bit_ = top;
}

PointScale ScaleBuilder::scale() const {
  if (top_bit_ < lowest_bit_) return {1.0};  // only zeros
  if (top_bit_ - lowest_bit_ > PointScale::kMaxBits) return {};
  if (lowest_bit_ < -1000 || lowest_bit_ > 1000) return {};  // 2^-lowest_bit_ must be a normal double
  return {std::ldexp(1.0, -lowest_bit_)};
}

}  // namespace fracture::exact
