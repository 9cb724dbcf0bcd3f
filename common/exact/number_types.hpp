// Large integers for the exact path (binary_scale.hpp), for values that exceed the fixed widths of
// wide_int.hpp.
#pragma once

#include <boost/multiprecision/cpp_int.hpp>

#include "common/exact/binary_scale.hpp"

namespace fracture::exact {

/// Fixed capacity, without allocation: enough for polynomials of degree 9 in coordinates that span 100 bits.
using FixedInt = boost::multiprecision::number<
    boost::multiprecision::cpp_int_backend<1024, 1024, boost::multiprecision::signed_magnitude,
                                           boost::multiprecision::unchecked, void>,
    boost::multiprecision::et_off>;
/// Any size. float32 coordinates may span 280 bits (6e-17 together with 1e3 is common: cos 90° in exported
/// files).
using BigInt =
    boost::multiprecision::number<boost::multiprecision::cpp_int_backend<>, boost::multiprecision::et_off>;

/// Sign of a built-in number or of one of these types.
template <class Number>
int sign_of(const Number& v) {
  if constexpr (requires { v.sign(); })
    return v.sign();
  else
    return (v > 0) - (v < 0);
}

}  // namespace fracture::exact
