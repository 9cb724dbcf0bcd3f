// Computes the position of a symbolic vertex: a formula over the points that define it, evaluated with a
// running error bound. If that does not decide the rounding, it is evaluated with integers. Private to clip/.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <tuple>

#include "common/clip/double_double.hpp"
#include "common/clip/positions.hpp"
#include "common/exact/approx.hpp"
#include "common/exact/number_types.hpp"

namespace fracture::clip_detail {

using exact::Approx;
using exact::BigInt;
using exact::BinaryScale;
using exact::Point;

/// An offset numerator / denominator, over any type of number.
template <class T>
struct Fraction {
  Point<T> numerator;
  T denominator;
};

// A formula is a struct with its input points (`input`), operator() over any type of number, and constants:
//   kFromFirst  the value is an offset from the first input
//   kDegree     if all inputs are scaled by a power of two s, the value is scaled by s^kDegree
//   kBetweenFrom, kBetweenTo  range of inputs whose affine hull contains the value; empty: not known

struct Placed {
  Vec3d point;
  std::array<std::int32_t, 3> steps;
};

/// Returns numerator / denominator, rounded to nearest, ties to even; denominator > 0.
template <class Int>
Int round_quotient(const Int& numerator, const Int& denominator) {
  Int quotient, remainder;
  boost::multiprecision::divide_qr(numerator, denominator, quotient, remainder);
  if (remainder.sign() < 0) {  // floor
    remainder += denominator;
    --quotient;
  }
  const Int twice = remainder << 1;
  if (twice > denominator || (twice == denominator && boost::multiprecision::bit_test(Int(abs(quotient)), 0)))
    ++quotient;
  return quotient;
}

/// Returns numerator / denominator * 2^exponent as a double. The quotient has 64 bits before its only
/// significant rounding.
template <class Int>
double quotient_to_double(const Int& numerator, const Int& denominator, int exponent) {
  if (numerator.is_zero()) return 0;
  const auto bits = [](const Int& v) { return static_cast<int>(boost::multiprecision::msb(Int(abs(v)))); };
  const int shift = 64 - (bits(numerator) - bits(denominator));
  const Int scaled = shift >= 0 ? Int(numerator << shift) : numerator;
  const Int below = shift >= 0 ? denominator : Int(denominator << -shift);
  return std::ldexp(static_cast<double>(Int(scaled / below)), exponent - shift);
}

template <class Int, class Formula>
Placed place_with(const Formula& formula, const BinaryScale& scale, const SeamLattice& lattice) {
  std::array<Point<Int>, std::tuple_size_v<decltype(formula.input)>> p;
  for (std::size_t k = 0; k < p.size(); ++k) p[k] = scale.scaled<Int>(formula.input[k]);
  Fraction<Int> f = formula(p);
  if (f.denominator.sign() < 0) f = {{-f.numerator.x, -f.numerator.y, -f.numerator.z}, -f.denominator};
  const std::array<Int, 3> offset{f.numerator.x, f.numerator.y, f.numerator.z};
  const std::array<Int, 3> origin{p[0].x, p[0].y, p[0].z};
  const int exponent = Formula::kDegree * scale.lowest_bit();
  Placed placed;
  for (int a = 0; a < 3; ++a) {
    const Int numerator = Formula::kFromFirst ? Int(origin[a] * f.denominator + offset[a]) : offset[a];
    placed.point[a] = quotient_to_double(numerator, f.denominator, exponent);
    // In lattice steps: multiply by 2^(exponent - exponent of the lattice).
    const int shift = exponent - lattice.exponent[a];
    const Int rounded = shift >= 0 ? round_quotient(Int(numerator << shift), f.denominator)
                                   : round_quotient(numerator, Int(f.denominator << -shift));
    placed.steps[a] = static_cast<std::int32_t>(rounded);
  }
  return placed;
}

template <class Formula>
Placed place_exactly(const Formula& formula, const SeamLattice& lattice) {
  BinaryScale scale;
  for (const Vec3d& p : formula.input) scale.include(p);
  // The polynomials have degree at most 6 and fewer than 2^8 terms, and the origin adds one degree. A
  // quotient takes 64 more bits, or the shift to the lattice. Fixed-size integers need no allocation and are
  // four times as fast.
  int shift = 64;
  for (const int e : lattice.exponent)
    shift = std::max(shift, std::abs(Formula::kDegree * scale.lowest_bit() - e));
  constexpr int kBits = 1024;
  return 7 * scale.width() + 16 + shift < kBits ? place_with<exact::FixedInt>(formula, scale, lattice)
                                                : place_with<BigInt>(formula, scale, lattice);
}

/// Computes the result of place_exactly() with DoubleDoubles, if they are precise enough. `approximate` is
/// the formula's value in doubles. If all points that the result is between have the same coordinate on some
/// axis, that coordinate is used, because whole faces of models built along the axes are half-way between two
/// lattice steps. Returns false if integers are needed.
template <class Formula>
bool place_precisely(const Formula& formula, const Fraction<Approx>& approximate, const Vec3d& step,
                     Placed& placed) {
  std::array<Point<DoubleDouble>, std::tuple_size_v<decltype(formula.input)>> p;
  for (std::size_t k = 0; k < p.size(); ++k) {
    const Vec3d& q = formula.input[k];
    p[k] = {DoubleDouble(q.x), DoubleDouble(q.y), DoubleDouble(q.z)};
  }
  const Fraction<DoubleDouble> f = formula(p);
  // For each operation, the errors are at most 2^-48 times those of Approx (2^-100 of a result instead of
  // 2^-52). Underflow loses 2^-1074 each time, which grows to at most 1e-230 in polynomials of degree 7.
  const auto error_of = [](const Approx& a) { return 0x1.0p-47 * a.error + 1e-230; };
  const double den = std::fabs(f.denominator.hi), den_error = error_of(approximate.denominator);
  if (!(den > 2 * den_error)) return false;
  const std::array<DoubleDouble, 3> offset{f.numerator.x, f.numerator.y, f.numerator.z};
  const std::array<Approx, 3> about{approximate.numerator.x, approximate.numerator.y,
                                    approximate.numerator.z};
  for (int a = 0; a < 3; ++a) {
    constexpr int kFirst = Formula::kBetweenFrom, kEnd = Formula::kBetweenTo;
    bool level = kEnd > kFirst;
    for (int k = kFirst + 1; k < kEnd; ++k) level = level && formula.input[k][a] == formula.input[kFirst][a];
    if (level) {
      placed.point[a] = formula.input[kFirst][a] + 0.0;  // not negative zero
      placed.steps[a] = static_cast<std::int32_t>(std::nearbyint(placed.point[a] / step[a]));
      continue;
    }
    const DoubleDouble q = offset[a] / f.denominator;
    const DoubleDouble x = Formula::kFromFirst ? DoubleDouble(formula.input[0][a]) + q : q;
    const double error = 1.001 * (error_of(about[a]) + std::fabs(q.hi) * den_error) / (den - den_error) +
                         0x1.0p-98 * (std::fabs(q.hi) + std::fabs(x.hi));
    // quotient_to_double() truncates after 64 bits, then rounds to nearest. The result is x.hi if no value
    // within these errors rounds to another double.
    const double off = error + 0x1.0p-62 * std::fabs(x.hi);
    if (x.hi + (x.lo + off) != x.hi || x.hi + (x.lo - off) != x.hi) return false;
    placed.point[a] = x.hi;
    const double y = x.hi / step[a], k = std::nearbyint(y);
    if (!(std::fabs((y - k) + x.lo / step[a]) + error / step[a] < 0.4999999)) return false;
    placed.steps[a] = static_cast<std::int32_t>(k);
  }
  return true;
}

template <class Formula>
Placed place(const Formula& formula, const SeamLattice& lattice, const Vec3d& step) {
  std::array<Point<Approx>, std::tuple_size_v<decltype(formula.input)>> p;
  for (std::size_t k = 0; k < p.size(); ++k) {
    const Vec3d& q = formula.input[k];
    p[k] = {Approx(q.x), Approx(q.y), Approx(q.z)};
  }
  const Fraction<Approx> f = formula(p);
  // A formula is a quotient, so underflow in either polynomial matters: use bound() instead of `error`.
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
    // For measurements, a double accurate to a thousandth of a step is enough. A rounding that the error
    // cannot change equals the exact rounding.
    const double y = x / step[a], k = std::nearbyint(y);
    certain = error <= 0.001 * step[a] && std::fabs(y - k) + error / step[a] < 0.4999999;
    placed.point[a] = x;
    if (certain) placed.steps[a] = static_cast<std::int32_t>(k);
  }
  if (certain || place_precisely(formula, f, step, placed)) return placed;
  return place_exactly(formula, lattice);
}

}  // namespace fracture::clip_detail
