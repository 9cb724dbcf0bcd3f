// Integers of many bits for the exact path (binary_scale.hpp), for what the fixed widths of wide_int.hpp do
// not hold.
#pragma once

#include <boost/multiprecision/cpp_int.hpp>

#include "common/exact/binary_scale.hpp"

namespace fracture::exact {

/// Fixed capacity, no allocation: enough for degree-9 polynomials in coordinates that span 100 bits.
using FixedInt = boost::multiprecision::number<
    boost::multiprecision::cpp_int_backend<1024, 1024, boost::multiprecision::signed_magnitude,
                                           boost::multiprecision::unchecked, void>,
    boost::multiprecision::et_off>;
/// Any size: float32 coordinates may span 280 bits (6e-17 beside 1e3 is common: cos 90° in exported files).
using BigInt =
    boost::multiprecision::number<boost::multiprecision::cpp_int_backend<>, boost::multiprecision::et_off>;

/// Of a built-in number or one of these.
template <class Number>
int sign_of(const Number& v) {
  if constexpr (requires { v.sign(); })
    return v.sign();
  else
    return (v > 0) - (v < 0);
}

}  // namespace fracture::exact
