// Fixed-width integers for the exact predicates, for points that fit a BinaryScale.
//
// Implements only the operations that orient3d and in_sphere need: 64 x 128 -> 192, 128 x 192 -> 320, add,
// subtract, sign. Two's complement, least significant limb first.
#pragma once

#include <cstdint>

#include "common/exact/binary_scale.hpp"

namespace fracture::exact {

using Int128 = __int128;
using UInt128 = unsigned __int128;

template <int N>
struct WideInt {
  std::uint64_t limb[N];

  int sign() const {
    if (static_cast<std::int64_t>(limb[N - 1]) < 0) return -1;
    std::uint64_t any = 0;
    for (int i = 0; i < N; ++i) any |= limb[i];
    return any != 0;
  }
  friend WideInt operator+(const WideInt& a, const WideInt& b) {
    WideInt r;
    UInt128 carry = 0;
    for (int i = 0; i < N; ++i) {
      carry += static_cast<UInt128>(a.limb[i]) + b.limb[i];
      r.limb[i] = static_cast<std::uint64_t>(carry);
      carry >>= 64;
    }
    return r;
  }
  friend WideInt operator-(const WideInt& a, const WideInt& b) {
    WideInt r;
    UInt128 carry = 1;  // a + ~b + 1
    for (int i = 0; i < N; ++i) {
      carry += static_cast<UInt128>(a.limb[i]) + ~b.limb[i];
      r.limb[i] = static_cast<std::uint64_t>(carry);
      carry >>= 64;
    }
    return r;
  }
};

/// a * b, exact: |a| < 2^63, |b| < 2^127.
inline WideInt<3> multiply(std::int64_t a, Int128 b) {
  const auto ua = static_cast<std::uint64_t>(a);
  const auto ub = static_cast<UInt128>(b);
  const auto b0 = static_cast<std::uint64_t>(ub), b1 = static_cast<std::uint64_t>(ub >> 64);
  const UInt128 low = static_cast<UInt128>(ua) * b0;
  const UInt128 high = static_cast<UInt128>(ua) * b1 + static_cast<std::uint64_t>(low >> 64);
  // As unsigned numbers, a_u = a + 2^64 [a < 0] and b_u = b + 2^128 [b < 0]. The excess b * 2^64 and a *
  // 2^128 is subtracted modulo 2^192.
  const UInt128 fixed = high - (a < 0 ? ub : 0) - (b < 0 ? static_cast<UInt128>(ua) << 64 : 0);
  return {{static_cast<std::uint64_t>(low), static_cast<std::uint64_t>(fixed),
           static_cast<std::uint64_t>(fixed >> 64)}};
}

/// a * b, exact: |a| < 2^127, b any 192-bit value.
inline WideInt<5> multiply(Int128 a, const WideInt<3>& b) {
  const bool negative = a < 0;
  const UInt128 ua = negative ? 0 - static_cast<UInt128>(a) : static_cast<UInt128>(a);
  const std::uint64_t a0 = static_cast<std::uint64_t>(ua), a1 = static_cast<std::uint64_t>(ua >> 64);
  WideInt<5> r{};
  std::uint64_t carry = 0;
  for (int i = 0; i < 3; ++i) {
    const UInt128 t = static_cast<UInt128>(a0) * b.limb[i] + carry;
    r.limb[i] = static_cast<std::uint64_t>(t);
    carry = static_cast<std::uint64_t>(t >> 64);
  }
  r.limb[3] = carry;
  carry = 0;
  for (int i = 0; i < 3; ++i) {
    const UInt128 t = static_cast<UInt128>(a1) * b.limb[i] + r.limb[i + 1] + carry;
    r.limb[i + 1] = static_cast<std::uint64_t>(t);
    carry = static_cast<std::uint64_t>(t >> 64);
  }
  r.limb[4] = carry;
  if (static_cast<std::int64_t>(b.limb[2]) < 0) {  // b_u = b + 2^192: subtract a * 2^192
    const UInt128 top = (static_cast<UInt128>(r.limb[4]) << 64 | r.limb[3]) - ua;
    r.limb[3] = static_cast<std::uint64_t>(top);
    r.limb[4] = static_cast<std::uint64_t>(top >> 64);
  }
  return negative ? WideInt<5>{} - r : r;
}

/// The bitwise or of the magnitudes of all coordinates: a value v that is below 2^k if and only if |c| < 2^k for
/// every coordinate c.
inline std::uint64_t magnitude_bits(const IntPoint& p) {
  const auto magnitude = [](std::int64_t c) { return static_cast<std::uint64_t>(c < 0 ? -c : c); };
  return magnitude(p.x) | magnitude(p.y) | magnitude(p.z);
}

}  // namespace fracture::exact
