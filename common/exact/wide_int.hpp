// The fixed-width integers behind the exact predicates, and the scale that turns a set of doubles into them.
//
// Every finite double is an integer multiple of a power of two. Where all coordinates of a point set are
// multiples of one step 2^-k and no larger than 2^61 steps, a polynomial's sign is integer arithmetic whose
// widths are known in advance: no allocation, no loops, no normalisation. That covers every set of doubles in
// one binade range of 61 bits, in particular lattices such as k/21 (58 bits) and generated sites (23 bits
// with the corners).
//
// Only the operations that orient3d and in_sphere need are written: 64 x 128 -> 192, 128 x 192 -> 320, add,
// subtract, sign; two's complement, least significant limb first.
#pragma once

#include <bit>
#include <cstdint>

#include "common/base/vec.hpp"

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
  // As unsigned: a_u = a + 2^64 [a < 0], b_u = b + 2^128 [b < 0]; the surplus b * 2^64 and a * 2^128 goes
  // modulo 2^192.
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
  if (static_cast<std::int64_t>(b.limb[2]) < 0) {  // b_u = b + 2^192: take a * 2^192 away
    const UInt128 top = (static_cast<UInt128>(r.limb[4]) << 64 | r.limb[3]) - ua;
    r.limb[3] = static_cast<std::uint64_t>(top);
    r.limb[4] = static_cast<std::uint64_t>(top >> 64);
  }
  return negative ? WideInt<5>{} - r : r;
}

/// How a set of points becomes integers: coordinate * scale is an integer of magnitude at most 2^61 for each
/// of them. Computed once per point set where it fits; a value of zero means that it does not, and the
/// predicates then look for a scale of the few points of each call, or use integers of any size.
struct PointScale {
  double scale = 0;

  static constexpr int kMaxBits =
      61;  // differences are then below 2^62: in_sphere is 48 * (2^62)^5 < 2^317 < 2^319
  bool fits() const { return scale != 0; }
};

/// Collects the exponents of a point set.
class ScaleBuilder {
 public:
  /// True when the scale may have changed.
  bool include(double v) {
    const auto bits = std::bit_cast<std::uint64_t>(v);
    const int biased = static_cast<int>(bits >> 52 & 0x7ff);
    std::uint64_t mantissa = bits & ((std::uint64_t{1} << 52) - 1);
    if (biased != 0) mantissa |= std::uint64_t{1} << 52;
    if (mantissa == 0) return false;
    const int unit = (biased != 0 ? biased : 1) - 1075;  // v = ± mantissa * 2^unit
    const int low = unit + std::countr_zero(mantissa);
    const int top = unit + std::bit_width(mantissa);
    if (low >= lowest_bit_ && top <= top_bit_) return false;
    if (low < lowest_bit_) lowest_bit_ = low;
    if (top > top_bit_) top_bit_ = top;
    return true;
  }
  bool include(const Vec3d& p) {
    const bool x = include(p.x), y = include(p.y), z = include(p.z);
    return x || y || z;
  }
  PointScale scale() const;

 private:
  int lowest_bit_ = 1 << 20;  // exponent of the lowest set bit seen
  int top_bit_ = -(1 << 20);  // all |values| < 2^top_bit_
};

/// A point as exact multiples of the step.
struct IntPoint {
  std::int64_t x, y, z;
};
inline IntPoint to_integers(const Vec3d& p, const PointScale& s) {
  return {static_cast<std::int64_t>(p.x * s.scale), static_cast<std::int64_t>(p.y * s.scale),
          static_cast<std::int64_t>(p.z * s.scale)};
}
inline IntPoint operator-(const IntPoint& a, const IntPoint& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }

inline bool lexicographic_less(const IntPoint& a, const IntPoint& b) {
  if (a.x != b.x) return a.x < b.x;
  if (a.y != b.y) return a.y < b.y;
  return a.z < b.z;
}

/// A value v with |c| < 2^k for every coordinate c exactly where v < 2^k: the bits of all magnitudes or-ed
/// together.
inline std::uint64_t magnitude_bits(const IntPoint& p) {
  const auto magnitude = [](std::int64_t c) { return static_cast<std::uint64_t>(c < 0 ? -c : c); };
  return magnitude(p.x) | magnitude(p.y) | magnitude(p.z);
}

/// How decisions were made: pass one to a predicate to have it counted; nullptr costs a test on the slow path
/// only.
struct PredicateCounters {
  std::uint64_t exact = 0;  ///< the filter could not certify the sign
  std::uint64_t ties = 0;   ///< exact zero: coplanar (orient3d), or decided by the weights (in_sphere)
};

}  // namespace fracture::exact
