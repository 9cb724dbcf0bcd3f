// How a symbolic vertex gets its position: a formula over the points that name it, evaluated with a running
// error bound and, where that does not decide the rounding, with integers. Private to clip/.
#pragma once

#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <tuple>

#include "common/clip/positions.hpp"
#include "common/exact/approx.hpp"
#include "common/exact/number_types.hpp"

namespace fracture::clip_detail {

using exact::Approx;
using exact::BigInt;
using exact::BinaryScale;
using exact::Point;

/// An offset numerator / denominator, over any number type.
template <class T>
struct Fraction {
  Point<T> numerator;
  T denominator;
};

// A formula is a struct with its input points (`input`), operator() over any number type, and two constants:
//   kFromFirst  the value is an offset from the first input
//   kDegree     all inputs being scaled by one power of two s, the value is s^kDegree times too large

struct Placed {
  Vec3d point;
  std::array<std::int32_t, 3> steps;
};

/// numerator / denominator, rounded to nearest, ties to even; denominator > 0.
inline BigInt round_quotient(const BigInt& numerator, const BigInt& denominator) {
  BigInt quotient, remainder;
  boost::multiprecision::divide_qr(numerator, denominator, quotient, remainder);
  if (remainder.sign() < 0) {  // floor
    remainder += denominator;
    --quotient;
  }
  const BigInt twice = remainder << 1;
  if (twice > denominator ||
      (twice == denominator && boost::multiprecision::bit_test(BigInt(abs(quotient)), 0)))
    ++quotient;
  return quotient;
}

/// numerator / denominator * 2^exponent as a double (64 quotient bits before the one rounding that shows).
inline double quotient_to_double(const BigInt& numerator, const BigInt& denominator, int exponent) {
  if (numerator.is_zero()) return 0;
  const auto bits = [](const BigInt& v) {
    return static_cast<int>(boost::multiprecision::msb(BigInt(abs(v))));
  };
  const int shift = 64 - (bits(numerator) - bits(denominator));
  const BigInt scaled = shift >= 0 ? BigInt(numerator << shift) : numerator;
  const BigInt below = shift >= 0 ? denominator : BigInt(denominator << -shift);
  return std::ldexp(static_cast<double>(BigInt(scaled / below)), exponent - shift);
}

template <class Formula>
Placed place_exactly(const Formula& formula, const SeamLattice& lattice) {
  BinaryScale scale;
  for (const Vec3d& p : formula.input) scale.include(p);
  std::array<Point<BigInt>, std::tuple_size_v<decltype(formula.input)>> p;
  for (std::size_t k = 0; k < p.size(); ++k) p[k] = scale.scaled<BigInt>(formula.input[k]);
  Fraction<BigInt> f = formula(p);
  if (f.denominator.sign() < 0) f = {{-f.numerator.x, -f.numerator.y, -f.numerator.z}, -f.denominator};
  const std::array<BigInt, 3> offset{f.numerator.x, f.numerator.y, f.numerator.z};
  const std::array<BigInt, 3> origin{p[0].x, p[0].y, p[0].z};
  const int exponent = Formula::kDegree * scale.lowest_bit;
  Placed placed;
  for (int a = 0; a < 3; ++a) {
    const BigInt numerator = Formula::kFromFirst ? BigInt(origin[a] * f.denominator + offset[a]) : offset[a];
    placed.point[a] = quotient_to_double(numerator, f.denominator, exponent);
    // In units of the lattice: times 2^(exponent - that of the lattice).
    const int shift = exponent - lattice.exponent[a];
    const BigInt rounded = shift >= 0 ? round_quotient(numerator << shift, f.denominator)
                                      : round_quotient(numerator, f.denominator << -shift);
    placed.steps[a] = static_cast<std::int32_t>(rounded);
  }
  return placed;
}

template <class Formula>
Placed place(const Formula& formula, const SeamLattice& lattice, const Vec3d& step,
             std::atomic<std::uint64_t>& exact) {
  std::array<Point<Approx>, std::tuple_size_v<decltype(formula.input)>> p;
  for (std::size_t k = 0; k < p.size(); ++k) {
    const Vec3d& q = formula.input[k];
    p[k] = {Approx(q.x), Approx(q.y), Approx(q.z)};
  }
  const Fraction<Approx> f = formula(p);
  // A formula is a quotient, so what underflow takes from either polynomial matters: bound(), not `error`.
  const double den = f.denominator.value, den_error = f.denominator.bound();
  Placed placed;
  bool certain = std::fabs(den) > 2 * den_error;
  const std::array<Approx, 3> offset{f.numerator.x, f.numerator.y, f.numerator.z};
  for (int a = 0; a < 3 && certain; ++a) {
    const double q = offset[a].value / den;
    const double x = Formula::kFromFirst ? formula.input[0][a] + q : q;
    const double error =
        1.001 * (offset[a].bound() + std::fabs(q) * den_error) / (std::fabs(den) - den_error) +
        0x1.0p-52 * (std::fabs(q) + std::fabs(x));
    // A double that is good to a thousandth of a step serves for figures; a rounding that the error cannot
    // change is the exact one.
    const double y = x / step[a], k = std::nearbyint(y);
    certain = error <= 0.001 * step[a] && std::fabs(y - k) + error / step[a] < 0.4999999;
    placed.point[a] = x;
    if (certain) placed.steps[a] = static_cast<std::int32_t>(k);
  }
  if (certain) return placed;
  exact.fetch_add(1, std::memory_order_relaxed);
  return place_exactly(formula, lattice);
}

}  // namespace fracture::clip_detail
